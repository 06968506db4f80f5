"""What follows from the measurements: one flat row per scene × variant, and one per kind of segment × variant."""
import math

MIB = 1024 * 1024
SINGLE = "bvh-single"  # the BVH, ray by ray: what the paper compares with
HIERARCHY = "hierarchy"  # the sidecar's own, without look-ups
PROVED = ("proven", "hybrid")  # methods without a number of samples


def divide(a, b):
    return a / b if a is not None and b else None


def timing(item, key):
    """(median, minimum, maximum), or three times None."""
    t = item.get(key)
    return (t["median"], t["minimum"], t["maximum"]) if t else (None, None, None)


def upper_bound_95(wrong, all_):
    """The largest share under which seeing `wrong` or fewer of `all_` still has a probability of 5 % (Poisson)."""
    if wrong is None or not all_:
        return None
    if wrong > 1000:  # Wilson and Hilferty's normal approximation of the same quantile, here good to seven digits
        k = wrong + 1
        return min(1.0, k * (1 - 1 / (9 * k) + 1.6448536269514722 / (3 * math.sqrt(k))) ** 3 / all_)

    def probability_of_so_few(mean):  # from the last term, the largest, down
        term = 1.0
        terms = [term] + [term := term * k / mean for k in range(int(wrong), 0, -1)]
        return math.exp(wrong * math.log(mean) - mean - math.lgamma(wrong + 1)) * math.fsum(terms)

    low, high = wrong + 1e-9, wrong + 10 + 5 * math.sqrt(wrong + 1)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if probability_of_so_few(middle) > 0.05 else (low, middle)
    return min(1.0, high / all_)


def method_of(variant):
    """Of a tree that takes part in the comparison. Earlier results name none: there samples say it."""
    return variant.get("method", "sampled" if "samples" in variant else None)


def label_of(variant):
    if variant.get("demand") and "depth" in variant:
        return f"for the scene, {variant['method']}, down to depth {variant['depth']}"
    if "depth" in variant and method_of(variant) in PROVED:
        return f"depth {variant['depth']}, {variant['method']}"
    if "depth" in variant and "samples" in variant:
        return f"depth {variant['depth']}, {variant['samples']} samples"
    return variant.get("label", variant["id"])


def is_sampled(row):
    """Of the paper's method."""
    return row["depth"] is not None and row["samples"] is not None and row["method"] not in PROVED


def is_configuration(row):
    return is_sampled(row) or (row["depth"] is not None and row["method"] in PROVED)


def is_for_any_scene(row):
    return is_configuration(row) and not row.get("demand")


def is_hierarchy(row):
    """Answered without a BVH: by a hierarchy alone, or behind the look-ups of a tree."""
    return row["id"] == HIERARCHY or row["behind"] is not None


