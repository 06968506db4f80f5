"""vc-verify over a library: what is sound, damaged, stale, orphaned, missing or unusable, and that every report says the same."""
import base64
import collections
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest
import urllib.parse
import xml.etree.ElementTree as xml

from case import BIN, Case, TETRAHEDRON, soup

ODD = os.fsdecode(b"odd '\"\n<&>%\xff.obj")
NAMES = ("orphan.obj", "renamed.obj", "stale.obj", "sub/far.obj", "tetra.obj", ODD)


def tetrahedron(size):
    return TETRAHEDRON.replace("v 1 0 0", f"v {size} 0 0")


def masked_quad():
    positions = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
    uri = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
    return json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": 48}],
                       "bufferViews": [{"buffer": 0, "byteLength": 48}], "materials": [{"alphaMode": "MASK"}],
                       "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                       "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]})


class Library(Case):
    @classmethod
    def setUpClass(cls):
        cls.master = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.master.cleanup)
        root = pathlib.Path(cls.master.name) / "lib"
        (root / "sub").mkdir(parents=True)
        for size, name in enumerate(NAMES, start=1):
            (root / name).write_text(tetrahedron(size))
        subprocess.run([BIN / "vc-bake", *(root / n for n in NAMES), "-q", "--depth", "2", "--method", "sampled", "--samples", "16", "--audit", "0"], check=True)

    def setUp(self):
        super().setUp()
        self.lib = self.folder / "lib"
        shutil.copytree(pathlib.Path(self.master.name) / "lib", self.lib)

    def spoil(self):
        """One of each kind."""
        damaged = self.lib / "sub/far.obj.vcd"
        data = bytearray(damaged.read_bytes())
        data[-5] ^= 1
        damaged.write_bytes(data)
        (self.lib / "stale.obj").write_text(tetrahedron(77))
        (self.lib / "orphan.obj").unlink()
        (self.lib / "elsewhere").mkdir()
        (self.lib / "renamed.obj.vcd").rename(self.lib / "elsewhere/other.vcd")
        (self.lib / "lone.obj").write_text(tetrahedron(78))
        (self.lib / "broken.obj").write_text(TETRAHEDRON + "f 1 2 99\n")

    def verify(self, *arguments, code=0, library=True, inputs=None):
        against = ("--against-library", self.lib) if library else ()
        lines = () if "--lines" in arguments else ("--lines", 90)
        return self.run_program("vc-verify", *(inputs or [self.lib]), *against, *lines, *arguments, code=code)

    def report(self, *arguments, **options):
        found = json.loads(self.verify(*arguments, "--format", "json", **options).stdout)
        found["by_name"] = {}
        for entry in found["files"] + found.get("assets", []):
            name = entry["file"] if isinstance(entry["file"], str) else os.fsdecode(bytes.fromhex(entry["file"]["bytes"]))
            found["by_name"][os.path.relpath(name, self.lib)] = entry
        return found

    def ids(self, entry):
        return [f["id"] for f in entry["findings"]]

    def test_a_sound_library(self):
        totals = self.report()["totals"]
        self.assertEqual([totals[k] for k in ("sidecars", "ok", "assets", "missing", "warnings")], [6, 6, 6, 0, 0])
        text = self.verify().stdout
        self.assertIn("\n6 sidecars: 6 ok", text)
        self.assertTrue(text.endswith("\n6 assets: 0 missing\n"), text)
        self.assertIn("odd '\"\\x0a<&>%\\xff.obj.vcd: ok\n", text)
        self.assertIn("uniform", text)  # they were audited

    def test_one_of_each_kind_of_fault(self):
        self.spoil()
        report = self.report(code=9)
        for name, code, ids in (("tetra.obj.vcd", 0, []), ("elsewhere/other.vcd", 0, []), (ODD + ".vcd", 0, []), ("tetra.obj", 0, []),
                                ("sub/far.obj.vcd", 3, ["stored-checksum"]), ("stale.obj.vcd", 8, ["stale"]),
                                ("orphan.obj.vcd", 7, ["orphaned"]), ("lone.obj", 7, ["missing"]), ("sub/far.obj", 7, ["missing"]),
                                ("stale.obj", 7, ["missing"]), ("broken.obj", 0, ["unusable-asset"])):
            entry = report["by_name"][name]
            self.assertEqual((entry["exit_code"], self.ids(entry)), (code, ids), name)
        self.assertIn("99", report["by_name"]["broken.obj"]["findings"][0]["detail"])
        self.assertIn("stale.obj.vcd", report["by_name"]["stale.obj"]["findings"][0]["detail"])
        totals = report["totals"]
        self.assertEqual({k: totals[k] for k in ("sidecars", "ok", "failed", "not_verified", "stale", "orphaned", "assets", "missing", "unusable", "warnings")},
                         {"sidecars": 6, "ok": 3, "failed": 3, "not_verified": 0, "stale": 1, "orphaned": 1, "assets": 7, "missing": 3, "unusable": 1, "warnings": 1})
        self.assertEqual(totals["failed_by_finding"], {"missing": 3, "orphaned": 1, "stale": 1, "stored-checksum": 1})
        text = self.verify(code=9)
        self.assertIn("6 sidecars: 3 ok, 3 failed, 1 stale, 1 orphaned", text.stdout)
        self.assertIn("stale.obj.vcd: object 0 \"stale\": stale: it was made for", text.stderr)

    def test_one_sidecar_keeps_its_exit_code(self):
        self.spoil()
        for name, code in (("tetra.obj.vcd", 0), ("stale.obj.vcd", 8), ("orphan.obj.vcd", 7), ("sub/far.obj.vcd", 3)):
            self.verify(inputs=["--allow", "missing", self.lib / name], code=code)

    def test_what_is_allowed_warns_and_is_counted(self):
        (self.lib / "orphan.obj").unlink()
        (self.lib / "lone.obj").write_text(tetrahedron(78))
        self.verify("--allow", "orphaned", code=9)
        self.verify("--allow", "missing", code=9)
        report = self.report("--allow", "orphaned,missing")
        self.assertEqual([report["totals"][k] for k in ("orphaned", "missing", "warnings", "failed")], [1, 1, 2, 0])
        self.assertEqual(report["by_name"]["lone.obj"]["findings"][0]["severity"], "warning")
        self.verify("--allow", "stale", code=1)

    def test_any_name_and_folder_does(self):
        (self.lib / "orphan.obj").rename(self.lib / "sub/tetra.obj")
        shutil.copy(self.lib / "tetra.obj", self.lib / "twin.obj")
        (self.folder / "sidecars").mkdir()
        for i, sidecar in enumerate(sorted(self.lib.rglob("*.vcd"))):
            sidecar.rename(self.folder / "sidecars" / f"{i}.vcd")
        shutil.copy(self.folder / "sidecars/0.vcd", self.folder / "again.vcd")
        report = self.report(inputs=[self.folder / "sidecars", self.folder / "again.vcd"])
        self.assertEqual([report["totals"][k] for k in ("sidecars", "ok", "assets", "missing")], [7, 7, 7, 0])

    def test_a_stale_sidecar_is_known_by_its_path_or_by_its_source(self):
        (self.lib / "stale.obj").write_text(tetrahedron(77))
        (self.lib / "sub/far.obj").unlink()
        (self.lib / "sub/near.obj").write_text(tetrahedron(76))
        (self.folder / "mirror/sub").mkdir(parents=True)
        (self.lib / "sub/far.obj.vcd").rename(self.folder / "mirror/sub/near.obj.vcd")
        (self.lib / "stale.obj.vcd").rename(self.folder / "mirror/renamed.vcd")
        report = self.report("--allow", "missing", inputs=[self.folder / "mirror"], code=9)
        self.assertEqual(report["totals"]["stale"], 2)
        details = " ".join(f["detail"] for e in report["files"] for f in e["findings"])
        self.assertIn("lib/stale.obj", details)
        self.assertIn("lib/sub/near.obj", details)

    def test_exchanged_sidecars_are_told(self):
        one, two = self.lib / "tetra.obj.vcd", self.lib / "renamed.obj.vcd"
        one.rename(self.lib / "x"), two.rename(one), (self.lib / "x").rename(two)
        report = self.report()
        self.assertEqual(self.ids(report["by_name"]["tetra.obj.vcd"]), ["misnamed"])
        self.assertEqual(report["totals"]["warnings"], 2)

    def test_parts_that_were_baked_as_opaque(self):
        (self.lib / "leaf.gltf").write_text(masked_quad())
        report = self.report()
        self.assertEqual(self.ids(report["by_name"]["leaf.gltf"]), ["unusable-asset"])
        self.run_program("vc-bake", self.lib / "leaf.gltf", "-q", "--all-as-opaque", "--depth", 2, "--method", "sampled", "--samples", 16)
        report = self.report()
        self.assertEqual([report["totals"][k] for k in ("ok", "missing", "unusable")], [7, 0, 0])

    def test_a_mesh_without_area_is_told(self):
        (self.lib / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
        self.assertEqual(self.ids(self.report()["by_name"]["flat.obj"]), ["unusable-asset"])

    def test_an_asset_that_cannot_be_read_is_an_error(self):
        (self.lib / "away.gltf").write_text(masked_quad().replace("MASK", "OPAQUE").replace("data:application/octet-stream;base64,", "away.bin?"))
        self.assertEqual(self.ids(self.report(code=9)["by_name"]["away.gltf"]), ["unreadable-asset"])
        self.verify("--allow", "unreadable-asset")

    def test_output_does_not_depend_on_the_threads(self):
        self.spoil()
        seen = collections.Counter()
        for threads in (1, 2, 7, 0):
            outputs = []
            for form in ("text", "json"):
                done = self.verify("-j", threads, "--format", form, "--sarif", self.folder / "s", "--junit", self.folder / "j", code=9)
                outputs += [done.stdout, done.stderr, (self.folder / "s").read_bytes(), (self.folder / "j").read_bytes()]
            seen[tuple(outputs)] += 1
        self.assertEqual(list(seen.values()), [4])

    def test_results_come_in_the_order_of_the_inputs(self):
        order = [self.lib / "tetra.obj.vcd", self.folder / "absent.vcd", self.lib / "orphan.obj.vcd", self.lib / "tetra.obj.vcd", self.lib / "sub"]
        report = self.report(library=False, inputs=order, code=9)
        self.assertEqual([os.path.relpath(e["file"], self.folder) for e in report["files"]],
                         ["lib/tetra.obj.vcd", "absent.vcd", "lib/orphan.obj.vcd", "lib/sub/far.obj.vcd"])

    def test_sarif(self):
        self.spoil()
        path = self.folder / "report.sarif"
        self.verify("--sarif", path, code=9)
        report = json.loads(path.read_text())
        self.assertEqual(report["version"], "2.1.0")
        run, = report["runs"]
        driver = run["tool"]["driver"]
        self.assertEqual(driver["name"], "vc-verify")
        self.assertEqual(run["invocations"][0]["exitCode"], 9)
        self.assertIs(run["invocations"][0]["executionSuccessful"], True)
        self.assertEqual(len({r["id"] for r in driver["rules"]}), len(driver["rules"]))
        seen = collections.defaultdict(list)
        for result in run["results"]:
            self.assertEqual(driver["rules"][result["ruleIndex"]]["id"], result["ruleId"])
            self.assertIn(result["level"], ("error", "warning"))
            self.assertTrue(result["message"]["text"])
            place = result["locations"][0]["physicalLocation"]
            uri = place["artifactLocation"]["uri"]
            self.assertRegex(uri, r"^file:///[A-Za-z0-9._~/%-]+$")
            if result["ruleId"] == "stored-checksum":
                self.assertGreater(place["region"]["byteOffset"], 0)
            name = os.fsdecode(urllib.parse.unquote_to_bytes(uri[len("file://"):]))
            self.assertTrue(os.path.exists(name), name)
            seen[result["ruleId"]].append(os.path.relpath(name, self.lib))
        self.assertEqual(seen, {"stored-checksum": ["sub/far.obj.vcd"], "stale": ["stale.obj.vcd"], "orphaned": ["orphan.obj.vcd"],
                                "missing": ["lone.obj", "stale.obj", "sub/far.obj"], "unusable-asset": ["broken.obj"]})
        self.assertEqual(run["properties"]["totals"]["failed"], 3)

    def test_sarif_names_any_file(self):
        (self.lib / ODD).write_text(tetrahedron(77))
        self.verify("--sarif", self.folder / "s", code=9)
        results = json.loads((self.folder / "s").read_text())["runs"][0]["results"]
        uris = [r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in results]
        self.assertEqual([os.fsdecode(urllib.parse.unquote_to_bytes(u)) for u in uris], [f"file://{self.lib}/{ODD}.vcd", f"file://{self.lib}/{ODD}"])

    def test_junit(self):
        self.spoil()
        (self.lib / ODD).write_text(tetrahedron(79))
        path = self.folder / "report.xml"
        self.verify("--junit", path, "--allow", "orphaned", code=9)
        suite, = xml.parse(path).getroot().iter("testsuite")
        cases = {os.path.relpath(c.get("name"), self.lib): c for c in suite.iter("testcase")}
        self.assertEqual({n: c[0].tag for n, c in cases.items() if len(c)},
                         {"sub/far.obj.vcd": "failure", "stale.obj.vcd": "failure", "orphan.obj.vcd": "system-out", "odd '\"\\x0a<&>%\\xff.obj.vcd": "failure",
                          "odd '\"\\x0a<&>%\\xff.obj": "failure", "lone.obj": "failure", "sub/far.obj": "failure", "stale.obj": "failure", "broken.obj": "skipped"})
        self.assertEqual([suite.get(k) for k in ("tests", "failures", "errors", "skipped")], ["11", "7", "0", "1"])
        self.assertEqual(cases["stale.obj.vcd"][0].get("type"), "stale")

    def test_a_folder_without_sidecars_or_meshes_is_never_ok(self):
        (self.folder / "empty").mkdir()
        self.assertIn("no sidecar", self.verify(library=False, inputs=[self.folder / "empty"], code=2).stderr)
        self.verify(library=False, inputs=[self.lib, self.folder / "empty"], code=9)
        self.assertIn("no mesh", self.verify("--against-library", self.folder / "empty", code=9).stderr)
        self.verify(library=False, inputs=[f"{self.lib}/*.nothing"], code=2)
        self.verify("--against", self.lib / "tetra.obj", code=1)  # one or the other

    def test_patterns_and_lists(self):
        (self.folder / "list").write_text(f"{self.lib}/t*.vcd\n{self.lib}/sub\n")
        self.assertEqual(self.report(library=False, inputs=[f"@{self.folder}/list"])["totals"]["ok"], 2)

    def test_a_folder_whose_name_looks_like_a_list(self):
        (self.folder / "[lib]").mkdir()
        shutil.copy(self.lib / "tetra.obj.vcd", self.folder / "[lib]")
        for arguments in (["[lib]"], ["[lib]", "--against-library", "[lib]", "--allow", "orphaned"]):
            done = subprocess.run([BIN / "vc-verify", *arguments], cwd=self.folder, capture_output=True, text=True)
            self.assertIn("[lib]/tetra.obj.vcd: ok", done.stdout)

    def test_a_sidecar_is_not_stale_because_its_asset_cannot_be_read(self):
        (self.lib / "stale.obj").unlink()
        os.mkfifo(self.lib / "stale.obj")
        report = self.report(code=9)["by_name"]
        self.assertEqual([self.ids(report[name]) for name in ("stale.obj.vcd", "stale.obj")], [["mesh-unreadable"], ["unreadable-asset"]])
        self.verify("--allow", "unreadable-asset,mesh-unreadable")

    def test_what_is_no_file_is_unreadable(self):
        os.mkfifo(self.lib / "pipe.vcd")
        (self.lib / "empty.vcd").write_bytes(b"")
        report = self.report(library=False, code=9)
        self.assertEqual(self.ids(report["by_name"]["pipe.vcd"]), ["unreadable"])
        self.assertEqual(self.ids(report["by_name"]["empty.vcd"]), ["file-too-short"])

    def test_wrong_answers_are_counted_beyond_those_listed(self):
        mesh, sidecar = self.baked("--depth", "4", text=soup(40), name="soup.obj")
        arguments = ("--against", mesh, "--lines", 100000, "--max-wrong", 0, "--keep", 1)
        report = self.report(*arguments, library=False, inputs=[sidecar], code=7)
        audit, totals = report["files"][0]["objects"][0]["audit"], report["totals"]
        self.assertEqual(len(audit["contradictions"]), 1)
        self.assertGreater(audit["contradictions_seen"], 1)
        self.assertEqual([totals["contradictions_seen"], totals["contradictions_listed"]], [audit["contradictions_seen"], 1])
        self.assertIn(f"and {totals['contradictions_seen'] - 1} more wrong answers", self.verify(*arguments, library=False, inputs=[sidecar], code=7).stdout)

    def test_reports_that_cannot_be_written(self):
        (self.folder / "folder").mkdir()
        sidecar = self.lib / "tetra.obj.vcd"
        for option in ("--sarif", "--junit"):
            self.assertIn("folder", self.verify(option, self.folder / "folder", code=2).stderr)
            self.verify(option, self.folder / "absent/report", code=1)
            before = sidecar.read_bytes()
            self.verify(option, sidecar, inputs=[self.lib / "renamed.obj.vcd"], code=1)
            self.assertEqual(sidecar.read_bytes(), before)
        self.verify("--junit", self.folder / "x", "--sarif", self.folder / "." / "x", code=1)
        for form in ("text", "json"):
            with open("/dev/full", "w") as full:
                done = subprocess.run([BIN / "vc-verify", self.lib, "--format", form], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)

    def test_interruption_leaves_nothing_unsaid(self):
        for threads in ("1", "3"):
            command = [BIN / "vc-verify", self.lib, "--against-library", self.lib, "--lines", "2000000000", "-j", threads,
                       "--format", "json", "--sarif", self.folder / "s"]
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            time.sleep(1)
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=120)
            self.assertEqual(process.returncode, 9, errors)
            totals = json.loads(output)["totals"]
            self.assertEqual([totals["sidecars"], totals["ok"], totals["not_verified"]], [6, 0, 6])
            self.assertEqual(totals["missing"], 0)
            self.assertIs(json.loads((self.folder / "s").read_text())["runs"][0]["invocations"][0]["executionSuccessful"], False)


if __name__ == "__main__":
    unittest.main()
