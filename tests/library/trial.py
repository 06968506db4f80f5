#!/usr/bin/env python3
"""Bakes a library as its users would, again and again: anew, twice, touched, changed, killed. Prints what it saw; fails where that is wrong.

    trial.py --bin BUILD/bin --assets 2000 --kills 100 --data DIR"""
import argparse
import ctypes
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import make_library

SETTINGS = ("--depth", "3", "--audit", "9000", "--time-limit", "300")


def sidecars(folder):
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.is_file() and (path.name.endswith(".vcd") or ".vcd-tmp" in path.name):
            found[os.fsencode(path.relative_to(folder))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


class Trial:
    def __init__(self, options, folder):
        self.bake = pathlib.Path(options.bin) / "vc-bake"
        self.options = options
        self.folder = folder
        self.library = folder / "library"

    def command(self, output, *more):
        return [self.bake, self.library, "-o", output, "-q", "-j", str(self.options.jobs), *SETTINGS, *more]

    def run(self, output, *more):
        """Seconds and report of one whole run."""
        name = self.folder / "report"
        start = time.monotonic()
        done = subprocess.run(self.command(output, "--report", name, *more), capture_output=True)
        seconds = time.monotonic() - start
        if done.returncode not in (0, 9):
            raise SystemExit(f"vc-bake ended with {done.returncode}: {done.stderr[-2000:]}")
        return seconds, json.loads(pathlib.Path(f"{name}.json").read_text())

    def expect(self, what, seen, wanted):
        print(f"  {what}: {seen}" + ("" if seen == wanted else f", but {wanted} was expected"), flush=True)
        if seen != wanted:
            raise SystemExit(f"trial failed: {what}")

    def good_assets(self, report):
        return [f for f in report["files"] if f["fate"] == "baked"]

    def path_of(self, entry):
        path = entry["input"]
        return pathlib.Path(path if isinstance(path, str) else os.fsdecode(bytes.fromhex(path["bytes"])))

    def all(self):
        data = self.options.data if self.options.data and os.path.isdir(self.options.data) else None
        made = make_library.make(self.library, self.options.assets, data)
        print(f"library of {made} mesh files" + ("" if data else " (no folder of real meshes)"))
        quiet = self.folder / "quiet"
        quiet.mkdir()
        first, report = self.run(quiet)
        totals = report["totals"]
        print(f"first run: {first:.1f} s, {totals['baked']} baked, {totals['failed']} failed")
        self.expect("assets looked at", totals["assets"], made)
        self.expect("baked or failed", totals["baked"] + totals["failed"], made)
        kinds = {}
        for f in report["files"]:
            if f["fate"] == "failed":
                kinds[f["kind"]] = kinds.get(f["kind"], 0) + 1
        print(f"  failures by kind: {kinds}")
        self.expect("every failure has words", all(f["error"] for f in report["files"] if f["fate"] == "failed"), True)
        before = sidecars(quiet)
        self.expect("sidecars", len(before), totals["baked"])

        second, report2 = self.run(quiet, "--update")
        print(f"second run: {second:.2f} s, {100 * second / first:.2f} % of the first")
        self.expect("baked", report2["totals"]["baked"], 0)
        for path in self.library.rglob("*"):
            os.utime(path, follow_symlinks=False)
        touched, report3 = self.run(quiet, "--update")
        print(f"after touching everything: {touched:.2f} s")
        self.expect("baked", report3["totals"]["baked"], 0)
        self.expect("bytes unchanged", sidecars(quiet) == before, True)

        random.seed(1)
        ours = [f for f in self.good_assets(report) if not str(self.path_of(f)).startswith(str(self.library / "real")) and f["bytes"] > 0]
        changed = random.sample([f for f in ours if self.path_of(f).suffix in (".obj", ".ply", ".stl", ".glb", ".off")], min(5, len(ours)))
        if not changed:
            raise SystemExit("trial failed: no mesh of our own to change; raise --assets")
        for i, f in enumerate(changed):
            path = self.path_of(f)
            path.write_bytes(make_library.WRITERS[path.suffix](*make_library.shape(10 ** 6 + i)))
        _, report4 = self.run(quiet, "--update")
        print("after changing meshes:")
        self.expect("baked", sorted(str(f["input"]) for f in self.good_assets(report4)), sorted(str(f["input"]) for f in changed))
        self.kills(quiet, first)

    def kills(self, quiet, seconds):
        """Killed again and again; the end must be as if nothing had happened."""
        killed = self.folder / "killed"
        killed.mkdir()
        events = self.folder / "events.jsonl"
        command = self.command(killed, "--resume", "--events", events, "--cache", self.folder / "cache")
        # So that children that outlive their parent become ours and can be seen.
        ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)
        rng = random.Random(2)
        done = 0
        for k in range(self.options.kills):
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                process.wait(timeout=rng.uniform(0, 2 * max(seconds, 1) / max(self.options.kills, 1)))
                done += 1
            except subprocess.TimeoutExpired:
                process.send_signal(rng.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)))
                process.wait()
            deadline = time.monotonic() + 10
            while time.monotonic() < deadline:
                try:
                    if os.waitpid(-1, os.WNOHANG)[0] == 0:
                        time.sleep(0.01)
                except ChildProcessError:
                    break
            else:
                raise SystemExit("trial failed: a child outlives its parent")
        print(f"killed {self.options.kills - done} times of {self.options.kills}")
        subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = sidecars(killed)
        self.expect("leftover temporary files", sum(b".vcd-tmp" in name for name in after), 0)
        self.expect("same sidecars as undisturbed", after == sidecars(quiet), True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--assets", type=int, default=60)
    parser.add_argument("--kills", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--data", default="")
    parser.add_argument("--keep", help="folder to work in, kept afterwards")
    options = parser.parse_args()
    folder = pathlib.Path(options.keep or tempfile.mkdtemp(prefix="vcd-trial-"))
    folder.mkdir(parents=True, exist_ok=True)
    try:
        Trial(options, folder.resolve()).all()
    finally:
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