def variant_row(scene, variant, bvh):
    """Every figure of one variant; None is what was not measured. Ranges of ratios come from the extremes of both."""
    render, shadow = timing(variant, "render_seconds"), timing(variant, "shadow_seconds")
    bvh_render, bvh_shadow = timing(bvh, "render_seconds"), timing(bvh, "shadow_seconds")
    nodes, get = variant.get("nodes", {}), variant.get
    is_bvh = variant["id"] == "bvh"
    return {
        "scene": scene["name"], "id": variant["id"], "label": label_of(variant),
        "method": method_of(variant), "depth": get("depth"), "samples": get("samples"),
        "render_seconds": render[0], "render_seconds_minimum": render[1], "render_seconds_maximum": render[2],
        "render_ratio": divide(render[0], bvh_render[0]),
        "shadow_seconds": shadow[0], "shadow_seconds_minimum": shadow[1], "shadow_seconds_maximum": shadow[2],
        "shadow_ratio": divide(shadow[0], bvh_shadow[0]),
        "shadow_ratio_low": divide(shadow[1], bvh_shadow[2]), "shadow_ratio_high": divide(shadow[2], bvh_shadow[1]),
        "speedup": divide(bvh_shadow[0], shadow[0]),
        "speedup_low": divide(bvh_shadow[1], shadow[2]), "speedup_high": divide(bvh_shadow[2], shadow[1]),
        "tests": get("tests"), "tests_ratio": divide(get("tests"), bvh.get("tests")),
        "bake_seconds": scene.get("bvh", {}).get("build_seconds") if is_bvh else get("bake_seconds"),
        "bake_rays": get("bake_rays"),
        "memory_bytes": scene.get("bvh", {}).get("memory_bytes") if is_bvh else get("memory_bytes"),
        "unfolded_bytes": nodes.get("unfolded_bytes"), "folded_bytes": nodes.get("folded_bytes"),
        "shared_bytes": nodes.get("shared_bytes"), "file_bytes": get("file_bytes"), "ship_bytes": get("ship_bytes"),
        "segments": get("segments"), "resolved_segments": get("resolved_segments"),
        "fallback_segments": get("fallback_segments"), "resolved_share": divide(get("resolved_segments"), get("segments")),
        "wrong": get("wrong"), "wrong_resolved": get("wrong_resolved"), "wrong_rate": get("wrong_rate"),
        "wrong_bound_95": get("wrong_bound_95"), "rmse": get("rmse"), "max_difference": get("max_difference"),
        "identical_image": get("identical_image"), "behind": get("behind"), "demand": bool(get("demand")),
        "horizons": bool(get("horizons")), "hierarchy_bytes": get("hierarchy_bytes"), "horizon_bytes": get("horizon_bytes"),
        "hierarchy_bytes_a_triangle": divide(get("hierarchy_bytes"), scene.get("triangles")),
        "horizon_bytes_a_triangle": divide(get("horizon_bytes"), scene.get("triangles"))}


def counts(item):
    """Shares of one kind's counts: wrong of all, wrong of the segments that the sidecar answered, and their bounds."""
    segments, resolved, wrong = item.get("segments"), item.get("resolved"), item.get("wrong")
    answered = item.get("wrong_resolved", wrong)
    return {"segments": segments, "resolved": resolved, "blocked": item.get("blocked"), "clear": item.get("clear"),
            "resolved_share": divide(resolved, segments), "wrong": wrong, "wrong_rate": divide(wrong, segments),
            "wrong_bound_95": item.get("wrong_bound_95"), "wrong_resolved": answered,
            "wrong_resolved_rate": divide(answered, resolved),
            "wrong_resolved_bound_95": upper_bound_95(answered, resolved)}


def kind_rows(scene):
    """Recorded segments of one kind, timed: the fastest way of Embree against look-up, look-up with fallback, and with the own hierarchy."""
    rows = []
    variants = {v["id"]: v for v in scene["variants"]}
    for kind in scene["kinds"]:
        best = next((e for e in kind.get("embree", []) if e.get("name") == kind.get("best_embree")), {})
        embree = timing(best, "ns")
        single = next((timing(e, "ns")[0] for e in kind.get("embree", []) if e.get("name") == "rtcOccluded1"), None)
        for item in kind.get("vcd", []):
            variant = variants.get(item.get("variant"), {"id": item.get("variant", "unknown")})
            look_up, whole, hierarchy = timing(item, "lookup_ns"), timing(item, "ns"), timing(item, "hierarchy_ns")[0]
            rows.append({
                "scene": scene["name"], "kind": kind["kind"], "id": variant["id"], "label": label_of(variant),
                "method": method_of(variant), "depth": variant.get("depth"), "samples": variant.get("samples"), "share": kind.get("share"),
                "embree": best.get("name"), "embree_ns": embree[0], "embree_ns_minimum": embree[1],
                "embree_ns_maximum": embree[2], "lookup_ns": look_up[0], "ns": whole[0], "ns_minimum": whole[1],
                "ns_maximum": whole[2], "ratio": divide(embree[0], whole[0]),
                "single_ratio": divide(single, whole[0]), "hierarchy_ns": hierarchy,
                "hierarchy_ratio": divide(embree[0], hierarchy), **counts(item)})
    return rows


