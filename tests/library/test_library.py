"""Libraries as their owners meet them: many assets, odd names, broken disks, caches, manifests, interruptions."""
import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import make_library

BIN = pathlib.Path(os.environ["VCD_BIN"])
DATA = pathlib.Path(os.environ.get("VCD_TEST_DATA", ""))
HERE = pathlib.Path(__file__).resolve().parent
FAST = ("--depth", "2", "--audit", "9000")


def processes_of(session):
    """Those that live in a session, zombies too."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(stat.read_text(errors="replace").rpartition(")")[2].split()[3]) == session:
                found.append(int(stat.parent.name))
        except OSError:
            pass
    return found


class Case(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name).resolve()
        self.library = self.folder / "library"
        self.library.mkdir()

    def bake(self, *arguments, code=0, settings=FAST, **options):
        done = subprocess.run([BIN / "vc-bake", *map(str, arguments), *settings], capture_output=True, text=True, errors="surrogateescape", timeout=600, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def report(self, *arguments, code=0, settings=FAST):
        return json.loads(self.bake(*arguments, "--format", "json", code=code, settings=settings).stdout)

    def fates(self, *arguments, code=0):
        return {pathlib.Path(f["input"]).name: f["fate"] for f in self.report(*arguments, code=code)["files"]}

    def mesh(self, name="a.obj", seed=1):
        path = self.library / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(make_library.WRITERS[path.suffix](*make_library.shape(seed)))
        return path

    def gltf(self, name="a", seed=1):
        text, data = make_library.gltf_parts(*make_library.shape(seed), uri=f"{name}.bin")
        (self.library / f"{name}.gltf").write_bytes(text)
        (self.library / f"{name}.bin").write_bytes(data)
        return self.library / f"{name}.gltf"

    def files(self, folder=None):
        folder = folder or self.library
        return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())

    def bytes(self, folder):
        return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in self.files(folder)}


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
        for settings, more, methods in (({"method": "hybrid"}, (), ["hybrid", "sampled"]), ({}, ("--method", "hybrid"), ["hybrid", "sampled"]),
                                        ({}, (), ["sampled", "sampled"])):
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


class Trouble(Case):
    def at_work(self, process, hundredths):
        """Its workers that have worked so long themselves, and so have read their mesh: that is a process of its own, and brief."""
        found = []
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # what ends meanwhile
            for worker in pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
                times = pathlib.Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()[11:13]
                if sum(map(int, times)) >= hundredths:
                    found.append(int(worker))
        return found

    def test_a_hang_costs_itself_alone(self):
        self.mesh("a.obj")
        slow = self.mesh("slow.obj", 2)
        manifest = self.folder / "m.json"
        manifest.write_text(json.dumps({"vcd_manifest": 1, "assets": [{"input": str(self.library / "a.obj")},
                                                                      {"input": str(slow), "settings": {"depth": "8"}}]}))
        report = self.report("--manifest", manifest, "--time-limit", 3, code=9)
        self.assertEqual([f["fate"] for f in report["files"]], ["baked", "failed"])
        self.assertEqual(report["files"][1]["kind"], "time")
        self.assertIn("took more than 3 s while baking", report["files"][1]["error"])
        self.assertEqual(self.files(), ["a.obj", "a.obj.vcd", "slow.obj"])

    def strip(self, indices):
        """A small glTF that names a long strip over four vertices: more memory than its size lets guess."""
        data = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1) + bytes(range(4)) * (indices // 4)
        document = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data), "uri": "other.bin"}],
                    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": indices}],
                    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                                  {"bufferView": 1, "componentType": 5121, "count": indices, "type": "SCALAR"}],
                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}]}]}
        (self.library / "strip.gltf").write_text(json.dumps(document))
        (self.library / "other.bin").write_bytes(data)

    @unittest.skipIf("VCD_SANITIZED" in os.environ, "sanitizers have no limit on memory")
    def test_want_of_memory_is_met_with_more_and_then_given_up(self):
        self.mesh("a.obj")
        self.strip(12000000)
        report = self.report(self.library)
        self.assertEqual([(f["fate"], f["attempts"] > 1) for f in report["files"]], [("baked", False), ("baked", True)])
        self.strip(40000000)
        report = self.report(self.library, "--memory-mb", 256, code=9)
        self.assertEqual([f["fate"] for f in report["files"]], ["baked", "failed"])
        failed = report["files"][1]
        self.assertEqual((failed["kind"], failed["attempts"]), ("memory", 2))
        self.assertRegex(failed["error"], "strip.gltf: .*out of memory")
        self.assertLess(failed["peak_memory_bytes"], 256 * 2 ** 20)

    def test_a_crash_is_run_once_more_and_named(self):
        mesh = self.mesh("a.obj", 5)
        process = subprocess.Popen([BIN / "vc-bake", mesh, "--depth", "8", "--format", "json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        killed = set()
        while process.poll() is None:
            for worker in self.at_work(process, 20):
                if worker not in killed:
                    killed.add(worker)
                    os.kill(worker, signal.SIGSEGV)
            time.sleep(0.02)
        out, _ = process.communicate()
        failed, = json.loads(out)["files"]
        self.assertEqual((failed["kind"], failed["attempts"], len(killed)), ("crash", 2, 2))
        self.assertIn("a.obj: crashed (SIGSEGV) while ", failed["error"])
        self.assertEqual(self.files(), ["a.obj"])

    def test_leftovers_of_the_killed_are_removed_and_meshes_are_not_written_over(self):
        mesh = self.mesh("a.obj")
        (self.library / ".vcd-tmp-1").write_bytes(b"half")
        before = mesh.read_bytes()
        for option in ("--events", "--depfile"):
            self.bake(mesh, option, mesh, code=1)
        self.assertEqual(mesh.read_bytes(), before)
        self.bake(mesh, "-q")
        self.assertEqual(self.files(), ["a.obj", "a.obj.vcd"])

    def test_nothing_waits_at_a_pipe_or_reads_a_device(self):
        os.mkfifo(self.library / "pipe.obj"), os.mkfifo(self.library / "pipe.glb"), os.mkfifo(self.library / "pipe.gltf")
        (self.library / "device.ply").symlink_to("/dev/zero")
        self.mesh("a.obj")
        for more in ((), ("--update",)):
            report = self.report(self.library, *more, code=9)
            self.assertEqual(sum(f.get("error", "").endswith("not a regular file") for f in report["files"]), 4)
        plan = subprocess.run([BIN / "vc-farm", "plan", self.folder / "plan", self.library], capture_output=True, text=True, timeout=60)
        self.assertEqual(plan.returncode, 0, plan.stderr)

    def test_events_that_cannot_be_written_and_numbers_that_are_none(self):
        self.mesh("a.obj")
        for option in ("--budget-mb", "--budget-seconds", "--time-limit", "--memory-mb"):
            self.assertIn("nan is not a number", self.bake(self.library, option, "nan", code=1).stderr)
        self.assertIn("not all events could be written", self.bake(self.library, "-q", "--events", "/dev/full", code=9).stderr)

    def test_closed_streams_and_a_hang_up_that_is_ignored(self):
        self.mesh("a.obj")
        command = " ".join(["exec", str(BIN / "vc-bake"), f"'{self.library}' --audit 0"])
        for closed in ("2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            self.assertEqual(subprocess.run(["sh", "-c", f"{command} --depth 2 {closed}"], stdout=subprocess.DEVNULL, timeout=120).returncode, 0, closed)
        process = subprocess.Popen(["sh", "-c", f"trap '' HUP; {command} --depth 6"], stderr=subprocess.PIPE, text=True, start_new_session=True)
        while not self.at_work(process, 10):
            self.assertIsNone(process.poll())
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGHUP)
        time.sleep(0.5)
        self.assertIsNone(process.poll())
        os.killpg(process.pid, signal.SIGTERM)
        process.communicate(timeout=60)

    def test_fail_fast(self):
        for i in range(6):
            (self.library / f"bad{i}.obj").write_text("f 1 2 3\n")
        fates = list(self.fates(self.library, "--fail-fast", "-j", 1, code=9).values())
        self.assertEqual((fates.count("failed"), fates.count("not-run")), (1, 5))

    def test_interruption_leaves_whole_files_and_no_process(self):
        for i in range(30):
            self.mesh(f"{i}.obj", i)
        for kind in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            process = subprocess.Popen([BIN / "vc-bake", self.library, "-q", "--depth", "5"], stderr=subprocess.PIPE, text=True, start_new_session=True)
            time.sleep(1.0)
            process.send_signal(kind)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, -9 if kind == signal.SIGKILL else 9, errors)
            deadline = time.monotonic() + 10
            while time.monotonic() < deadline and processes_of(process.pid):
                time.sleep(0.05)
            self.assertEqual(processes_of(process.pid), [])
            self.assertEqual([n for n in self.files() if "tmp" in n], [])
        sidecars = [n for n in self.files() if n.endswith(".vcd")]
        if sidecars:
            subprocess.run([BIN / "vc-verify", "-q", *(self.library / n for n in sidecars)], check=True)

    def test_a_source_that_changes_meanwhile(self):
        mesh = self.mesh("a.obj", 5)
        depth = "4" if "VCD_SANITIZED" in os.environ else "6"
        process = subprocess.Popen([BIN / "vc-bake", mesh, "--depth", depth, "--audit", "0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not self.at_work(process, 30):
            time.sleep(0.02)
        self.mesh("a.obj", 6)
        self.assertIsNone(process.poll(), "the bake was over before the file changed")
        _, errors = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 2, errors)
        self.assertIn("a.obj changed while it was baked", errors)
        self.assertEqual(self.files(), ["a.obj"])

    def test_two_bakers_on_one_folder(self):
        for i in range(8):
            self.mesh(f"{i}.obj", i)
        (self.folder / "alone").mkdir()
        self.bake(self.library, "-q", "-o", self.folder / "alone")
        (self.folder / "both").mkdir()
        both = [subprocess.Popen([BIN / "vc-bake", self.library, "-q", "-o", self.folder / "both", "--cache", self.folder / "cache", *FAST]) for _ in range(2)]
        self.assertEqual([p.wait(timeout=300) for p in both], [0, 0])
        self.assertEqual(self.bytes(self.folder / "both"), self.bytes(self.folder / "alone"))

    def test_a_full_disk(self):
        small = self.folder / "small"
        small.mkdir()
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", small], capture_output=True).returncode != 0:
            self.skipTest("needs the right to mount a small tmpfs")
        self.addCleanup(subprocess.run, ["umount", small], check=True)
        for i in range(6):
            self.mesh(f"{i}.obj", 20 + i)
        report = self.report(self.library, "-o", small, code=9, settings=("--depth", "4", "--audit", "9000"))
        failed = [f for f in report["files"] if f["fate"] == "failed"]
        self.assertGreater(len(failed), 0)
        for f in failed:
            self.assertEqual(f["kind"], "io")
            self.assertIn("No space left on device", f["error"])
        self.assertEqual(len(self.files(small)), 6 - len(failed))

    def test_a_folder_that_cannot_be_written(self):
        if os.geteuid() != 0 or subprocess.run(["mount", "--bind", self.library, self.library], capture_output=True).returncode != 0:
            self.skipTest("needs the right to mount a folder read-only")
        self.addCleanup(subprocess.run, ["umount", self.library], check=True)
        self.mesh("a.obj")
        subprocess.run(["mount", "-o", "remount,ro,bind", self.library], check=True)
        done = self.bake(self.library, code=2)
        self.assertIn("a.obj.vcd: cannot create a temporary file beside it: Read-only file system", done.stderr)


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
