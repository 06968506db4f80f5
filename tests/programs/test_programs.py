"""vc-info, vc-verify, vc-scene and what all programs have in common, as their users meet them."""
import json
import os
import struct
import subprocess
import threading
import time
import unittest

from case import BIN, Case, GOLDEN, SMALL, TETRAHEDRON, soup


class Info(Case):
    def test_text_and_json(self):
        _, sidecar = self.baked()
        self.assertIn('object 0 "tetrahedron"', self.run_program("vc-info", sidecar).stdout)
        shown = json.loads(self.run_program("vc-info", sidecar, "--format", "json").stdout)["files"][0]
        self.assertEqual(shown["objects"][0]["samples"], 16)
        self.assertAlmostEqual(sum(shown["objects"][0]["shares"].values()), 1)
        self.run_program("vc-info", self.mesh("mesh.vcd"), code=3)

    def test_what_of_a_mesh_is_no_closed_surface(self):
        torn = "\n".join(TETRAHEDRON.splitlines()[:-1]) + "\n"
        mesh, culprits = self.mesh(text=torn), self.folder / "culprits.obj"
        shown = self.run_program("vc-info", mesh, "--culprits", culprits).stdout
        self.assertIn("surface   1 piece, open: 3 boundary edges in 1 loop; manifold", shown)
        lines = culprits.read_text().splitlines()
        self.assertEqual([sum(line.startswith(k) for line in lines) for k in ("v ", "l ", "p ")], [3, 3, 0])
        self.run_program("vc-info", mesh, "--culprits", culprits)  # those may be replaced
        self.run_program("vc-info", mesh, "--culprits", mesh, code=1)
        self.assertEqual(mesh.read_text(), torn)
        self.run_program("vc-info", mesh, "--culprits", self.folder / "c.txt", code=1)
        self.run_program("vc-info", mesh, mesh, "--culprits", culprits, code=1)
        surface = json.loads(self.run_program("vc-info", mesh, "--format", "json").stdout)["files"][0]["meshes"][0]["surface"]
        self.assertEqual(surface, {"components": 1, "closed": False, "boundary_edges": 3, "boundary_loops": 1,
                                   "nonmanifold_edges": 0, "nonmanifold_vertices": 0})
        planned = json.loads(self.run_program("vc-bake", mesh, "--plan", "--format", "json").stdout)["files"][0]["objects"][0]
        self.assertEqual(planned["surface"], surface)
        self.assertEqual(planned["proofs"]["level"], 5)
        self.assertIn("find blocked", self.run_program("vc-bake", mesh, "--plan").stdout)
        self.run_program("vc-info", self.mesh("bad.obj", "f 1 2 3\n"), code=3)
        _, sidecar = self.baked("--embed-geometry")
        self.assertIn("surface   1 piece, closed; manifold", self.run_program("vc-info", sidecar).stdout)

    def test_repack_keeps_the_content(self):
        _, sidecar = self.baked("--depth", "5", "--embed-geometry", text=soup(30), name="soup.obj")
        ship, raw = self.folder / "ship.vcd", self.folder / "raw.vcd"
        self.run_program("vc-info", sidecar, "--repack", ship, "--storage", "ship")
        self.run_program("vc-info", ship, "--repack", raw, "--storage", "raw")
        self.assertLess(ship.stat().st_size, sidecar.stat().st_size / 2)
        self.assertEqual(raw.read_bytes(), sidecar.read_bytes())
        self.assertIn("is named like a mesh", self.run_program("vc-info", ship, "--repack", self.folder / "soup.obj", code=1).stderr)
        hashes = [[(s["type"], s["logical_xxh3"]) for s in json.loads(self.run_program("vc-info", f, "--format", "json").stdout)["files"][0]["sections"]]
                  for f in (sidecar, ship)]
        self.assertEqual(*hashes)
        baked_ship = self.folder / "direct.vcd"
        self.run_program("vc-bake", self.folder / "soup.obj", "-q", "--depth", 5, "--method", "sampled", "--samples", 16, "--embed-geometry",
                         "--audit", 9000, "--storage", "ship", "-o", baked_ship)
        self.assertEqual(baked_ship.read_bytes(), ship.read_bytes())

    def test_a_file_that_is_rewritten_in_place_ends_in_a_code_and_no_signal(self):
        _, sidecar = self.baked("--embed-geometry", "--depth", "1", text=soup(20000))
        whole = sidecar.read_bytes()
        self.assertGreater(len(whole), 200_000)
        stop = threading.Event()

        def rewrite():
            while not stop.is_set():
                for size in (5000, 0):
                    os.truncate(sidecar, size)
                    sidecar.write_bytes(whole)

        writer = threading.Thread(target=rewrite)
        writer.start()
        try:
            codes = {subprocess.run([BIN / "vc-info", sidecar], capture_output=True, timeout=60).returncode for _ in range(60)}
        finally:
            stop.set()
            writer.join()
        self.assertLessEqual(codes, {0, 2, 3})


