"""vc-bench: what its measurements say, that a run over scenes goes on where it stopped, and what it refuses."""
import json
import math
import os
import shutil
import signal
import subprocess
import time
import unittest

from case import BIN, Case, soup

SMALL = ("--size", "24x16", "--repetitions", "1", "--trees", "2x16,3x81", "-q")
SCENES = ("--scene", "forest,instances=4,species=2,leaves=30")


def timed(*trees):
    """The variants of a scene with these trees: each with Embree behind it and with its hierarchy."""
    return {"bvh", "bvh-single", "unclassified", "hierarchy", *trees, *(f"{t}-hierarchy" for t in trees)}


def ball(rings=8, sides=12):
    """The text of an OBJ file: a sphere, of which horizons see most."""
    points = [(math.sin(math.pi * r / rings) * math.cos(2 * math.pi * s / sides), math.cos(math.pi * r / rings),
               math.sin(math.pi * r / rings) * math.sin(2 * math.pi * s / sides)) for r in range(rings + 1) for s in range(sides)]
    at = lambda r, s: 1 + r * sides + s % sides
    faces = [f"f {at(r, s)} {at(r, s + 1)} {at(r + 1, s + 1)} {at(r + 1, s)}" for r in range(rings) for s in range(sides)]
    return "\n".join([f"v {x} {y} {z}" for x, y, z in points] + faces) + "\n"


