"""The programs as their users meet them: exit codes, messages, files written and not written."""
import base64
import json
import os
import pathlib
import random
import shutil
import signal
import struct
import subprocess
import tempfile
import threading
import time
import unittest

BIN = pathlib.Path(os.environ["VCD_BIN"])
GOLDEN = pathlib.Path(__file__).resolve().parents[1] / "golden"

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SMALL = ("--depth", "3", "--method", "sampled", "--samples", "16", "--audit", "9000")


class Case(unittest.TestCase):
    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.holder.name)
        self.addCleanup(self.holder.cleanup)

    def run_program(self, program, *arguments, code=0, **options):
        if not (BIN / program).exists():
            self.skipTest(f"{program} is not built here")
        done = subprocess.run([BIN / program, *map(str, arguments)], capture_output=True, text=True, timeout=600,
                              errors="surrogateescape", **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def mesh(self, name="tetrahedron.obj", text=TETRAHEDRON):
        path = self.folder / name
        path.write_text(text)
        return path

    def baked(self, *options, name="tetrahedron.obj", text=TETRAHEDRON):
        mesh = self.mesh(name, text)
        depth = () if "--depth" in options else ("--depth", "3")
        audit = () if "--audit" in options else ("--audit", "9000")
        self.run_program("vc-bake", mesh, "-q", "--method", "sampled", "--samples", "16", *depth, *audit, *options)
        return mesh, mesh.with_name(mesh.name + ".vcd")

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())


def soup(triangles, seed=1):
    rng = random.Random(seed)
    lines = []
    for _ in range(triangles):
        base = [rng.uniform(0, 4) for _ in range(3)]
        lines += ["v " + " ".join(f"{x + rng.uniform(0, 0.4):.6f}" for x in base) for _ in range(3)]
    return "\n".join(lines + [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(triangles)]) + "\n"


