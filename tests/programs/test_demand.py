"""Demands as users meet them. The files here are written from spec/demand.md alone."""
import base64
import json
import pathlib
import random
import re
import struct
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "spec" / "reader"), str(ROOT / "tests" / "programs")]

from case import Case, soup
from xxh3 import xxh3_64

HASHES = [bytes([number] * 16) for number in (3, 7)]


def demand_bytes(objects, version=(1, 0)):
    """objects: geometry hash → list of (origin, t_min, direction, t_max, weight)."""
    table, segments = b"", b""
    for geometry_hash, asked in sorted(objects.items()):
        packed = [struct.pack("<8fd", *origin, t_min, *direction, t_max, weight)
                  for origin, t_min, direction, t_max, weight in asked]
        own = b"".join(sorted(packed, key=lambda s: struct.unpack("<8I", s[:32])))
        table += geometry_hash + struct.pack("<QQ", len(asked), xxh3_64(own))
        segments += own
    header = b"\x89VCA\r\n\x1a\n" + struct.pack("<HHIQQ24x", *version, len(objects), 64 + len(table) + len(segments), xxh3_64(table))
    return header + struct.pack("<Q", xxh3_64(header)) + table + segments


def segment(number, weight=1):
    return ((number, 0.5, -1), 0, (0, 0.25, 2), float("inf"), weight)


class Demands(Case):
    def demand(self, name, objects, **options):
        path = self.folder / name
        path.write_bytes(demand_bytes(objects, **options))
        return path

    def shown(self, path):
        found, = json.loads(self.run_program("vc-info", path, "--format", "json").stdout)["files"]
        return {entry["geometry_hash"]: (entry["segments"], entry["weight"]) for entry in found["demand"]}

    def test_are_shown_merged_and_thinned(self):
        a = self.demand("a.demand", {HASHES[0]: [segment(1), segment(-2, 3)], HASHES[1]: [segment(0)]})
        b = self.demand("b.demand", {HASHES[0]: [segment(1, 4), segment(5)]})
        self.assertIn("2 segments that stand for 4", self.run_program("vc-info", a).stdout)
        self.assertEqual(self.shown(a), {HASHES[0].hex(): (2, 4), HASHES[1].hex(): (1, 1)})
        self.run_program("vc-info", a, b, "--merge", self.folder / "ab.demand")
        self.run_program("vc-info", b, a, "--merge", self.folder / "ba.demand")
        self.assertEqual(self.shown(self.folder / "ab.demand"), {HASHES[0].hex(): (3, 9), HASHES[1].hex(): (1, 1)})
        merged = (self.folder / "ab.demand").read_bytes()
        self.assertEqual(merged, (self.folder / "ba.demand").read_bytes())
        self.assertEqual(merged, demand_bytes({HASHES[0]: [segment(1, 5), segment(-2, 3), segment(5)], HASHES[1]: [segment(0)]}))
        thinned = self.folder / "thinned.demand"
        self.run_program("vc-info", a, b, "--merge", thinned, "--most-segments", 2, "-q")
        self.assertEqual(sum(count for count, _ in self.shown(thinned).values()), 2)

    def test_that_are_none_or_damaged_say_so_and_leave_nothing(self):
        good = self.demand("good.demand", {HASHES[0]: [segment(1)]})
        damaged = self.folder / "damaged.demand"
        damaged.write_bytes(good.read_bytes()[:-1])
        later = self.demand("later.demand", {HASHES[0]: [segment(1)]}, version=(2, 0))
        before = self.files()
        for path, code, message in ((damaged, 3, "by its header"), (later, 5, "version 1"), (self.mesh(), 3, "not a demand"), (self.folder / "absent", 2, "absent")):
            done = self.run_program("vc-info", good, path, "--merge", self.folder / "out.demand", code=code)
            self.assertIn(message, done.stderr)
        self.assertIn("by its header", self.run_program("vc-info", damaged, code=3).stderr)
        self.run_program("vc-info", good, "--merge", self.folder / "out.vcd", code=1)
        self.run_program("vc-info", good, "--merge", self.folder / "tetrahedron.obj", code=1)
        self.assertEqual(self.files(), sorted(before + ["tetrahedron.obj"]))


