"""Libraries as their owners meet them: many assets, odd names, caches, manifests, reports."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import make_library
from library_case import BIN, Case

DATA = pathlib.Path(os.environ.get("VCD_TEST_DATA", ""))
HERE = pathlib.Path(__file__).resolve().parent


class Finding(Case):
    def test_folders_patterns_and_lists(self):
        self.mesh("a.obj"), self.mesh("sub/b.ply", 2), self.mesh("sub/deep/c.glb", 3), (self.library / "notes.txt").write_text("x")
        report = self.report(self.library, "--dry-run")
        self.assertEqual([f["input"] for f in report["files"]], [str(self.library / n) for n in ("a.obj", "sub/b.ply", "sub/deep/c.glb")])
        self.assertEqual(report["other_files"], 1)
        self.assertEqual(set(self.fates(self.library / "**" / "*.[pg]*", "--dry-run")), {"b.ply", "c.glb"})
        (self.folder / "list").write_text(f"{self.library}/sub\n{self.library}/a.obj\n")
        self.assertEqual(set(self.fates(f"@{self.folder}/list", "--dry-run")), {"a.obj", "b.ply", "c.glb"})

    def test_mirrored_below_the_output(self):
        self.mesh("a.obj"), self.mesh("sub/b.ply", 2)
        self.bake(self.library, "-o", self.folder / "out", "-q", "--dry-run")
        self.assertFalse((self.folder / "out").exists())
        self.bake(self.library, "-o", self.folder / "out", "-q")
        self.assertEqual(self.files(self.folder / "out"), ["a.obj.vcd", "sub/b.ply.vcd"])

    def test_names_of_any_bytes(self):
        odd = [b"two words.obj", b"quo\"te's.obj", b"new\nline.obj", b"\xff\xfe.obj", "Ähre.obj".encode(), b"-dash.obj", b"[x]*.obj", b"{}$#%.obj"]
        for i, name in enumerate(odd):
            with open(os.fsencode(self.library) + b"/" + name, "wb") as out:
                out.write(make_library.as_obj(*make_library.shape(i)))
        self.bake(self.library, "-q", "--report", self.folder / "r", "--events", self.folder / "e")
        names = set(os.listdir(os.fsencode(self.library)))
        self.assertEqual(names, {n + s for n in odd for s in (b"", b".vcd")})
        report = json.loads((self.folder / "r.json").read_text())
        self.assertIn({"bytes": (os.fsencode(self.library) + b"/\xff\xfe.obj").hex()}, [f["input"] for f in report["files"]])
        self.assertEqual(self.report(self.library, "--update")["totals"]["up_to_date"], len(odd))
        manifest = self.folder / "m.json"
        manifest.write_text(json.dumps({"vcd_manifest": 1, "assets": [{"input": f["input"]} for f in report["files"]]}))
        self.assertEqual(self.report("--manifest", manifest, "--update")["totals"]["up_to_date"], len(odd))

    def test_links_and_loops(self):
        mesh = self.mesh("sub/a.obj")
        os.symlink("..", self.library / "sub" / "up")
        os.symlink(mesh, self.library / "linked.obj")
        os.symlink("nowhere", self.library / "lost.obj")
        done = self.bake(self.library, "-q", code=9)
        self.assertIn("lost.obj: No such file", done.stderr)
        self.assertEqual(self.files(), ["linked.obj", "linked.obj.vcd", "sub/a.obj", "sub/a.obj.vcd"])

    def test_nothing_found_is_an_error(self):
        self.assertIn("no mesh file found", self.bake(self.library, code=2).stderr)
        self.assertIn("no file matches", self.bake(self.library / "*.obj", code=2).stderr)

    def test_manifest(self):
        self.mesh("a.obj"), self.mesh("b.obj", 2)
        manifest = self.library / "manifest.json"
        manifest.write_text(json.dumps({"vcd_manifest": 1, "settings": {"depth": "1"},
                                        "assets": [{"input": "a.obj", "output": "x.vcd", "settings": {"depth": "3", "method": "proven"}}, {"input": "b.*"}]}))
        files = self.report("--manifest", manifest)["files"]
        self.assertEqual([(pathlib.Path(f["output"]).name, f["objects"][0]["depth"], f["objects"][0]["method"]) for f in files],
                         [("x.vcd", 3, "proven"), ("b.obj.vcd", 1, "hybrid")])
        for settings, more, methods in (({}, (), ["hybrid", "sampled"]), ({"method": "sampled"}, (), ["sampled", "sampled"]), ({}, ("--method", "sampled"), ["sampled", "sampled"])):
            assets = [{"input": "a.obj", "settings": {"samples": 81}}, {"input": "b.obj", "settings": {"samples": 81, "method": "sampled"}}]
            manifest.write_text(json.dumps({"vcd_manifest": 1, "settings": settings, "assets": assets}))
            self.assertEqual([f["objects"][0]["method"] for f in self.report("--manifest", manifest, *more)["files"]], methods)
        for bad, words in (("{", "not JSON"), ('{"vcd_manifest": 1}', 'no array "assets"'), ('{"vcd_manifest": 2, "assets": []}', "only version 1"),
                           ('{"vcd_manifest": 1, "assets": [{"input": "a.obj", "depth": 3}]}', 'assets[0]: unknown member "depth"'),
                           ('{"vcd_manifest": 1, "assets": [{"input": "a.obj", "settings": {"depth": 9}}]}', "assets[0]: settings: "),
                           ('{"vcd_manifest": 1, "assets": [{"input": {"bytes": "0g"}}]}', "assets[0].input")):
            manifest.write_text(bad)
            self.assertIn(words, self.bake("--manifest", manifest, code=5 if "only version" in words else 1).stderr)

    def test_no_mesh_is_replaced_and_no_sidecar_twice(self):
        a, b = self.mesh("a.obj"), self.mesh("b.obj", 2)
        before = self.bytes(self.library)
        for words, arguments in (("not a folder", ("-o", a, b)), ("not a folder", (a, b, "-o", b)), ("not a folder", (a, b, "-o", "new.vcd"))):
            self.assertIn(words, self.bake(*arguments, code=1).stderr)
        manifest = self.folder / "manifest.json"
        for words, assets in (("is a mesh to bake", [(a, a), (b, b)]), ("is named like a mesh", [(a, b)]), ("would be written to", [(a, "x.vcd"), (b, "../library/x.vcd")])):
            manifest.write_text(json.dumps({"vcd_manifest": 1, "assets": [{"input": str(i), "output": str(self.library / o)} for i, o in assets]}))
            self.assertIn(words, self.bake("--manifest", manifest, code=1).stderr)
        self.assertEqual(self.bytes(self.library), before)

    def test_what_is_written_beside_the_sidecars_replaces_nothing(self):
        a, manifest = self.mesh("a.obj"), self.folder / "library.json"
        manifest.write_text(json.dumps({"vcd_manifest": 1, "assets": [{"input": str(a), "output": str(self.folder / "x.json")}]}))
        before = self.bytes(self.folder)
        for words, arguments in (("a manifest", ("--report", self.folder / "library")), ("a manifest", ("--events", manifest)),
                                 ("a sidecar", ("--report", self.folder / "x")), ("a sidecar", ("--depfile", self.folder / "x.json")),
                                 ("what else this run writes", ("--depfile", self.folder / "y", "--events", self.folder / "library/../y"))):
            self.assertIn("would replace " + words, self.bake("--manifest", manifest, *arguments, code=1).stderr)
        self.assertEqual(self.bytes(self.folder), before)
        self.bake(a, "-q", "--report", self.folder / "new/report")
        self.assertEqual(self.files(self.folder / "new"), ["report.html", "report.json"])

    def test_patterns_and_lists_mean_the_same_on_the_second_run(self):
        self.mesh("a.obj"), (self.library / "notes.txt").write_text("x")
        for pattern in (f"{self.library}/*", f"{self.library}/**"):
            for _ in range(2):
                self.bake(pattern, "-q", "--update")
        a, sidecar = self.library / "a.obj", self.library / "a.obj.vcd"
        self.assertIn("no mesh file found", self.bake(sidecar, code=2).stderr)
        self.bake(a, sidecar, "-q")  # as the shell's pattern gives them
        meshes = self.folder / "meshes"
        for names in (["a.obj"], ["a.obj", "b.obj"]):
            self.mesh("b.obj", 2)
            meshes.write_text("".join(f"{self.library / name}\n" for name in names))
            self.bake(f"@{meshes}", "-q", "-o", self.folder / "out")
            self.assertEqual(self.files(self.folder / "out"), [name + ".vcd" for name in names])


class Updating(Case):
    def test_only_what_changed_in_content_settings_or_name(self):
        a, b = self.mesh("a.obj"), self.mesh("b.ply", 2)
        gltf = self.gltf("c", 3)
        self.bake(self.library, "-q")
        before = self.bytes(self.library)
        for path in self.library.iterdir():
            os.utime(path, (1, 1))
        self.assertEqual(set(self.fates(self.library, "--update").values()), {"up-to-date"})
        self.assertEqual(self.bytes(self.library), before)
        self.mesh("b.ply", 4)
        self.assertEqual(self.fates(self.library, "--update"), {"a.obj": "up-to-date", "b.ply": "baked", "c.gltf": "up-to-date"})
        data = bytearray(gltf.with_suffix(".bin").read_bytes())
        data[1] ^= 0xFF
        gltf.with_suffix(".bin").write_bytes(data)
        self.assertEqual(self.fates(self.library, "--update"), {"a.obj": "up-to-date", "b.ply": "up-to-date", "c.gltf": "baked"})
        report = self.report(self.library, "--update", "--seed", 5)
        self.assertEqual((report["totals"]["baked"], report["totals"]["objects_reused"]), (3, 0))  # another tree
        (self.library / "b.ply.vcd").write_bytes(b"damaged")
        self.assertEqual(self.fates(self.library, "--update", "--seed", 5)["b.ply"], "baked")
        os.rename(f"{a}.vcd", self.library / "b.ply.vcd")
        self.assertEqual(self.fates(self.library, "--update", "--seed", 5), {"a.obj": "baked", "b.ply": "baked", "c.gltf": "up-to-date"})
        for copied in ("", ".vcd"):  # the same mesh by another name, which its object has too
            shutil.copy(f"{a}{copied}", self.library / f"d.obj{copied}")
        self.assertEqual(self.fates(self.library, "--update", "--seed", 5)["d.obj"], "baked")

    def test_how_a_sidecar_is_stored_is_part_of_it(self):
        self.mesh("a.obj")
        self.bake(self.library, "-q")
        report = self.report(self.library, "--update", "--storage", "ship")
        self.assertEqual((report["totals"]["baked"], report["totals"]["objects_reused"]), (1, 1))
        self.assertEqual(self.fates(self.library, "--update", "--storage", "ship"), {"a.obj": "up-to-date"})
        self.assertEqual(self.fates(self.library, "--update"), {"a.obj": "baked"})

    def test_a_change_that_neither_box_nor_counts_show_is_baked(self):
        positions, triangles = make_library.shape(1)
        mesh = self.mesh("a.obj")
        self.bake(self.library, "-q")
        inner = min(range(len(positions)), key=lambda i: sum(x * x for x in positions[i]))
        positions[inner] = tuple(0.75 * x for x in positions[inner])
        mesh.write_bytes(make_library.as_obj(positions, triangles))
        report = self.report(self.library, "--update")
        self.assertEqual((report["totals"]["baked"], report["totals"]["objects_reused"]), (1, 0))

    def test_equal_geometry_is_not_baked_again(self):
        mesh = self.mesh("a.obj")
        self.bake(self.library, "-q", "--cache", self.folder / "cache")
        first = pathlib.Path(f"{mesh}.vcd").read_bytes()
        mesh.write_bytes(b"# a comment\n" + mesh.read_bytes())
        report = self.report(self.library, "--update")
        self.assertEqual((report["totals"]["baked"], report["totals"]["objects_reused"]), (1, 1))
        self.mesh("other/renamed.ply")
        report = self.report(self.library, "--update", "--cache", self.folder / "cache")
        self.assertEqual([(f["fate"], f.get("objects", [{}])[0].get("reused")) for f in report["files"]], [("up-to-date", None), ("baked", True)])
        cold = self.folder / "cold.vcd"
        self.bake(self.library / "other/renamed.ply", "-q", "-o", cold)
        self.assertEqual(cold.read_bytes(), (self.library / "other/renamed.ply.vcd").read_bytes())
        self.assertNotEqual(first, cold.read_bytes())  # the mesh's name is in it

    def test_a_damaged_cache_entry_is_not_used(self):
        self.mesh("a.obj")
        self.bake(self.library, "-q", "--cache", self.folder / "cache")
        entry, = (self.folder / "cache").rglob("*.vcd")
        data = bytearray(entry.read_bytes())
        data[-10] ^= 1
        entry.write_bytes(data)
        self.assertEqual(self.report(self.library, "--cache", self.folder / "cache")["totals"]["objects_reused"], 0)
        self.assertEqual(self.report(self.library, "--cache", self.folder / "cache")["totals"]["objects_reused"], 1)
        self.assertEqual(self.report(self.library, "--cache", self.folder / "cache", "--seed", 5)["totals"]["objects_reused"], 0)

    def test_prune(self):
        mesh = self.mesh("a.obj")
        self.mesh("b.obj", 2)
        self.bake(self.library, "-q")
        strange = self.library / "strange.vcd"
        strange.write_bytes(b"not ours")
        mesh.unlink()
        dry = self.report(self.library, "--update", "--prune", "--dry-run")
        self.assertEqual([pathlib.Path(p).name for p in dry["pruned"]], ["a.obj.vcd"])
        self.assertIn(f"remove     {mesh}.vcd", self.bake(self.library, "--update", "--prune", "--dry-run").stdout)
        self.assertIn("a.obj.vcd", self.files())
        os.symlink("nowhere", self.library / "lost.obj")
        self.bake(self.library, "--update", "--prune", code=9)
        self.assertIn("a.obj.vcd", self.files())  # not everything was found
        os.unlink(self.library / "lost.obj")
        self.bake(self.library, "--update", "--prune")
        self.assertEqual(self.files(), ["b.obj", "b.obj.vcd", "strange.vcd"])
        other = self.folder / "other"
        other.mkdir()  # a share, say, that is not there today
        self.assertIn("no mesh is below", self.bake(other, self.library, "--update", "--prune").stderr)

    def test_prune_leaves_a_cache_alone(self):
        self.mesh("a.obj")
        for _ in range(2):
            self.bake(self.library, "-q", "--prune", "--update", "--cache", self.library / "cache")
        self.assertEqual(len(list((self.library / "cache").rglob("*.vcd"))), 1)

    def test_an_asset_that_went_bad_keeps_its_sidecar_and_says_so(self):
        mesh = self.mesh("a.obj")
        self.mesh("b.obj", 2)
        self.bake(self.library, "-q")
        mesh.write_text("f 1 2 3\n")
        report = self.report(self.library, "--update", code=9)
        self.assertIn("before", report["files"][0]["old_sidecar"])

    def test_resume_does_not_try_again_what_failed(self):
        self.mesh("good.obj")
        bad = self.library / "bad.obj"
        bad.write_text("f 1 2 3\n")
        events = self.folder / "events"
        self.bake(self.library, "-q", "--events", events, code=9)
        with open(events, "a") as out:
            out.write('{"event":"ended","inp')  # a run that was killed
        self.assertEqual(self.fates(self.library, "--resume", "--events", events, code=9), {"bad.obj": "failed-before", "good.obj": "up-to-date"})
        self.assertEqual(events.read_text().count('\n{"event":"run-started"'), 1)  # not behind the half of a line
        bad.write_bytes(make_library.as_obj(*make_library.shape(3)))
        self.assertEqual(self.fates(self.library, "--resume", "--events", events), {"bad.obj": "baked", "good.obj": "up-to-date"})

    def test_resume_tries_again_what_could_not_be_written(self):
        mesh, events = self.mesh("a.obj"), self.folder / "events"
        self.library.joinpath("a.obj.vcd").mkdir()
        self.assertIn("not a regular file", self.bake(self.library, "-q", "--events", events, code=2).stderr)
        self.library.joinpath("a.obj.vcd").rmdir()
        self.assertEqual(self.fates(self.library, "--resume", "--events", events), {"a.obj": "baked"})

    def test_dry_run_writes_nothing(self):
        self.mesh("a.obj")
        self.assertIn("no sidecar yet", self.bake(self.library, "--dry-run", "--update", "--events", self.folder / "e").stdout)
        self.assertEqual(self.files(self.folder), ["library/a.obj"])

    def test_depfile(self):
        gltf = self.gltf("with space", 3)
        for more in ((), ("--update",)):
            self.bake(gltf, "-q", "--depfile", self.folder / "d", *more)
            words = (self.folder / "d").read_text().replace("\\\n", " ").replace("\\ ", "\0").split()
            self.assertEqual([w.replace("\0", " ") for w in words], [f"{gltf}.vcd:", str(gltf), str(gltf.with_suffix(".bin")), f"{gltf.with_suffix('.bin')}:"])

    def test_a_depfile_names_what_make_and_ninja_misread_by_links(self):
        mesh = self.mesh("it's 50%.obj")
        for more in ((), ("--depfile-target", "stamp")):
            self.bake(mesh, "-q", "--depfile", self.folder / "d", *more)
            link = self.folder / "d.links" / "1"
            target = "stamp" if more else f"{mesh}.vcd".replace(" ", "\\ ")
            self.assertEqual((self.folder / "d").read_text(), f"{target}: \\\n  {link}\n")
            self.assertEqual(link.resolve(), mesh)
        link.unlink()
        link.write_text("mine")  # no link of ours
        self.assertIn("cannot be made", self.bake(mesh, "-q", "--depfile", self.folder / "d", code=9).stderr)
        self.assertEqual(link.read_text(), "mine")


class Reports(Case):
    def test_report_page_and_events(self):
        self.mesh("a.obj")
        (self.library / "<b>&.obj").write_text("f 1 2 3\n")
        self.bake(self.library, "-q", "--report", self.folder / "r", "--events", self.folder / "e", code=9)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["totals"] | {"bytes": 0}, {"assets": 2, "baked": 1, "objects_reused": 0, "up_to_date": 0, "failed": 1, "failed_before": 0, "not_run": 0, "bytes": 0})
        page = (self.folder / "r.html").read_text()
        for text in ("a.obj", "&lt;b&gt;&amp;.obj", "invalid-file", "95 %"):
            self.assertIn(text, page)
        self.assertNotIn("<b>&", page)
        (self.library / "a.obj").write_text("f 1 2 3\n")
        self.bake(self.library, "-q", "--report", self.folder / "r", code=9)
        self.assertRegex((self.folder / "r.html").read_text(), r"<td>line 1: [^<]* \(an older sidecar is in place, [^<]*before[^<]*\)</td>")
        events = [json.loads(line) for line in (self.folder / "e").read_text().splitlines()]
        self.assertEqual([e["event"] for e in events].count("ended"), 2)
        self.assertEqual((events[0]["event"], events[-1]["event"]), ("run-started", "run-ended"))
        piped = self.bake(self.library, "-q", "--events", "-", code=9).stdout
        self.assertEqual([json.loads(line)["event"] for line in piped.splitlines()][-1], "run-ended")

    def test_report_links_to_pages(self):
        self.mesh("a b.obj"), self.mesh("c.obj")
        linked = lambda: re.findall('<a href="([^"]*)">([^<]*)</a>', (self.folder / "reports/r.html").read_text())
        update = lambda: self.bake(self.library, "-q", "--update", "--report", self.folder / "reports/r")
        update()
        self.assertEqual(linked(), [])
        subprocess.run([BIN / "vc-info", "--pages", "-q", self.library / "a b.obj.vcd"], check=True)
        update()
        self.assertEqual(linked(), [("../library/a%20b.obj.vcd.html", str(self.library / "a b.obj"))])
        pages = [f.get("page") for f in json.loads((self.folder / "reports/r.json").read_text())["files"]]
        self.assertEqual(pages, [str(self.library / "a b.obj.vcd.html"), None])
        os.utime(self.library / "a b.obj.vcd.html", (0, 0))  # older than the sidecar
        update()
        self.assertEqual(linked(), [])


TWICE = "what it runs is run with sanitizers by other tests, and without them by this one"


@unittest.skipIf("VCD_SANITIZED" in os.environ, TWICE)
class Hostile(Case):
    def test_every_hostile_file_has_the_outcome_of_the_table(self):
        folder = DATA / "hostile"
        if not folder.is_dir():
            self.skipTest(f"{folder} is not there")
        report = self.report(folder, "-o", self.library, "-q", code=9)
        seen = {}
        for f in report["files"]:
            name = f["input"][len(str(folder)) + 1:]
            words = f.get("error", "").replace(f"{folder}/", "").removeprefix(f"{name}: ")
            seen[name] = (f.get("kind", f["fate"]), words or f'{sum(o["triangle_count"] for o in f["objects"])} triangles in {len(f["objects"])} objects')
        lines = (HERE / "hostile_outcomes.tsv").read_text().splitlines()[1:]
        wanted = {name: (kind, words) for name, kind, words in (line.split("\t") for line in lines)}
        self.maxDiff = None
        self.assertEqual(seen, wanted)


@unittest.skipIf("VCD_SANITIZED" in os.environ, TWICE)
class Trial(Case):
    def test_a_small_library_anew_twice_touched_changed_and_killed(self):
        done = subprocess.run([sys.executable, HERE / "trial.py", "--bin", BIN, "--assets", "40", "--kills", "8"], capture_output=True, text=True, timeout=1200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
