"""vc-bake as its users meet it: exit codes, messages, files written and not written."""
import base64
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import time
import unittest

from case import BIN, Case, SMALL, TETRAHEDRON, soup


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

    def test_a_sidecar_is_attached_to_its_mesh_file(self):
        mesh, named = self.mesh("my mesh.obj"), self.folder / "named.obj"
        attach = (*SMALL, "--attach", named)
        self.run_program("vc-bake", mesh, *attach, "--dry-run")
        self.assertFalse(named.exists())
        self.run_program("vc-bake", mesh, *attach)
        first, rest = named.read_text().split("\n", 1)
        self.assertEqual(first, f"# VCD_visibility my%20mesh.obj.vcd {self.info(f'{mesh}.vcd')[0]['geometry_hash']}")
        self.assertEqual(rest, mesh.read_text())
        self.run_program("vc-bake", mesh, *attach, "--update")  # such a file may be replaced
        self.run_program("vc-verify", f"{mesh}.vcd", "--against", named, "--lines", 90)
        self.run_program("vc-bake", named, *SMALL, "--attach", self.folder / "again.obj", code=1)
        other = self.mesh("other.obj")
        (self.folder / "below").mkdir()
        for path, reason in ((mesh, "is the mesh file itself"), (other, "was not written by --attach"),
                             (self.folder / "a.ply", "writes a file like"), (self.folder / "below" / "a.obj", "beside the mesh file")):
            self.assertIn(reason, self.run_program("vc-bake", mesh, *SMALL, "--attach", path, code=1).stderr)
        for options in (("--subdivide", 1), ("--embed",)):
            self.run_program("vc-bake", mesh, *attach, *options, code=1)
        self.assertIn("for one asset", self.run_program("vc-bake", mesh, other, *attach, code=1).stderr)
        self.assertEqual(other.read_text(), TETRAHEDRON)

    def test_a_sidecar_is_embedded_in_its_glb_file(self):
        shrub = pathlib.Path(__file__).parents[2] / "assets" / "shrub.glb"
        mesh, out = self.folder / "shrub.glb", self.folder / "out.glb"
        shutil.copy(shrub, mesh)
        (self.folder / "elsewhere").mkdir()
        self.run_program("vc-bake", mesh, *SMALL, "-o", self.folder / "elsewhere" / "s.vcd", "--attach", out, "--embed")
        content = out.read_bytes()
        size = struct.unpack("<I", content[12:16])[0]
        document = json.loads(content[20:20 + size])
        extension = document["meshes"][0]["extensions"]["VCD_visibility"]
        view = document["bufferViews"][extension["bufferView"]]
        begin = 28 + size + view["byteOffset"]
        self.assertEqual(begin % 64, 0)
        self.assertEqual(content[begin:begin + view["byteLength"]], (self.folder / "elsewhere" / "s.vcd").read_bytes())
        self.run_program("vc-verify", self.folder / "elsewhere" / "s.vcd", "--against", out, "--lines", 90)
        schema = json.loads((pathlib.Path(__file__).parents[2] / "spec" / "VCD_visibility.schema.json").read_text())
        self.assertLessEqual(set(extension), set(schema["properties"]))
        self.assertRegex(extension["geometryHash"], schema["properties"]["geometryHash"]["pattern"])
        self.run_program("vc-bake", mesh, *SMALL, "-o", self.folder / "elsewhere" / "s.vcd", "--attach", out)
        size = struct.unpack("<I", out.read_bytes()[12:16])[0]
        document = json.loads(out.read_bytes()[20:20 + size])
        self.assertEqual(document["meshes"][0]["extensions"]["VCD_visibility"]["uri"], "elsewhere/s.vcd")

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

    def test_horizons_are_there_where_they_are_wanted_and_answer_something(self):
        mesh, ship = self.mesh(), self.folder / "ship.vcd"
        small = ("--depth", 2, "--audit", 0)
        self.run_program("vc-bake", mesh, *small)
        self.assertIsNone(self.info(f"{mesh}.vcd")[0]["horizons"])
        self.run_program("vc-bake", mesh, *small, "--horizons")
        horizons = self.info(f"{mesh}.vcd")[0]["horizons"]
        self.assertEqual(horizons["bytes"], 320 + 12 * horizons["triangles"])
        self.assertGreater(horizons["cosine"], 0.99)  # a tetrahedron hides nothing from itself
        self.assertIn("of the directions above a triangle", self.run_program("vc-info", f"{mesh}.vcd").stdout)
        self.run_program("vc-info", f"{mesh}.vcd", "--repack", ship, "--storage", "ship")
        self.assertEqual(self.info(ship)[0]["horizons"], horizons)
        self.run_program("vc-verify", ship, "--against", mesh, "--lines", 9000)
        self.assertIn("horizons: ", self.run_program("vc-bake", mesh, "--plan", "--horizons").stdout)
        leaves = self.folder / "leaves.obj"
        leaves.write_text(soup(3000))
        done = self.run_program("vc-bake", leaves, *small, "--horizons")
        self.assertIn("has no horizons: they would answer too few", done.stderr)
        self.assertIsNone(self.info(f"{leaves}.vcd")[0]["horizons"])
        plan = self.run_program("vc-bake", leaves, "--plan", "--horizons").stdout
        self.assertIn("not worth it", plan.split("horizons: ")[1])

    def test_a_cached_object_of_another_order_has_its_own_horizons(self):
        mesh, cache = self.mesh(), self.folder / "cache"
        bake = ("--depth", 2, "--audit", 0, "--horizons", "--cache", cache)
        self.run_program("vc-bake", mesh, *bake)
        turned = self.folder / "turned.obj"
        lines = mesh.read_text().splitlines()
        faces = [line for line in lines if line.startswith("f ")]
        turned.write_text("\n".join([line for line in lines if not line.startswith("f ")] + faces[::-1]) + "\n")
        self.run_program("vc-bake", turned, *bake)
        first, second = (pathlib.Path(f"{m}.vcd").read_bytes() for m in (mesh, turned))
        self.assertNotEqual(first, second)
        alone = self.folder / "alone.vcd"
        self.run_program("vc-bake", turned, *bake[:-2], "-o", alone)
        self.assertEqual(self.info(alone)[0]["horizons"], self.info(f"{turned}.vcd")[0]["horizons"])
        self.assertEqual(alone.read_bytes()[-200:], second[-200:])

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

if __name__ == "__main__":
    unittest.main()
