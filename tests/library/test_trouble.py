"""What goes wrong while a library is baked: hangs, crashes, want of memory, full disks, interruptions, odd files."""
import contextlib
import json
import os
import pathlib
import signal
import struct
import subprocess
import time
import unittest

import make_library
from library_case import BIN, FAST, Case, processes_of


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
        while not (workers := self.at_work(process, 10)):
            self.assertIsNone(process.poll())
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGHUP)
        time.sleep(0.5)
        self.assertIsNone(process.poll())
        self.assertEqual(self.at_work(process, 10), workers)  # they ignore it as well
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
        depth = "4" if "VCD_SANITIZED" in os.environ else "5"
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


if __name__ == "__main__":
    unittest.main()
