"""results.json → checked data. What was not measured stays absent; what is there has the right shape."""
import json
import math
import pathlib
import re

IO, INVALID = 2, 3
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*\Z")  # becomes part of element ids and file names
PNG = b"\x89PNG\r\n\x1a\n"


class ReportError(Exception):
    """A message that names the file, and the exit code."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


NUMBER, TEXT, FLAG = "a number that is not negative", "text", "true or false"
TIMING = {"median": NUMBER, "minimum": NUMBER, "maximum": NUMBER}
COUNTS = {"kind": TEXT, "segments": NUMBER, "resolved": NUMBER, "blocked": NUMBER, "clear": NUMBER, "wrong": NUMBER,
          "wrong_resolved": NUMBER, "wrong_bound_95": NUMBER}
VARIANT = {
    "id": TEXT, "label": TEXT, "behind": TEXT, "demand": FLAG, "horizons": FLAG, "hierarchy_bytes": NUMBER, "horizon_bytes": NUMBER, "method": TEXT, "depth": NUMBER, "samples": NUMBER, "render_seconds": TIMING, "shadow_seconds": TIMING,
    "tests": NUMBER, "bake_seconds": NUMBER, "bake_rays": NUMBER, "memory_bytes": NUMBER, "file_bytes": NUMBER,
    "ship_bytes": NUMBER, "segments": NUMBER, "fallback_segments": NUMBER, "resolved_segments": NUMBER, "wrong": NUMBER,
    "wrong_resolved": NUMBER, "wrong_rate": NUMBER, "wrong_bound_95": NUMBER, "rmse": NUMBER, "max_difference": NUMBER,
    "identical_image": FLAG, "nodes": {"unfolded_bytes": NUMBER, "folded_bytes": NUMBER, "shared_bytes": NUMBER},
    "kinds": [COUNTS], "images": {"shaded": TEXT, "tests": TEXT, "fallback": TEXT, "difference": TEXT}}
KIND = {"kind": TEXT, "segments": NUMBER, "share": NUMBER, "best_embree": TEXT, "embree": [{"name": TEXT, "ns": TIMING}],
        "vcd": [{"variant": TEXT, "lookup_ns": TIMING, "ns": TIMING, "hierarchy_ns": TIMING, **COUNTS}]}
NS_TIMING = {"name": TEXT, "median_ns": NUMBER, "minimum_ns": NUMBER, "maximum_ns": NUMBER, "speed_up": NUMBER}
USE = {"best_embree": TEXT, "embree": [NS_TIMING], "vcd": [NS_TIMING]}
PATHS = {"segments": NUMBER, "blocked": NUMBER, "differ": NUMBER, "judged": NUMBER, "wrong_embree": NUMBER, "single_calls": USE, "wavefronts": USE}
SCENE = {"name": TEXT, "title": TEXT, "source": TEXT, "status": TEXT, "error": TEXT, "judge": TEXT, "triangles": NUMBER,
         "instances": NUMBER, "placed_triangles": NUMBER, "objects": NUMBER, "lights": NUMBER, "shadow_segments": NUMBER,
         "bvh": {"build_seconds": NUMBER, "memory_bytes": NUMBER}, "packets": {"bvh": TEXT, "vcd": TEXT},
         "variants": [VARIANT], "kinds": [KIND], "paths": PATHS}
SETTINGS = {"profile": TEXT, "width": NUMBER, "height": NUMBER, "pixel_samples": NUMBER, "light_samples": NUMBER,
            "repetitions": NUMBER, "threads": NUMBER, "paths": NUMBER, "horizons": FLAG, "seed": NUMBER, "depths": [NUMBER], "samples": [NUMBER]}
MACHINE = {"processor": TEXT, "threads": NUMBER, "compiler": TEXT, "embree": TEXT, "embree_isa": TEXT, "system": TEXT,
           "pinned": FLAG, "memory_bytes": NUMBER}
ROOT = {"tool": TEXT, "version": TEXT, "command": TEXT, "format": NUMBER, "settings": SETTINGS, "machine": MACHINE,
        "scenes": [SCENE]}


def load(folder):
    """The checked results of a folder. ReportError: IO if it cannot be read, INVALID if it is not what it should be."""
    path = pathlib.Path(folder) / "results.json"
    data = parse(path)

    def refuse(where, problem):
        raise ReportError(INVALID, f"{path}: {where}: {problem}")

    if not isinstance(data, dict) or data.get("tool") != "vc-bench":
        refuse("tool", "these are not results of vc-bench")
    if data.get("format") != 1:
        refuse("format", f"this is {data.get('format')!r}, only 1 is known")
    check(data, ROOT, "", refuse)
    if data.get("settings", {}).get("threads") == 0:  # all of them
        data["settings"]["threads"] = data.get("machine", {}).get("threads", 0)
    if "scenes" not in data:
        refuse("scenes", "missing")
    for s, scene in enumerate(data["scenes"]):
        check_names(scene, "name", f"scenes[{s}]", data["scenes"][:s], refuse)
        variants = scene.setdefault("variants", [])
        for v, variant in enumerate(variants):
            check_names(variant, "id", f"scenes[{s}].variants[{v}]", variants[:v], refuse)
        for k, kind in enumerate(scene.setdefault("kinds", [])):
            check_names(kind, "kind", f"scenes[{s}].kinds[{k}]", scene["kinds"][:k], refuse)
    return data


def parse(path):
    """Any JSON file. NaN and Infinity are no JSON, although Python reads them."""
    def no_constant(name):
        raise ValueError(f"{name} is not JSON")

    try:
        return json.loads(pathlib.Path(path).read_text(encoding="utf-8"), parse_constant=no_constant)
    except OSError as error:
        raise ReportError(IO, f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise ReportError(INVALID, f"{path}: not valid JSON: {error}") from error


def check(value, shape, where, refuse):
    """Refuses values of another shape than the table above; keys that it does not know may be there."""
    if isinstance(shape, dict):
        if not isinstance(value, dict):
            refuse(where or "top", "expected an object")
        for key in list(value):
            if value[key] is None:
                del value[key]  # null says: not measured
            elif key in shape:
                check(value[key], shape[key], f"{where}.{key}".lstrip("."), refuse)
        if shape is TIMING and len(TIMING.keys() & value.keys()) != 3:
            refuse(where, "expected median, minimum and maximum")
    elif isinstance(shape, list):
        if not isinstance(value, list):
            refuse(where, "expected a list")
        for i, item in enumerate(value):
            check(item, shape[0], f"{where}[{i}]", refuse)
    elif shape is NUMBER:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value) or value < 0:
            refuse(where, f"expected {NUMBER}")
    elif not isinstance(value, str if shape is TEXT else bool):
        refuse(where, f"expected {shape}")


def is_name(text):
    return bool(NAME.match(text))


def check_names(item, key, where, earlier, refuse):
    if not is_name(item.get(key, "")):
        refuse(f"{where}.{key}", "expected a name of letters, digits, dots, dashes and underscores")
    if any(other[key] == item[key] for other in earlier):
        refuse(f"{where}.{key}", f"{item[key]} is there twice")


def image_bytes(folder, name):
    """One image that the results name, from inside the folder."""
    path = pathlib.Path(folder) / name
    if pathlib.PurePosixPath(name).is_absolute() or ".." in pathlib.PurePosixPath(name).parts:
        raise ReportError(INVALID, f"{folder}/results.json: {name}: images lie inside the folder")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ReportError(IO, f"{path}: cannot be read: {error.strerror}") from error
    if not content.startswith(PNG):
        raise ReportError(INVALID, f"{path}: not a PNG image")
    return content