class PaperRun(Case):
    def setUp(self):
        super().setUp()
        self.leaves = self.mesh("leaves.obj", soup(40))
        self.out = self.folder / "out"

    def bench(self, *arguments, code=0, **options):
        # The report has tests of its own, and a browser's patience.
        environment = {**os.environ, "VCD_PYTHON": "/bin/true", **options.pop("env", {})}
        return self.run_program("vc-bench", *arguments, *SMALL, "-o", self.out, code=code, env=environment, **options)

    def results(self):
        return json.loads((self.out / "results.json").read_text())

    def test_measures_all_there_is_to_know_of_a_scene(self):
        self.bench("--scene", f"leaves={self.leaves}", *SCENES)
        results = self.results()
        self.assertEqual([s["name"] for s in results["scenes"]], ["leaves", "forest"])
        for scene in results["scenes"]:
            self.assertEqual(scene["status"], "complete")
            variants = {v["id"]: v for v in scene["variants"]}
            self.assertEqual(set(variants), timed("d2-n16", "d3-n81"))
            for v in variants.values():
                self.assertLessEqual(v["render_seconds"]["minimum"], v["render_seconds"]["median"])
                self.assertGreater(v["shadow_seconds"]["median"], 0)
            self.assertTrue(all(k["wrong_resolved"] == 0 for k in variants["unclassified"]["kinds"]))
            self.assertEqual(scene["judge"], "exact arithmetic")
            self.assertEqual(variants["hierarchy"]["wrong"], 0)
            if scene["name"] == "leaves":  # frames of instances are rounded otherwise than Embree's
                self.assertTrue(variants["unclassified"]["identical_image"])
                self.assertEqual(variants["unclassified"]["max_difference"], 0)
                self.assertEqual(variants["unclassified"]["wrong"], variants["bvh"]["wrong"])
            for name in timed("d2-n16", "d3-n81") - {"bvh", "bvh-single", "unclassified", "d2-n16", "d3-n81"}:
                v = variants[name]
                self.assertEqual((v["segments"], v["fallback_segments"]), (scene["shadow_segments"], 0))
                self.assertEqual(v["wrong"], sum(k["wrong"] for k in v["kinds"]))
                self.assertEqual(v.get("behind"), {"hierarchy": None}.get(name, name.removesuffix("-hierarchy")))
            # A sidecar without classes answers only what passes every box by.
            self.assertTrue(all(k["blocked"] == 0 for k in variants["unclassified"]["kinds"]))
            for name in ("d2-n16", "d3-n81", "unclassified"):
                v = variants[name]
                for total, part in (("segments", "segments"), ("resolved_segments", "resolved"), ("wrong", "wrong")):
                    self.assertEqual(v[total], sum(k[part] for k in v["kinds"]))
                self.assertEqual(v["segments"], scene["shadow_segments"])
                self.assertEqual(v["segments"], v["resolved_segments"] + v["fallback_segments"])
                self.assertLessEqual(v["tests"], variants["bvh"]["tests"])
                for image in v["images"].values():
                    self.assertTrue((self.out / image).read_bytes().startswith(b"\x89PNG"))
            self.assertAlmostEqual(sum(k["share"] for k in scene["kinds"]), 1)
            for kind in scene["kinds"]:
                fastest = min(kind["embree"], key=lambda e: e["ns"]["median"])
                self.assertEqual(kind["best_embree"], fastest["name"])
                self.assertEqual([v["variant"] for v in kind["vcd"]], ["d2-n16", "d3-n81"])
                for v in kind["vcd"]:
                    self.assertEqual(v["segments"], kind["segments"])
            paths, names = scene["paths"], timed("d2-n16", "d3-n81") - {"bvh", "bvh-single", "unclassified", "d2-n16", "d3-n81"}
            self.assertEqual(set(paths["wrong"]), names)
            self.assertEqual(paths["wrong"]["hierarchy"], 0)
            for use in ("single_calls", "wavefronts"):
                self.assertEqual({v["name"] for v in paths[use]["vcd"]} - {"look-ups, then rtcOccluded1"}, names)
        ways = {e["name"] for e in results["scenes"][0]["kinds"][0]["embree"]}
        self.assertEqual(ways, {f"rtcOccluded{w}{c}" for w in (1, 8, 16) for c in ("", ", coherent")})

    def test_horizons_are_baked_where_they_are_asked_for_and_change_no_picture(self):
        mesh = self.mesh("ball.obj", ball())
        trees = [*SMALL[:-2], "2x16,3xproven", "-q", "-o", self.out, "--horizons"]
        self.run_program("vc-bench", "--scene", f"ball={mesh}", *trees, env={**os.environ, "VCD_PYTHON": "/bin/true"})
        scene = self.results()["scenes"][0]
        variants = {v["id"]: v for v in scene["variants"]}
        self.assertEqual(set(variants), timed("d2-n16", "d3-proven") | {"d3-proven-horizons"})
        self.assertEqual(variants["d3-proven-horizons"]["behind"], "d3-proven")
        self.assertEqual(variants["d3-proven-horizons"]["wrong"], 0)
        self.assertEqual(variants["d3-proven-horizons"]["rmse"], variants["hierarchy"]["rmse"])
        self.assertEqual(variants["d2-n16"]["horizon_bytes"], 0)
        for section in ("horizon_bytes", "hierarchy_bytes"):
            self.assertGreater(variants["d3-proven"][section], 0)
        self.assertIn("d3-proven-horizons", scene["paths"]["wrong"])

    def test_trees_for_a_demand_are_baked_for_other_rays_and_say_so(self):
        trees = [*SMALL[:-2], "2x16,demandxproven,demandxhybrid", "--budget-mb", "0.1", "-q", "-o", self.out]
        self.run_program("vc-bench", "--scene", f"leaves={self.leaves}", *trees, env={**os.environ, "VCD_PYTHON": "/bin/true"})
        variants = {v["id"]: v for v in self.results()["scenes"][0]["variants"]}
        self.assertEqual(set(variants), timed("d2-n16", "demand-proven", "demand-hybrid"))
        for name in ("demand-proven", "demand-hybrid"):
            self.assertTrue(variants[name]["demand"])
            self.assertGreater(variants[name]["depth"], 1)
            self.assertGreater(variants[name]["resolved_segments"], 0)
        self.assertEqual(variants["demand-proven-hierarchy"]["wrong"], 0)
        self.assertNotIn("demand", variants["d2-n16"])

    def test_the_same_command_again_measures_nothing_again(self):
        self.bench(*SCENES)
        before, sidecars = self.results(), {p: p.stat().st_mtime_ns for p in (self.out / "sidecars").iterdir()}
        self.bench(*SCENES)
        self.assertEqual(before, self.results() | {"command": before["command"]})
        self.assertEqual(sidecars, {p: p.stat().st_mtime_ns for p in (self.out / "sidecars").iterdir()})

    def test_a_further_tree_is_added_and_all_are_timed_again_together(self):
        self.bench(*SCENES)
        first = {v["id"]: v for v in self.results()["scenes"][0]["variants"]}
        self.run_program("vc-bench", *SCENES, *SMALL[:-2], "2x16,3x81,3x16", "-q", "-o", self.out, env={**os.environ, "VCD_PYTHON": "/bin/true"})
        second = {v["id"]: v for v in self.results()["scenes"][0]["variants"]}
        self.assertEqual(set(second) - set(first), {"d3-n16", "d3-n16-hierarchy"})
        self.assertEqual(first["d3-n81"]["bake_seconds"], second["d3-n81"]["bake_seconds"])
        self.assertNotEqual(first["d3-n81"]["render_seconds"], second["d3-n81"]["render_seconds"])

    def test_trees_of_an_earlier_run_stay_and_are_timed_again_with_the_new_one(self):
        self.bench(*SCENES)
        self.run_program("vc-bench", *SCENES, *SMALL[:-2], "2x81", "-q", "-o", self.out, env={**os.environ, "VCD_PYTHON": "/bin/true"})
        scene = self.results()["scenes"][0]
        self.assertEqual({v["id"] for v in scene["variants"] if "render_seconds" in v},
                         timed("d2-n16", "d3-n81", "d2-n81"))
        self.assertEqual({v["variant"] for v in scene["kinds"][0]["vcd"]}, {"d2-n16", "d3-n81", "d2-n81"})

    def test_a_scene_of_other_options_is_not_mixed_in(self):
        self.bench(*SCENES)
        before = self.results()["scenes"][0]["variants"]
        done = self.bench("--scene", "forest,instances=6,species=2,leaves=30", code=7)
        self.assertIn("instances", done.stderr)
        self.assertEqual(self.results()["scenes"][0]["variants"], before)

    def test_goes_on_after_being_killed(self):
        environment = {**os.environ, "VCD_PYTHON": "/bin/true"}
        for wait in (0.15, 0.3, 0.6):
            process = subprocess.Popen([BIN / "vc-bench", "--scene", f"leaves={self.leaves}", *SCENES, *SMALL, "-o", self.out], env=environment,
                                       stderr=subprocess.DEVNULL)
            time.sleep(wait)
            process.send_signal(signal.SIGKILL)
            process.wait()
        self.bench("--scene", f"leaves={self.leaves}", *SCENES)
        self.assertEqual([s["status"] for s in self.results()["scenes"]], ["complete", "complete"])

    def test_an_interruption_keeps_what_there_is_and_says_so(self):
        process = subprocess.Popen([BIN / "vc-bench", "--scene", "sierpinski,level=5", "--trees", "6x256", "-q", "-o", self.out],
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=60), 4)
        self.assertIn("interrupted", process.communicate()[1])
        self.assertEqual(self.results()["scenes"][0]["status"], "partial")
        self.assertEqual([p.name for p in (self.out / "sidecars").iterdir()], [])

    def test_a_missing_mesh_in_a_resumed_run_keeps_earlier_results(self):
        self.bench("--scene", f"leaves={self.leaves}", *SCENES)
        before = self.results()
        self.leaves.unlink()
        done = self.bench("--scene", f"leaves={self.leaves}", *SCENES, code=9)
        self.assertIn("leaves.obj", done.stderr)
        after = self.results()
        self.assertEqual(after["scenes"][0]["status"], "failed")
        self.assertIn("leaves.obj", after["scenes"][0]["error"])
        self.assertEqual(after["scenes"][0]["variants"], before["scenes"][0]["variants"])
        self.assertEqual(after["scenes"][1], before["scenes"][1])

    def test_a_mesh_that_changed_makes_the_kept_sidecars_stale(self):
        self.bench("--scene", f"leaves={self.leaves}")
        before = self.results()["scenes"][0]["variants"]
        self.leaves.write_text(soup(41))
        done = self.bench("--scene", f"leaves={self.leaves}", code=8)
        self.assertIn("stale", done.stderr)
        self.assertEqual(self.results()["scenes"][0]["variants"], before)

    def test_results_of_other_settings_are_not_mixed_in(self):
        self.bench(*SCENES)
        before = (self.out / "results.json").read_bytes()
        arguments = [a.replace("24x16", "30x20") for a in SMALL]
        done = self.run_program("vc-bench", *SCENES, *arguments, "-o", self.out, code=7)
        self.assertIn("settings", done.stderr)
        self.assertEqual((self.out / "results.json").read_bytes(), before)

    def test_demands_are_asked_by_other_cameras_and_under_other_lights(self):
        command = ("vc-bench", "demand", f"leaves={self.leaves}", "--size", "12x8", "--repetitions", 1, "--budget-mb", 0.1, "--depth", 3,
                   "--proven-only", "--judged", 1000, "-q", "-o", self.out)
        report = json.loads(self.run_program(*command, "--format", "json").stdout)
        self.assertRegex(self.run_program(*command).stdout, r"lights alone, proven +0 of \d+ answers wrong, of \d{4,} segments")
        names = [s["name"] for s in report["sidecars"]]
        self.assertEqual(names, [f"{source}, proven" for source in ("any scene", "one camera", "three cameras", "lights alone")])
        self.assertTrue(all(s["file_bytes"] <= 0.1 * 2**20 for s in report["sidecars"][1:]))
        self.assertEqual([(c["camera_degrees"], c["lights_degrees"]) for c in report["cases"]], [(0, 0), (30, 0), (90, 0), (180, 0), (0, 30)])
        counts = {c["sidecars"][0]["rays"] for c in report["cases"]}
        self.assertGreater(len(counts), 1)  # other pictures
        for case in report["cases"]:
            self.assertEqual([s["name"] for s in case["sidecars"]], names)
            for sidecar in case["sidecars"]:
                self.assertEqual(sidecar["wrong"], 0)
                self.assertLessEqual(sidecar["ground_left"], sidecar["left"])
                self.assertGreater(sidecar["judged"], 0)
        for judged in report["judged"]:
            self.assertGreaterEqual(judged["segments"], 1000)
            self.assertGreater(judged["answered"], 0)
            self.assertEqual(judged["wrong"], 0)

    def test_refuses_wrong_requests_and_folders(self):
        for text in ("my mesh.obj", "a.obj,turn=nan", "sierpinski,level=99", "forest,trees=7", "=x.obj", "a/b=x.obj"):
            self.assertIn(text, self.bench("--scene", text, code=1).stderr)
        for trees in ("5x17", "demandx16", "demand", "x16"):
            self.run_program("vc-bench", "--trees", trees, "-o", self.out, code=1)
        self.assertFalse(self.out.exists())
        (self.folder / "file").write_text("")
        self.run_program("vc-bench", *SCENES, "-o", self.folder / "file" / "out", code=2)
        self.out.mkdir()
        (self.out / "results.json").write_text("{}")
        self.bench(*SCENES, code=3)

    @unittest.skipUnless(shutil.which("setpriv") and os.geteuid() == 0, "needs root and setpriv to lose root's rights")
    def test_an_unwritable_folder_is_found_out_before_any_work(self):
        self.out.mkdir()
        self.out.chmod(0o555)
        self.folder.chmod(0o755)
        done = subprocess.run(["setpriv", "--reuid=65534", "--clear-groups", BIN / "vc-bench", *SCENES, *SMALL, "-o", self.out],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("results.json", done.stderr)


class Segments(Case):
    def test_segments(self):
        mesh, sidecar = self.baked()
        done = self.run_program("vc-bench", "segments", sidecar, mesh, "--points", 20, "--repetitions", 1, "--format", "json")
        self.assertEqual(json.loads(done.stdout)["shadow_rays"]["segments"], 20 * 128)
        other = self.mesh("other.obj", soup(5))
        self.run_program("vc-bench", "segments", sidecar, other, code=8)

    def test_older_instructions_hold_both_sides(self):
        mesh, sidecar = self.baked()
        done = self.run_program("vc-bench", "segments", sidecar, mesh, "--points", 20, "--repetitions", 1, "--instructions",
                                "sse4", "--format", "json")
        report = json.loads(done.stdout)
        self.assertIn("SSE", report["machine"])
        self.assertNotIn("AVX", report["machine"])
        self.assertNotIn("AVX", json.dumps(report["shadow_rays"]["look_ups"]))
        self.run_program("vc-bench", "segments", sidecar, mesh, "--instructions", "avx9", code=1)

    def test_instances(self):
        trees, sidecar = self.folder / "trees.glb", self.folder / "trees.vcd"
        scene = ("forest", "--instances", "5", "--species", "2", "--leaves", "30")
        self.run_program("vc-scene", *scene, "-o", trees, "-q")
        self.run_program("vc-bake", trees, "-d", "3", "-m", "proven", "-o", sidecar, "-q")
        done = self.run_program("vc-bench", "instances", "forest,instances=5,species=2,leaves=30", sidecar, "--points", 40,
                                "--repetitions", 1, "--format", "json")
        kinds = json.loads(done.stdout)["kinds"]
        self.assertEqual(len(kinds), 6)  # ground, instances and both, in order and shuffled
        for ordered, shuffled in zip(kinds[:3], kinds[3:]):
            self.assertEqual(shuffled["name"], ordered["name"] + ", shuffled")
            for name in ("segments", "blocked", "differing"):
                self.assertEqual(ordered[name], shuffled[name])
            self.assertEqual(ordered["differing"], 0)
            self.assertGreater(ordered["blocked"], 0)
        self.run_program("vc-bench", "instances", "sierpinski,level=2", sidecar, code=1)

    def test_paths(self):
        leaves, trees = self.folder / "leaves.vcd", self.folder / "trees.vcd"
        mesh = self.mesh("leaves.obj", soup(40))
        self.run_program("vc-bake", mesh, "-d", "3", "-m", "proven", "-o", leaves, "-q")
        forest = ("forest", "--instances", "5", "--species", "2", "--leaves", "30")
        self.run_program("vc-scene", *forest, "-o", self.folder / "trees.glb", "-q")
        self.run_program("vc-bake", self.folder / "trees.glb", "-d", "3", "-m", "proven", "-o", trees, "-q")
        few = ("--points", 900, "--repetitions", 1)
        for scene, sidecar, names in ((mesh, leaves, {"missing", "piercing", "own", "inside"}),
                                      ("forest,instances=5,species=2,leaves=30", trees, {"instanced-ground", "instanced-own"})):
            done = self.run_program("vc-bench", "paths", scene, sidecar, *few, "--format", "json")
            report = json.loads(done.stdout)
            self.assertEqual(report["bounces"], 4)
            all_, *kinds = report["kinds"]
            self.assertEqual(all_["name"], "all")
            self.assertLessEqual({k["name"] for k in kinds}, names)
            self.assertGreater(len(kinds), 1)
            for count in ("segments", "blocked", "differ"):
                self.assertEqual(all_[count], sum(k[count] for k in kinds))
            self.assertGreater(all_["blocked"], 0)
            self.assertEqual(all_["judged"], all_["segments"])
            self.assertEqual(all_["wrong"], {way: 0 for way in all_["wrong"]})
            self.assertIn("hierarchy", all_["wrong"])
            self.assertLessEqual(all_["differ"], all_["segments"] / 1000)
            ours = {"hierarchy", "look-ups, then hierarchy", "look-ups as baked, then hierarchy"}
            for kind in report["kinds"]:
                single, wavefronts = kind["single_calls"], kind["wavefronts"]
                self.assertEqual({v["name"] for v in single["vcd"]}, ours | {"look-ups, then rtcOccluded1"})
                self.assertEqual({v["name"] for v in wavefronts["vcd"]}, ours)
                self.assertEqual({e["name"].split(",")[0] for e in wavefronts["embree"]}, {"rtcOccluded8", "rtcOccluded16"})
                for use in (single, wavefronts):
                    self.assertTrue(any("build of high quality" in e["name"] for e in use["embree"]))
                    best = min(use["embree"], key=lambda e: e["median_ns"])
                    self.assertEqual((best["name"], best["speed_up"]), (use["best_embree"], 1))
                    for v in use["vcd"]:
                        self.assertAlmostEqual(v["speed_up"], best["median_ns"] / v["median_ns"])
        text = self.run_program("vc-bench", "paths", mesh, leaves, *few, "--bounces", 1).stdout
        self.assertIn("single calls, path by path", text)
        self.assertRegex(text, r"Embree \d+; hierarchy 0;")
        own = self.folder / "own.vcd"
        self.run_program("vc-bake", mesh, "-d", "3", "-m", "proven", "--horizons", "-o", own, "-q")
        with_horizons = json.loads(self.run_program("vc-bench", "paths", mesh, own, *few, "--format", "json").stdout)
        for kind in with_horizons["kinds"]:
            self.assertEqual(kind["wrong"]["look-ups as baked and horizons, then hierarchy"], 0)
            self.assertIn("look-ups as baked and horizons, then hierarchy",
                          {v["name"] for v in kind["single_calls"]["vcd"]})
        bare = self.folder / "bare.vcd"
        self.run_program("vc-bake", mesh, "-d", "3", "-m", "proven", "--no-hierarchy", "-o", bare, "-q")
        self.assertIn("hierarchy", self.run_program("vc-bench", "paths", mesh, bare, *few, code=1).stderr)

    def test_bake_rate(self):
        done = self.run_program("vc-bench", "bake-rate", self.mesh(), "--cells", 3, "--repetitions", 1)
        self.assertIn("rtcOccluded16", done.stdout)


if __name__ == "__main__":
    unittest.main()
