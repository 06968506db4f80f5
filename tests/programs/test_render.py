"""vc-render as its users meet it: pictures, figures, and what it refuses."""
import json
import struct
import subprocess
import unittest

from case import BIN, Case, soup

SMALL = ("--size", "24x16", "--pixel-samples", "2", "--light-samples", "16")
TREE = ("--depth", "3", "--method", "sampled", "--samples", "16")


def png_size(path):
    head = path.read_bytes()[:24]
    return struct.unpack(">II", head[16:24]) if head.startswith(b"\x89PNG\r\n\x1a\n") else None


class Render(Case):
    def setUp(self):
        super().setUp()
        self.leaves = self.mesh("leaves.obj", soup(60))

    def render(self, *arguments, **options):
        return self.run_program("vc-render", *arguments, *SMALL, cwd=self.folder, **options)

    def test_writes_every_view(self):
        done = self.render(self.leaves, "--shadows", "both", "--views", "shaded,tests,fallback,difference", "--exr", *TREE, "-o", "out")
        names = ["out-bvh.png", "out-vcd.png", "out-bvh-tests.png", "out-vcd-tests.png", "out-vcd-fallback.png", "out-difference.png"]
        for name in names:
            width, height = png_size(self.folder / name)
            self.assertEqual(width, 24)
            self.assertEqual(height > 16, "tests" in name or "fallback" in name, name)  # the scale stands below
            self.assertIn(name, done.stdout)
        for name in ("out-bvh.exr", "out-vcd.exr"):
            self.assertEqual((self.folder / name).read_bytes()[:4], b"\x76\x2f\x31\x01")
        self.assertEqual(self.files(), sorted(["leaves.obj", "out-bvh.exr", "out-vcd.exr", *names]))

    def test_a_sidecar_beside_the_mesh_is_used_and_else_one_is_baked(self):
        self.assertIn("baking one", self.render(self.leaves, *TREE).stderr)
        self.assertEqual(self.files(), ["leaves-vcd.png", "leaves.obj"])
        self.run_program("vc-bake", self.leaves, "-q", *TREE)
        self.assertEqual(self.render(self.leaves).stderr, "")

    def test_json_says_what_the_text_says(self):
        report = json.loads(self.render("sierpinski", "--level", "3", "--shadows", "both", "--views", "shaded,tests", *TREE,
                                        "--format", "json", "-q").stdout)
        bvh, vcd = report["variants"]
        self.assertEqual((bvh["shadows"], vcd["shadows"]), ("bvh", "vcd"))
        self.assertEqual(report["triangles"], 256)
        self.assertEqual(bvh["shadow_segments"], vcd["shadow_segments"])
        self.assertLess(vcd["tests"], bvh["tests"])
        self.assertLessEqual(vcd["resolved"], vcd["shadow_segments"])
        self.assertGreaterEqual(report["difference"]["maximum"], report["difference"]["rmse"])

    def test_what_is_recorded_can_be_baked_for(self):
        self.render(self.leaves, "--shadows", "bvh", "-q", "--record", "leaves.demand", "--seed", 7)
        done = self.run_program("vc-bake", self.leaves, "--for", self.folder / "leaves.demand", "--audit", 3000)
        self.assertRegex(done.stdout, r"of what was kept out of the bake answered: \d+ segments, 0 wrong")
        self.render(self.leaves, "--shadows", "both", "-q", "--record", "again.demand", "-o", "both")
        asked = json.loads(self.run_program("vc-info", "leaves.obj.vcd", "--asked", "again.demand", "--format", "json", cwd=self.folder).stdout)
        self.assertGreater(asked["files"][0]["objects"][0]["asked"]["answered"], 0.5)
        self.render("forest", "--instances", "5", "--species", "2", "--leaves", "40", "--shadows", "bvh", "-q", "--record", "forest.demand",
                    "--most-recorded", 100, "-j", 1)
        recorded = json.loads(self.run_program("vc-info", "forest.demand", "--format", "json", cwd=self.folder).stdout)["files"][0]["demand"]
        self.assertGreaterEqual(len(recorded), 2)
        self.assertLess(sum(entry["segments"] for entry in recorded), 1000)
        self.render(self.leaves, "--shadows", "bvh", "--record", "leaves.obj", code=1)

    def test_paths_give_one_picture_whoever_answers(self):
        self.run_program("vc-bake", self.leaves, "-q", "--depth", 3, "--method", "proven", "--horizons")
        for use in ("single", "wavefronts"):
            report = json.loads(self.render_paths(use, "--shadows", "both", "--views", "shaded,difference", "--format", "json").stdout)
            self.assertEqual(report["difference"]["pixels"], 0)
            self.assertRegex(report["variants"][0]["answered_by"], {"single": "rtcOccluded1$", "wavefronts": "rtcOccluded(8|16)"}[use])
            self.assertIn("hierarchy", report["variants"][1]["answered_by"])
        one, four = (json.loads(self.render_paths("single", "--bounces", n, "--format", "json").stdout)["variants"][0]["shadow_segments"] for n in (1, 4))
        self.assertLess(one, four)
        self.render_paths("wavefronts", "--record", "paths.demand")
        done = self.run_program("vc-bake", self.leaves, "--for", self.folder / "paths.demand", "--audit", 3000, "-o", self.folder / "for.vcd")
        self.assertRegex(done.stdout, r"of what was kept out of the bake answered: \d+ segments, 0 wrong")

    def render_paths(self, use, *arguments, **options):
        return self.run_program("vc-render", self.leaves, "--paths", use, "--size", "24x16", "--pixel-samples", 4, *arguments, cwd=self.folder, **options)

    def test_paths_need_a_hierarchy_and_no_bvh_behind_it(self):
        self.run_program("vc-bake", self.leaves, "-q", *TREE, "--no-hierarchy")
        self.assertIn("without a hierarchy", self.render_paths("single", code=1).stderr)
        self.render_paths("single", "--shadows", "bvh")
        self.assertIn("not with --behind bvh", self.render_paths("single", "--behind", "bvh", code=1).stderr)
        self.assertIn("fallback", self.render_paths("single", "--views", "fallback", code=1).stderr)
        self.render_paths("single", "--light-samples", 3, code=1)
        self.render_paths("single", "--bounces", 5, code=1)
        self.render(self.leaves, "--bounces", 2, code=1)
        self.assertIn("without a hierarchy", self.render(self.leaves, "--behind", "hierarchy", code=1).stderr)

    def test_what_is_behind_look_ups_can_be_chosen(self):
        self.run_program("vc-bake", self.leaves, "-q", "--depth", 3, "--method", "proven")
        by = {}
        for behind in ("hierarchy", "bvh"):
            report = json.loads(self.render(self.leaves, "--behind", behind, "--shadows", "both", "--format", "json", "-o", behind).stdout)
            self.assertEqual(report["difference"]["pixels"], 0)
            by[behind] = report["variants"][1]["answered_by"]
        self.assertIn("hierarchy", by["hierarchy"])
        self.assertIn("rtcOccluded", by["bvh"])

    def test_older_instructions_give_the_same_picture(self):
        self.run_program("vc-bake", self.leaves, "-q", "--depth", 3, "--method", "proven")
        for name in ("avx2", "sse4"):
            report = json.loads(self.render(self.leaves, "--instructions", name, "--shadows", "both", "--format", "json", "-o", name).stdout)
            self.assertEqual(report["difference"]["pixels"], 0)
        self.assertEqual((self.folder / "avx2-vcd.png").read_bytes(), (self.folder / "sse4-vcd.png").read_bytes())

    def test_same_picture_for_any_number_of_threads(self):
        for threads in (1, 3):
            self.render("forest", "--instances", "5", "--species", "2", "--leaves", "40", "--shadows", "bvh", "-q", "-j", threads, "-o", f"t{threads}")
        self.assertEqual((self.folder / "t1-bvh.png").read_bytes(), (self.folder / "t3-bvh.png").read_bytes())

    def test_several_meshes_stand_together(self):
        other = self.mesh("other.obj", soup(20, seed=2))
        report = json.loads(self.render(self.leaves, other, "--shadows", "bvh", "--format", "json", "-q").stdout)
        self.assertEqual((report["triangles"], report["instances"]), (80, 2))

    def test_the_nodes_of_a_file_place_its_meshes(self):
        options = ("--instances", "5", "--species", "2", "--leaves", "40")
        self.run_program("vc-scene", "forest", *options, "-q", "-o", self.folder / "forest.glb")
        placed, made = (json.loads(self.render(*scene, "--shadows", "bvh", "--format", "json", "-q").stdout)
                        for scene in (("forest.glb",), ("forest", *options)))
        self.assertEqual(placed["instances"], made["instances"])
        self.assertEqual(placed["triangles"], made["triangles"])

    def test_a_sidecar_of_another_mesh_is_stale(self):
        _, sidecar = self.baked()
        done = self.render(self.leaves, "--sidecar", sidecar, code=8)
        self.assertIn("leaves.obj", done.stderr)
        self.assertIn("stale", done.stderr)
        self.assertNotIn("leaves-vcd.png", self.files())

    def test_options_do_not_swallow_the_scene(self):
        _, sidecar = self.baked()
        mesh = self.folder / "tetrahedron.obj"
        self.run_program("vc-render", "--views", "shaded,fallback", "--sidecar", sidecar, mesh, *SMALL, "-q", cwd=self.folder)
        self.assertIn("tetrahedron-vcd-fallback.png", self.files())

    def test_refuses_what_makes_no_sense_before_any_work(self):
        self.render(self.leaves, "--views", "difference", "--shadows", "vcd", code=1)
        self.render("sierpinski", "hairball", code=1)
        self.run_program("vc-render", self.leaves, "--size", "10by10", code=1)
        self.assertIn("none.obj", self.render(self.folder / "none.obj", code=2).stderr)
        self.assertIn("does not exist", self.render(self.leaves, "-o", "nowhere/x", code=1).stderr)
        self.assertEqual(self.files(), ["leaves.obj"])

    def test_a_scene_too_large_for_memory_is_refused_at_once(self):
        done = self.render("hairball", "--strands", "100000000", "--segments", "100", code=4)
        self.assertIn("too large for this machine", done.stderr)

    def test_an_interruption_leaves_nothing_behind(self):
        process = subprocess.Popen([BIN / "vc-render", "sierpinski", "--level", "6", "--size", "2000x2000", "--shadows", "bvh", "-q"],
                                   cwd=self.folder, stderr=subprocess.PIPE, text=True)
        try:
            process.wait(timeout=1.5)
        except subprocess.TimeoutExpired:
            process.terminate()
        self.assertEqual(process.wait(timeout=60), 4)
        self.assertIn("stopped", process.communicate()[1])
        self.assertEqual(self.files(), ["leaves.obj"])


if __name__ == "__main__":
    unittest.main()