class Verify(Case):
    def test_accepts_what_was_baked(self):
        mesh, sidecar = self.baked()
        self.assertIn("ok", self.run_program("vc-verify", sidecar).stdout)
        done = self.run_program("vc-verify", sidecar, "--against", mesh, "--lines", 20000)
        self.assertIn("95 % bound", done.stdout)

    def test_same_mesh_in_another_file_format_and_order(self):
        _, sidecar = self.baked()
        off = self.mesh("other.off", "OFF\n4 4 0\n0 0 1\n0 0 0\n1 0 0\n0 1 0\n3 2 0 3\n3 1 3 2\n3 1 2 0\n3 0 3 1\n")
        self.run_program("vc-verify", sidecar, "--against", off, "--lines", 1000)

    def test_another_mesh_is_stale(self):
        _, sidecar = self.baked()
        other = self.mesh("moved.obj", TETRAHEDRON.replace("v 1 0 0", "v 1.0000001 0 0"))
        done = self.run_program("vc-verify", sidecar, "--against", other, code=8)
        self.assertIn("stale", done.stderr)

    def test_damage(self):
        _, sidecar = self.baked()
        data = bytearray(sidecar.read_bytes())
        data[-5] ^= 1
        sidecar.write_bytes(data)
        done = self.run_program("vc-verify", sidecar, code=3)
        self.assertIn("stored-checksum", done.stderr)
        findings = json.loads(self.run_program("vc-verify", sidecar, "--format", "json", code=3).stdout)["files"][0]["findings"]
        self.assertEqual(findings[0]["id"], "stored-checksum")

    def test_many_files_and_never_zero(self):
        _, sidecar = self.baked()
        (self.folder / "empty.vcd").write_bytes(b"")
        self.run_program("vc-verify", sidecar, self.folder / "empty.vcd", code=9)
        self.run_program("vc-verify", self.folder / "empty.vcd", code=3)
        self.run_program("vc-verify", self.folder / "absent.vcd", code=2)
        self.run_program("vc-verify", code=1)

    def test_embedded_geometry_needs_no_mesh(self):
        _, sidecar = self.baked("--embed-geometry")
        self.assertIn("uniform", self.run_program("vc-verify", sidecar, "--lines", 20000).stdout)
        self.assertNotIn("uniform", self.run_program("vc-verify", GOLDEN / "depth3.vcd").stdout)

    def test_wrong_answers_fail_and_can_be_replayed(self):
        mesh, sidecar = self.baked("--depth", "4", text=soup(40), name="soup.obj")
        done = self.run_program("vc-verify", sidecar, "--against", mesh, "--max-wrong", 0, "--lines", 100000, code=7)
        segment = done.stdout.split("--segment=")[1].split()[0]
        replayed = self.run_program("vc-verify", sidecar, "--against", mesh, f"--segment={segment}", code=7)
        self.assertIn("the sidecar says", replayed.stdout)
        self.run_program("vc-verify", sidecar, "--against", mesh, "--segment=1,2,3", code=1)

    def test_a_rate_is_refused_only_when_chance_does_not_explain_it(self):
        mesh, sidecar = self.baked("--depth", "4", text=soup(40), name="soup.obj")
        arguments = ("vc-verify", sidecar, "--against", mesh, "--lines", 30000)
        checked = json.loads(self.run_program(*arguments, "--format", "json").stdout)["files"][0]["objects"][0]
        undirected = checked["audit"]["undirected"]
        rate = undirected["wrong_rate"]
        self.assertGreater(rate * undirected["segments"], 20)
        self.assertTrue(0.5 * rate < checked["wrong_rate_at_least"] < 0.95 * rate)
        self.run_program(*arguments, "--max-wrong", 0.95 * rate)
        refused = self.run_program(*arguments, "--max-wrong", 0.5 * rate, code=7).stderr
        self.assertIn("95 % sure", refused)

    def test_findings_table(self):
        self.assertIn("tree-index", self.run_program("vc-verify", "--list-findings").stdout)