def shadow_rays(seed, count=3000):
    """From a floor below soup()'s box to a light above it."""
    rng = random.Random(seed)
    rays = []
    for _ in range(count):
        origin = struct.unpack("<3f", struct.pack("<3f", rng.uniform(1, 3), -1, rng.uniform(1, 3)))
        rays.append((origin, 0, (rng.uniform(-1, 1), 8, rng.uniform(-1, 1)), 1, 1))
    return rays


class BakesForADemand(Case):
    def setUp(self):
        super().setUp()
        self.soup = self.mesh("soup.obj", soup(60))
        self.run_program("vc-bake", self.soup, "-q", "--depth", 1, "--audit", 0)
        self.hash = bytes.fromhex(self.object()["geometry_hash"])
        self.demand = self.folder / "scene.demand"
        self.demand.write_bytes(demand_bytes({self.hash: shadow_rays(1)}))

    def shown(self, *options):
        return json.loads(self.run_program("vc-info", f"{self.soup}.vcd", "--format", "json", *options).stdout)["files"][0]

    def object(self, *options):
        return self.shown(*options)["objects"][0]

    def bake(self, *options, code=0):
        return self.run_program("vc-bake", self.soup, "--for", self.demand, "--audit", 3000, "--method", "proven", "--budget-mb", 0.5, *options, code=code)

    def test_say_what_was_kept_out_and_answered(self):
        text = self.bake().stdout
        self.assertRegex(text, r"demand    [0-9.]+ % of what was kept out of the bake answered: \d+ segments, 0 wrong")
        found = self.shown()
        self.assertGreater(found["objects"][0]["depth"], 4)
        line = found["provenance"]["demand"]
        kept, share = re.fullmatch(r"0 kept-out=(\d+) answered=([0-9.]+) wrong=0\n", line).groups()
        self.assertAlmostEqual(int(kept) / 3000, 1 / 8, delta=0.03)
        report = json.loads(self.bake("--format", "json").stdout)["files"][0]["objects"][0]["demand"]
        self.assertEqual(report["kept_out"], int(kept))
        self.assertAlmostEqual(report["answered"], float(share), places=5)
        other = self.folder / "other.demand"
        other.write_bytes(demand_bytes({self.hash: shadow_rays(2)}))
        asked = self.object("--asked", other)["asked"]
        self.assertEqual(asked["segments"], 3000)
        self.assertAlmostEqual(asked["answered"], float(share), delta=0.1)
        self.assertIn("of their weight answered", self.run_program("vc-info", f"{self.soup}.vcd", "--asked", other).stdout)
        self.run_program("vc-bake", self.soup, "-q", "--depth", 4, "--audit", 0, "--method", "proven")
        self.assertLess(self.object("--asked", other)["asked"]["answered"], asked["answered"])
        self.run_program("vc-verify", f"{self.soup}.vcd", "--against", self.soup, "--lines", 9000)

    def test_are_the_same_for_any_number_of_threads_and_keep_to_their_budget(self):
        files = set()
        for threads in (1, 3):
            self.bake("-q", "-j", threads, "--depth", 8)
            files.add(pathlib.Path(f"{self.soup}.vcd").read_bytes())
        self.assertEqual(len(files), 1)
        self.assertLess(len(files.pop()), 0.5 * 2**20)

    def test_are_up_to_date_as_long_as_the_demand_is_the_same(self):
        self.bake("-q", "--cache", self.folder / "cache")
        before = pathlib.Path(f"{self.soup}.vcd").read_bytes()
        renamed = self.demand.rename(self.folder / "renamed.demand")
        self.demand = renamed
        self.assertIn("nothing to do", self.bake("--update", "--dry-run").stdout)
        pathlib.Path(f"{self.soup}.vcd").unlink()
        self.bake("-q", "--cache", self.folder / "cache")
        self.assertEqual(pathlib.Path(f"{self.soup}.vcd").read_bytes(), before, "out of the cache, with the same share answered")
        renamed.write_bytes(demand_bytes({self.hash: shadow_rays(3)}))
        self.assertIn("made with other settings", self.bake("--update", "--dry-run").stdout)
        self.bake("-q", "--depfile", self.folder / "soup.d")
        self.assertIn("renamed.demand", (self.folder / "soup.d").read_text())

    def test_update_classifies_nothing_again_that_is_known(self):
        classified = lambda *options: json.loads(self.bake("--depth", 6, "--format", "json", *options).stdout)["files"][0]["objects"][0]["cells_classified"]
        before = classified()
        other = self.folder / "other.demand"
        other.write_bytes(demand_bytes({self.hash: shadow_rays(2)}))
        self.run_program("vc-info", self.demand, other, "--merge", self.folder / "both.demand", "-q")
        self.demand = self.folder / "both.demand"
        more = classified("--update")
        pathlib.Path(f"{self.soup}.vcd").unlink()
        anew = classified()
        self.assertLess(more, 0.8 * anew)
        self.assertGreater(before, 0)

    def test_of_a_library_fail_where_nothing_is_asked(self):
        document = self.folder / "two.manifest.json"
        other = self.mesh("other.obj", soup(50, seed=4))
        document.write_text(json.dumps({"vcd_manifest": 1, "settings": {"for": "scene.demand", "audit": 0}, "assets": [{"input": "soup.obj"}, {"input": "other.obj"}]}))
        done = self.run_program("vc-bake", "--manifest", document, code=9)
        self.assertIn("asks nothing of", done.stderr)
        self.assertTrue(pathlib.Path(f"{self.soup}.vcd").exists())
        self.assertFalse(pathlib.Path(f"{other}.vcd").exists())

    def test_leave_objects_of_a_file_without_cells_that_nobody_asks(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
        data = b"".join(struct.pack("<3f", *(size * x for x in p)) for size in (1, 2) for p in corners) + struct.pack("<12H", *faces)
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        view = lambda offset, size: {"buffer": 0, "byteOffset": offset, "byteLength": size}
        points = lambda v: {"bufferView": v, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 2]}
        gltf = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": len(data)}],
                "bufferViews": [view(0, 48), view(48, 48), view(96, 24)],
                "accessors": [points(0), points(1), {"bufferView": 2, "componentType": 5123, "count": 12, "type": "SCALAR"}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": mesh}, "indices": 2}]} for mesh in (0, 1)]}
        two = self.mesh("two.gltf", json.dumps(gltf))
        self.run_program("vc-bake", two, "-q", "--depth", 2, "--audit", 0)
        objects = lambda: json.loads(self.run_program("vc-info", f"{two}.vcd", "--format", "json").stdout)["files"][0]["objects"]
        second = bytes.fromhex(objects()[1]["geometry_hash"])
        rays = [((0.01 * i, 0.3, -1), 0, (0, 0, 1), 5, 1) for i in range(100)]
        self.demand.write_bytes(demand_bytes({second: rays}))
        done = self.run_program("vc-bake", two, "--for", self.demand, "--audit", 0, "--depth", 4)
        self.assertIn("object 0 has no cells: the demand asks nothing of it", done.stdout + done.stderr)
        self.assertEqual([found["method"] for found in objects()], ["none", "hybrid"])

    def test_of_lights_need_no_renderer(self):
        uri, floats = "data:application/octet-stream;base64,", []
        for line in self.soup.read_text().splitlines():
            if line.startswith("v "):
                floats += map(float, line.split()[1:4])
        data = struct.pack(f"<{len(floats)}f", *floats)
        lights = {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}}
        down = {"rotation": [-(0.5 ** 0.5), 0, 0, 0.5 ** 0.5], "extensions": {"KHR_lights_punctual": {"light": 0}}}
        gltf = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri + base64.b64encode(data).decode(), "byteLength": len(data)}],
                "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(floats) // 3, "type": "VEC3",
                               "min": [min(floats[i::3]) for i in range(3)], "max": [max(floats[i::3]) for i in range(3)]}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}, down], "extensions": lights}
        scene = self.mesh("scene.gltf", json.dumps(gltf))
        options = ("--audit", 3000, "--method", "proven", "--budget-mb", 0.1)
        done = self.run_program("vc-bake", scene, "--for-lights", *options)
        self.assertRegex(done.stdout, r"demand    [0-9.]+ % of what was kept out")
        once = pathlib.Path(f"{scene}.vcd").read_bytes()
        self.run_program("vc-bake", scene, "--for-lights", *options, "-j", 1)
        self.assertEqual(pathlib.Path(f"{scene}.vcd").read_bytes(), once)
        self.assertIn("nothing to do", self.run_program("vc-bake", scene, "--for-lights", *options, "--update", "--dry-run").stdout)
        self.assertIn("exclude", self.run_program("vc-bake", scene, "--for-lights", "--for-above", "y", *options, code=1).stderr)
        gltf["nodes"][1]["rotation"][0] *= -1  # the sun shines up now: the same object is asked otherwise
        scene.write_text(json.dumps(gltf))
        self.assertIn("throws a shadow", self.run_program("vc-bake", scene, "--for-lights", "--update", *options, code=1).stderr)
        del gltf["nodes"][1], gltf["extensions"]
        scene.write_text(json.dumps(gltf))
        self.assertIn("has no lights", self.run_program("vc-bake", scene, "--for-lights", *options, code=1).stderr)
        self.assertIn("has no lights", self.run_program("vc-bake", self.soup, "--for-lights", *options, code=1).stderr)

    def test_from_above_need_no_scene(self):
        options = ("-q", "--audit", 3000, "--method", "proven", "--budget-mb", 0.1)
        found = []
        for axis in "yz":
            self.run_program("vc-bake", self.soup, "--for-above", axis, *options)
            shown = self.shown()
            self.assertEqual(json.loads(shown["provenance"]["settings"])["for-above"], axis)
            self.assertGreater(float(re.search("answered=([0-9.]+)", shown["provenance"]["demand"])[1]), 0.3)
            found.append(pathlib.Path(f"{self.soup}.vcd").read_bytes())
        self.assertNotEqual(*found)
        self.run_program("vc-bake", self.soup, "--for-above", "up", *options, code=1)

    def test_objects_of_a_file_share_its_bytes_by_what_they_gain(self):
        floats = [float(x) for line in soup(60).splitlines() if line.startswith("v ") for x in line.split()[1:4]]
        data = struct.pack(f"<{len(floats)}f", *floats)
        accessor = {"bufferView": 0, "componentType": 5126, "type": "VEC3", "min": [-9] * 3, "max": [9] * 3}
        counts = (len(floats) // 3, 60)  # all triangles, and the first twenty
        gltf = {"asset": {"version": "2.0"}, "accessors": [{**accessor, "count": n} for n in counts],
                "buffers": [{"uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(), "byteLength": len(data)}],
                "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": i}}]} for i in range(2)]}
        scene = self.mesh("two.gltf", json.dumps(gltf))
        options = ("--for-above", "y", "--audit", 3000, "--method", "proven", "-d", 6)
        sizes = {}
        for megabytes in (0.5, 1):
            self.run_program("vc-bake", scene, *options, "--total-mb", megabytes)
            done = self.run_program("vc-info", f"{scene}.vcd", "--format", "json").stdout
            sizes[megabytes] = [o["blocks"]["bricks"] for o in json.loads(done)["files"][0]["objects"]]
            self.assertLessEqual(pathlib.Path(f"{scene}.vcd").stat().st_size, megabytes * 2 ** 20)
        self.assertGreater(sum(sizes[1]), 1.2 * sum(sizes[0.5]))
        once = pathlib.Path(f"{scene}.vcd").read_bytes()
        self.run_program("vc-bake", scene, *options, "--total-mb", 1, "-j", 1)
        self.assertEqual(pathlib.Path(f"{scene}.vcd").read_bytes(), once)
        self.assertIn("nothing to do", self.run_program("vc-bake", scene, *options, "--total-mb", 1, "--update", "--dry-run").stdout)
        self.assertIn("bytes, more than --total-mb", self.run_program("vc-bake", scene, *options, "--total-mb", 0.3, code=1).stderr)
        self.assertIn("need --for", self.run_program("vc-bake", scene, "--total-mb", 1, code=1).stderr)
        self.assertIn("need --for", self.run_program("vc-bake", scene, "--depth-elsewhere", 5, code=1).stderr)

    def sharers(self, **triangles):
        """A folder of meshes, and the options that bake it for what is asked of them."""
        folder = self.folder / "sharers"
        folder.mkdir()
        for name, count in triangles.items():
            (folder / f"{name}.obj").write_text(soup(count))
        self.run_program("vc-bake", folder, "-q", "--depth", 1, "--audit", 0)
        shown = json.loads(self.run_program("vc-info", *folder.glob("*.vcd"), "--format", "json").stdout)["files"]
        hashes = [bytes.fromhex(file["objects"][0]["geometry_hash"]) for file in shown]
        self.demand.write_bytes(demand_bytes({h: shadow_rays(i) for i, h in enumerate(hashes)}))
        return folder, ("--for", self.demand, "--audit", 0, "--method", "proven")

    def test_files_of_a_run_share_its_bytes(self):
        folder, options = self.sharers(large=60, small=20)
        sidecars = [folder / f"{name}.obj.vcd" for name in ("large", "small")]
        bake = lambda *more, code=0: self.run_program("vc-bake", folder, *options, "-d", 5, *more, code=code)
        sizes = {}
        for megabytes in (0.5, 0.6):
            bake("--total-mb", megabytes)
            sizes[megabytes] = [path.stat().st_size for path in sidecars]
            self.assertLessEqual(sum(sizes[megabytes]), megabytes * 2 ** 20)
        self.assertGreater(sum(sizes[0.6]), 0.5 * 2 ** 20)  # so the smaller total was shared
        for size, less in zip(sizes[0.6], sizes[0.5]):
            self.assertGreaterEqual(size, less)
        once = sidecars[0].read_bytes()
        self.assertIn("2 up to date", bake("--total-mb", 0.6, "--update").stdout)
        # If one is baked, all are, with the shares of a fresh run.
        sidecars[1].unlink()
        self.assertIn("2 baked", bake("--total-mb", 0.6, "--update", "-j", 1).stdout)
        self.assertEqual(sidecars[0].read_bytes(), once)
        # Too small a total leaves everything as it is; one that fails does not keep the others from sharing.
        self.assertIn("more than that", bake("--total-mb", 0.3, code=9).stderr)
        self.assertEqual(sidecars[0].read_bytes(), once)
        (folder / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
        done = bake("--total-mb", 0.6, code=9)
        self.assertIn("2 baked, 0 up to date, 1 failed", done.stdout)
        self.assertEqual(done.stderr.count("broken.obj:"), 1)
        self.assertEqual(sidecars[0].read_bytes(), once)
        for path in sidecars:
            path.unlink()
        done = bake("--total-mb", 0.6, "--fail-fast", code=9)
        self.assertIn("large.obj: not run", done.stderr)
        self.assertEqual(list(folder.glob("*.vcd")), [])
        plan = ("vc-farm", "plan", self.folder / "plan", folder / "large.obj", folder / "small.obj", *options, "--total-mb", 1)
        self.assertIn("each shard is a run", self.run_program(*plan, "--shards", 2, code=1).stderr)

    def test_depths_become_less_where_all_together_take_too_much(self):
        folder, options = self.sharers(a=60, b=40, c=20)
        self.run_program("vc-bake", folder, *options, "--total-mb", 0.4)
        self.assertLessEqual(sum(file.stat().st_size for file in folder.glob("*.vcd")), 0.4 * 2 ** 20)
        self.run_program("vc-verify", folder)

    def test_elsewhere_a_bake_can_be_deeper(self):
        clear = []
        for elsewhere in ("none", 4):
            self.run_program("vc-bake", self.soup, "--for", self.demand, "--audit", 3000, "-d", 6, "--depth-elsewhere", elsewhere, "--budget-mb", 3)
            clear.append(self.object()["cells"]["clear"])
        self.assertGreater(clear[1], clear[0])
        for depth in ("auto", 8):
            options = ("--for", self.demand, "--depth", depth, "--depth-elsewhere", 6, "--budget-mb", 0.3)
            self.assertIn("depth 6 everywhere takes more", self.run_program("vc-bake", self.soup, *options, code=1).stderr)

    def test_that_cannot_be_say_so_and_write_nothing(self):
        pathlib.Path(f"{self.soup}.vcd").unlink()
        self.assertIn("--plan forecasts no bake for a demand", self.bake("--plan", code=1).stderr)
        self.assertIn("2 to 8", self.bake("--depth", 1, code=1).stderr)
        good = self.demand.read_bytes()
        self.demand.write_bytes(good[:-8])
        self.assertIn("by its header", self.bake(code=3).stderr)
        self.demand.write_bytes(demand_bytes({HASHES[0]: [segment(1)]}))
        self.assertIn("asks nothing of", self.bake(code=1).stderr)
        self.demand.write_bytes(demand_bytes({self.hash: [((50, 50, 50), 0, (1, 0, 0), 1, 1)]}))
        self.assertIn("none of the demand's 1 segments enters its box", self.bake(code=1).stderr)
        self.demand.write_bytes(good)
        self.bake("--report", self.demand.with_suffix(""), code=0)
        self.assertEqual(self.demand.read_bytes(), good)
        self.bake("--events", self.demand, code=1)
        self.assertEqual(self.demand.read_bytes(), good)
        self.demand.unlink()
        self.assertIn("a file that can be read", self.bake(code=1).stderr)


del Case  # it has no tests of its own

if __name__ == "__main__":
    unittest.main()