def way_rows(scene):
    """What each of Embree's ways takes for segments of one kind."""
    return [{"id": kind["kind"], "label": kind["kind"], "segments": kind.get("segments"), "best": kind.get("best_embree"),
             **{e.get("name"): timing(e, "ns")[0] for e in kind.get("embree", [])}} for kind in scene["kinds"]]


def image_kind_rows(scene):
    """The shadow rays of one whole image, by kind."""
    return [{"scene": scene["name"], "kind": item["kind"], "id": v["id"], "label": label_of(v), "depth": v.get("depth"),
             "samples": v.get("samples"), **counts(item)} for v in scene["variants"] for item in v.get("kinds", [])]


USES = ("single_calls", "wavefronts")  # of the shadow rays of a path tracer


def path_rows(scene, use):
    """The shadow rays of a path tracer: all that was asked without Embree, and Embree's fastest way."""
    paths, rows = scene.get("paths", {}), []
    times = paths.get(use, {})
    variants = {v["id"]: v for v in scene["variants"]}
    embree = next((t for t in times.get("embree", []) if t["name"] == times["best_embree"]), None)
    for timed in ([{**embree, "name": "bvh"}] if embree else []) + times.get("vcd", []):
        if timed["name"] not in variants:  # look-ups with Embree behind them: they are charted with pictures
            continue
        wrong = paths.get("wrong_embree") if timed["name"] == "bvh" else paths.get("wrong", {}).get(timed["name"])
        rows.append({
            **variant_row(scene, variants[timed["name"]], {"id": "bvh"}), "use": use, "embree": embree["name"], "segments": paths.get("segments"),
            "ns": timed["median_ns"], "embree_ns": embree["median_ns"], "speedup": timed["speed_up"],
            "speedup_low": divide(embree["minimum_ns"], timed["maximum_ns"]), "speedup_high": divide(embree["maximum_ns"], timed["minimum_ns"]),
            "judged": paths.get("judged"), "wrong": wrong, "wrong_rate": divide(wrong, paths.get("judged")),
            "wrong_bound_95": upper_bound_95(wrong, paths.get("judged"))})
    return rows


def scene_figures(scene):
    bvh = next((v for v in scene["variants"] if v["id"] == "bvh"), {"id": "bvh"})
    return {
        "name": scene["name"], "title": scene.get("title", scene["name"]), "status": scene.get("status", "unknown"),
        "error": scene.get("error"), "judge": scene.get("judge", "Embree"), "source": scene.get("source"), "triangles": scene.get("triangles"),
        "instances": scene.get("instances"), "placed_triangles": scene.get("placed_triangles"),
        "objects": scene.get("objects"), "lights": scene.get("lights"), "shadow_segments": scene.get("shadow_segments"),
        "bvh_build_seconds": scene.get("bvh", {}).get("build_seconds"),
        "bvh_memory_bytes": scene.get("bvh", {}).get("memory_bytes"),
        "packets_bvh": scene.get("packets", {}).get("bvh"), "packets_vcd": scene.get("packets", {}).get("vcd"),
        "variants": [variant_row(scene, v, bvh) for v in scene["variants"]],
        "kinds": kind_rows(scene), **{use: path_rows(scene, use) for use in USES}, "ways": way_rows(scene), "image_kinds": image_kind_rows(scene)}


def short_setting(results):
    """One line that stands under every figure: how and on what it was measured."""
    s, m = results.get("settings", {}), results.get("machine", {})
    parts = []
    if "width" in s and "height" in s:
        parts.append(f"{s['width']} × {s['height']} pixels")
    for key, text in (("pixel_samples", "{} samples a pixel"), ("light_samples", "{} shadow rays a light"),
                      ("repetitions", "median of {}"), ("threads", "{} threads")):
        if key in s:
            parts.append(text.format(s[key]))
    embree = " ".join(["Embree", m["embree"], m.get("embree_isa", "")]).strip() if "embree" in m else None
    parts += [p for p in (m.get("processor"), m.get("compiler"), embree) if p]
    return " · ".join(parts)