class Scene(Case):
    def test_writes_each_scene_and_says_what_it_is(self):
        counts = {"sierpinski --level 2": (64, 1, 1), "hairball --strands 5 --segments 4 --sides 3": (120, 1, 1)}
        for command, (triangles, meshes, instances) in counts.items():
            path = self.folder / "scene.glb"
            done = self.run_program("vc-scene", *command.split(), "-o", path)
            self.assertIn(f"{triangles} triangles in {meshes} mesh, {instances} instance, {path.stat().st_size} bytes", done.stdout)
            self.assertEqual(done.stderr, "")
            self.assertEqual(path.read_bytes()[:8], struct.pack("<4sI", b"glTF", 2))
        self.assertEqual(self.run_program("vc-scene", "sierpinski", "--level", 1, "-q", "-o", path).stdout, "")
        self.assertEqual(self.files(), ["scene.glb"])

    def test_json_report(self):
        path = self.folder / "forest.glb"
        done = self.run_program("vc-scene", "forest", "--instances", 9, "--species", 4, "--leaves", 60, "--format", "json", "-o", path)
        report = json.loads(done.stdout)
        self.assertEqual(report["bytes"], path.stat().st_size)
        self.assertEqual(report["instance_count"], 9)
        self.assertEqual(len(report["meshes"]), 4)
        self.assertEqual(report["triangle_count"], sum(m["triangle_count"] for m in report["meshes"]))

    def test_same_seed_same_bytes(self):
        def made(seed):
            self.run_program("vc-scene", "hairball", "--strands", 20, "--seed", seed, "-q", "-o", self.folder / "hair.glb")
            return (self.folder / "hair.glb").read_bytes()
        self.assertEqual(made(3), made(3))
        self.assertNotEqual(made(3), made(4))

    def test_can_be_baked(self):
        path = self.folder / "pyramid.glb"
        self.run_program("vc-scene", "sierpinski", "--level", 2, "-q", "-o", path)
        self.assertIn("64 triangles", self.run_program("vc-bake", path, *SMALL).stdout)

    def test_too_large_is_refused_before_it_is_made(self):
        for command in ("hairball --strands 4000000000", "forest --leaves 4000000000", "forest --instances 4000000000"):
            started = time.monotonic()
            done = self.run_program("vc-scene", *command.split(), "-o", self.folder / "large.glb", code=4)
            self.assertIn("too large", done.stderr)
            self.assertLess(time.monotonic() - started, 10)
        self.assertEqual(self.files(), [])

    def test_unwritable_output_and_wrong_usage(self):
        done = self.run_program("vc-scene", "sierpinski", "--level", 1, "-o", self.folder / "absent" / "x.glb", code=2)
        self.assertIn("absent/x.glb", done.stderr)
        self.assertIn("must end in .glb", self.run_program("vc-scene", "hairball", "-o", self.folder / "x.ply", code=1).stderr)
        self.run_program("vc-scene", "-o", self.folder / "x.glb", code=1)
        self.run_program("vc-scene", "sierpinski", code=1)
        self.run_program("vc-scene", "sierpinski", "--level", 13, "-o", self.folder / "x.glb", code=1)
        self.run_program("vc-scene", "hairball", "--sides", 2, "-o", self.folder / "x.glb", code=1)
        self.assertEqual(self.files(), [])


class EveryProgram(Case):
    def test_help_version_and_exit_codes(self):
        for program in filter(lambda name: (BIN / name).exists(), ("vc-bake", "vc-farm", "vc-verify", "vc-info", "vc-bench", "vc-scene", "vc-render")):
            self.assertIn("8  stale sidecar", self.run_program(program, "--help").stdout)
            self.assertRegex(self.run_program(program, "--version").stdout, r"^vcd \d+\.\d+\.\d+\n$")
            self.assertNotEqual(self.run_program(program, "--nonsense", code=1).stderr, "")


if __name__ == "__main__":
    unittest.main()