class Bake(Case):
    def test_writes_a_sidecar_beside_the_mesh_and_says_what_it_did(self):
        mesh = self.mesh()
        done = self.run_program("vc-bake", mesh, *SMALL)
        self.assertIn("tetrahedron.obj.vcd", done.stdout)
        self.assertIn("4 triangles", done.stdout)
        self.assertEqual(done.stderr, "")
        self.assertEqual(self.files(), ["tetrahedron.obj", "tetrahedron.obj.vcd"])

    def test_quiet_is_silent(self):
        done = self.run_program("vc-bake", self.mesh(), "-q", *SMALL)
        self.assertEqual(done.stdout + done.stderr, "")

    def test_json_report(self):
        done = self.run_program("vc-bake", self.mesh(), *SMALL, "--format", "json")
        report = json.loads(done.stdout)
        self.assertEqual(report["files"][0]["objects"][0]["triangle_count"], 4)
        self.assertEqual(report["files"][0]["objects"][0]["depth"], 3)

    def test_same_bytes_for_any_number_of_threads(self):
        mesh = self.mesh("soup.obj", soup(60))
        for threads in (1, 2, 3):
            self.run_program("vc-bake", mesh, "-q", "--depth", 5, "--method", "sampled", "--samples", 16, "-j", threads, "-o", self.folder / f"{threads}.vcd")
        contents = {(self.folder / f"{t}.vcd").read_bytes() for t in (1, 2, 3)}
        self.assertEqual(len(contents), 1)

    def info(self, sidecar):
        return json.loads(self.run_program("vc-info", sidecar, "--format", "json").stdout)["files"][0]["objects"]

    def test_each_method_says_what_it_guarantees_and_is_audited(self):
        mesh = self.mesh("soup.obj", soup(60))
        for method in ("proven", "hybrid", "sampled"):
            self.run_program("vc-bake", mesh, "--method", method, "--depth", 3, "--audit", 9000)
            found, = self.info(f"{mesh}.vcd")
            self.assertEqual(found["method"], method)
            self.assertEqual(found["audit"]["lines"] + found["audit"]["aimed_lines"], 9000)
            self.assertEqual(found["guard_band"] > 0, method != "sampled")
            if method == "proven":
                self.assertEqual(found["audit"]["wrong"] + found["audit"]["aimed_wrong"], 0)
            self.run_program("vc-verify", f"{mesh}.vcd", "--against", mesh, "--lines", 9000)
        self.run_program("vc-bake", mesh, "--depth", 3, "--audit", 0)
        self.assertIsNone(self.info(f"{mesh}.vcd")[0]["audit"])

    def test_samples_do_not_change_the_method(self):
        mesh = self.mesh("soup.obj", soup(60))
        for arguments, method in ((["--samples", 81], "hybrid"), (["--samples", 81, "--method", "hybrid"], "hybrid"),
                                  (["--method", "sampled", "--samples", 81], "sampled"), ([], "hybrid")):
            self.run_program("vc-bake", mesh, "--depth", 2, "--audit", 0, *arguments)
            self.assertEqual(self.info(f"{mesh}.vcd")[0]["method"], method)
        self.run_program("vc-bake", mesh, "--method", "hybrid", "--samples", 16, code=1)

    def test_plan_forecasts_and_writes_nothing(self):
        mesh = self.mesh("soup.obj", soup(80))
        before = self.files()
        self.assertIn("gain", self.run_program("vc-bake", mesh, "--plan").stdout)
        report = json.loads(self.run_program("vc-bake", mesh, "--plan", "--format", "json").stdout)
        plan = report["files"][0]["objects"][0]["plan"]
        self.assertEqual([f["depth"] for f in plan["forecasts"]], list(range(1, 8)))
        self.assertGreater(plan["depth"], 0)
        self.assertEqual(self.files(), before)

    def test_budgets_are_kept_and_the_forecast_stands_beside_the_outcome(self):
        mesh = self.mesh("soup.obj", soup(80))
        report = json.loads(self.run_program("vc-bake", mesh, "--budget-mb", 0.25, "--audit", 0, "--format", "json").stdout)
        baked, = report["files"][0]["objects"]
        self.assertLessEqual(report["files"][0]["bytes"], 0.25 * 2 ** 20)
        self.assertEqual(baked["depth"], baked["plan"]["depth"])
        self.run_program("vc-bake", mesh, "--depth", 6, "--budget-seconds", 0.2, "--audit", 0)
        self.run_program("vc-verify", f"{mesh}.vcd", "--against", mesh, "--lines", 9000)
        self.assertIn("budget", self.run_program("vc-bake", mesh, "--depth", 5, "--budget-mb", 0.1, code=1).stderr)

    def test_what_is_not_worth_it_is_recorded_as_such(self):
        mesh = self.mesh()
        self.assertIn("not worth it", self.run_program("vc-bake", mesh).stdout)
        self.assertEqual(self.info(f"{mesh}.vcd")[0]["method"], "none")
        self.assertIn("would not pay", self.run_program("vc-info", f"{mesh}.vcd").stdout)
        self.run_program("vc-verify", f"{mesh}.vcd", "--against", mesh, "--lines", 9000)

    def test_the_hierarchy_is_there_unless_it_is_unwanted_or_too_large(self):
        mesh = self.mesh()
        self.run_program("vc-bake", mesh, "--depth", 2, "--audit", 0)
        hierarchy = self.info(f"{mesh}.vcd")[0]["hierarchy"]
        self.assertGreater(hierarchy["nodes"], 0)
        self.assertIn("bytes a triangle", self.run_program("vc-info", f"{mesh}.vcd").stdout)
        self.run_program("vc-info", f"{mesh}.vcd", "--repack", self.folder / "ship.vcd", "--storage", "ship")
        self.assertEqual(self.info(self.folder / "ship.vcd")[0]["hierarchy"], hierarchy)
        self.run_program("vc-verify", self.folder / "ship.vcd", "--against", mesh, "--lines", 9000)
        self.run_program("vc-bake", mesh, "--depth", 2, "--audit", 0, "--no-hierarchy")
        self.assertIsNone(self.info(f"{mesh}.vcd")[0]["hierarchy"])
        large = self.folder / "large.obj"
        large.write_text(soup(3000))
        done = self.run_program("vc-bake", large, "--depth", 2, "--audit", 0, "--budget-mb", 0.05)
        self.assertIn("has no hierarchy", done.stderr)
        self.assertIsNone(self.info(f"{large}.vcd")[0]["hierarchy"])

    def test_output_file_and_folder(self):
        mesh, other = self.mesh(), self.mesh("other.obj")
        self.run_program("vc-bake", mesh, "-q", *SMALL, "-o", self.folder / "x.vcd")
        self.run_program("vc-bake", mesh, other, "-q", *SMALL, "-o", self.folder / "out")
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()), ["other.obj.vcd", "tetrahedron.obj.vcd"])
        for file in ("x.vcd", "several.vcd", "other.obj"):
            self.assertIn("not a folder", self.run_program("vc-bake", mesh, other, "-o", self.folder / file, code=1).stderr)
        self.assertFalse((self.folder / "several.vcd").exists())

    def test_never_replaces_a_mesh_or_a_device(self):
        mesh, other = self.mesh(), self.mesh("other.obj")
        self.run_program("vc-bake", mesh, "-o", mesh, code=1)
        self.run_program("vc-bake", other, "-o", self.folder / "." / "other.obj", code=1)
        os.mkfifo(self.folder / "fifo")
        self.run_program("vc-bake", mesh, "-q", *SMALL, "-o", self.folder / "fifo", code=1)
        os.mkfifo(self.folder / "fifo.vcd")
        self.run_program("vc-bake", mesh, "-q", *SMALL, "-o", self.folder / "fifo.vcd", code=2)
        self.assertEqual(mesh.read_text(), TETRAHEDRON)
        self.run_program("vc-info", self.folder / "fifo", code=2)

    def test_a_mesh_without_area_does_not_spoil_the_others(self):
        positions = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0)
        indices = struct.pack("<6H", 0, 1, 2, 0, 1, 3)
        uri = "data:application/octet-stream;base64," + base64.b64encode(positions + indices).decode()
        view = lambda offset, size: {"buffer": 0, "byteOffset": offset, "byteLength": size}
        accessor = lambda v, offset, kind, n, shape: {"bufferView": v, "byteOffset": offset, "componentType": kind, "count": n, "type": shape}
        document = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": 60}],
                    "bufferViews": [view(0, 48), view(48, 12)],
                    "accessors": [accessor(0, 0, 5126, 4, "VEC3"), accessor(1, 0, 5123, 3, "SCALAR"), accessor(1, 6, 5123, 3, "SCALAR")],
                    "meshes": [{"name": n, "primitives": [{"attributes": {"POSITION": 0}, "indices": i}]} for n, i in (("good", 1), ("flat", 2))]}
        mesh = self.mesh("two.gltf", json.dumps(document))
        done = self.run_program("vc-bake", mesh, *SMALL)
        self.assertIn("flat", done.stderr)
        self.run_program("vc-verify", f"{mesh}.vcd", "--against", mesh, "--lines", 1000)

    def test_two_inputs_for_one_output_are_refused(self):
        (self.folder / "a").mkdir()
        (self.folder / "out").mkdir()
        mesh, twin = self.mesh(), self.mesh("a/tetrahedron.obj")
        self.run_program("vc-bake", mesh, twin, "-o", self.folder / "out", code=1)
        self.assertEqual(list((self.folder / "out").iterdir()), [])

    def test_a_bad_mesh_leaves_nothing_and_the_others_are_baked(self):
        bad = self.mesh("bad.obj", TETRAHEDRON + "f 1 2 99\n")
        done = self.run_program("vc-bake", bad, *SMALL, code=3)
        self.assertIn("bad.obj", done.stderr)
        self.assertIn("99", done.stderr)
        self.assertIn("line 9", done.stderr)
        self.assertEqual(self.files(), ["bad.obj"])
        good = self.mesh()
        self.run_program("vc-bake", bad, good, self.folder / "absent.ply", *SMALL, code=9)
        self.assertEqual(self.files(), ["bad.obj", "tetrahedron.obj", "tetrahedron.obj.vcd"])

    def test_exit_codes(self):
        self.run_program("vc-bake", code=1)
        self.run_program("vc-bake", self.mesh(), "--depth", 9, code=1)
        self.run_program("vc-bake", self.folder / "absent.obj", code=2)
        self.run_program("vc-bake", self.mesh("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), code=3)
        self.run_program("vc-bake", self.mesh("points.obj", "v 0 0 0\np 1\n"), code=3)
        self.run_program("vc-bake", self.mesh("what.fbx", ""), code=5)

    def test_list_of_files(self):
        self.mesh("one.obj"), self.mesh("two words.obj")
        (self.folder / "list.txt").write_text(f"{self.folder}/one.obj\n\n{self.folder}/two words.obj\n")
        self.run_program("vc-bake", f"@{self.folder}/list.txt", "-q", *SMALL)
        self.assertEqual(self.files(), ["list.txt", "one.obj", "one.obj.vcd", "two words.obj", "two words.obj.vcd"])
        self.run_program("vc-bake", "@/absent/list.txt", code=1)

    def test_odd_file_names(self):
        for name in (b"two words.obj", b'quo"te.obj', b"new\nline.obj", b"\xff\xfe latin.obj", "Ähre.obj".encode(), b"-dash.obj"):
            path = os.fsencode(self.folder) + b"/" + name
            with open(path, "w") as out:
                out.write(TETRAHEDRON)
            self.run_program("vc-bake", os.fsdecode(path), "-q", *SMALL)
            self.run_program("vc-verify", os.fsdecode(path) + ".vcd", "--against", os.fsdecode(path), "--lines", 1000)

    def test_unwritable_output(self):
        done = self.run_program("vc-bake", self.mesh(), *SMALL, "-o", self.folder / "absent" / "x.vcd", code=1)
        self.assertIn("absent/x.vcd", done.stderr)
        self.assertEqual(self.files(), ["tetrahedron.obj"])

    def test_replaces_by_renaming(self):
        mesh, sidecar = self.baked()
        with open(sidecar, "rb") as old:
            before = old.read()
            self.run_program("vc-bake", mesh, "-q", "--depth", 4, "--method", "sampled", "--samples", 16)
            old.seek(0)
            self.assertEqual(old.read(), before)  # whoever has the old file open keeps it
        self.assertNotEqual(sidecar.read_bytes(), before)

    def test_interruption_leaves_nothing(self):
        mesh = self.mesh("soup.obj", soup(3000))
        for kind in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([BIN / "vc-bake", mesh, "--depth", "8"], stderr=subprocess.PIPE, text=True)
            time.sleep(1.5)
            process.send_signal(kind)
            _, errors = process.communicate(timeout=120)
            self.assertEqual(process.returncode, 4, errors)
            self.assertIn("interrupted", errors)
            self.assertEqual(self.files(), ["soup.obj"])

    def test_progress_on_a_terminal_only(self):
        mesh = self.mesh("soup.obj", soup(200))
        inner = f"{BIN}/vc-bake {mesh} --depth 5 --method sampled --samples 16 >/dev/null"
        if not shutil.which("script"):
            self.skipTest("needs the program `script`")
        seen = subprocess.run(["script", "-qec", inner, "/dev/null"], capture_output=True, text=True).stdout
        self.assertIn("rays/s", seen)
        self.assertIn("left", seen)
        self.assertEqual(self.run_program("vc-bake", mesh, *SMALL).stderr, "")


class Info(Case):
    def test_text_and_json(self):
        _, sidecar = self.baked()
        self.assertIn('object 0 "tetrahedron"', self.run_program("vc-info", sidecar).stdout)
        shown = json.loads(self.run_program("vc-info", sidecar, "--format", "json").stdout)["files"][0]
        self.assertEqual(shown["objects"][0]["samples"], 16)
        self.assertAlmostEqual(sum(shown["objects"][0]["shares"].values()), 1)
        self.run_program("vc-info", self.mesh(), code=3)

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


class Bench(Case):
    def test_segments(self):
        mesh, sidecar = self.baked()
        done = self.run_program("vc-bench", "segments", sidecar, mesh, "--points", 20, "--repetitions", 1, "--format", "json")
        self.assertEqual(json.loads(done.stdout)["shadow_rays"]["segments"], 20 * 128)
        other = self.mesh("other.obj", soup(5))
        self.run_program("vc-bench", "segments", sidecar, other, code=8)

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
            self.assertEqual(all_["wrong_hierarchy"], 0)
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
        self.assertIn("the hierarchy 0 times", text)
        bare = self.folder / "bare.vcd"
        self.run_program("vc-bake", mesh, "-d", "3", "-m", "proven", "--no-hierarchy", "-o", bare, "-q")
        self.assertIn("hierarchy", self.run_program("vc-bench", "paths", mesh, bare, *few, code=1).stderr)

    def test_bake_rate(self):
        done = self.run_program("vc-bench", "bake-rate", self.mesh(), "--cells", 3, "--repetitions", 1)
        self.assertIn("rtcOccluded16", done.stdout)


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
