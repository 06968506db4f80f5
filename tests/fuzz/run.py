#!/usr/bin/env python3
"""Runs the fuzz targets and prints what they did: spec/fuzzing.md. Exit code 0: no finding; 1: findings; 2: cannot run."""
import argparse
import concurrent.futures
import contextlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
GOLDEN = HERE.parent / "golden"
INTERRUPTED = 72  # libFuzzer's exit code
MOST_FINDINGS = 10  # of one target in one run: then it is stopped

# Largest input in bytes. Sidecars of depth 6 to 8 need their top tables, which compress well.
LARGEST = {"obj": 4096, "off": 4096, "ply": 4096, "stl": 4096, "gltf": 8192, "drc": 4096, "wire": 2048,
           "sidecar": 40000, "runtime": 40000, "demand": 2048, "bake": 512, "scenes": 512}
SIDECARS = ("sidecar", "runtime")
# Formats that are read by libdraco too, which is known not to be safe. What it does wrong there is no finding as long as the
# program, which reads in a child process, ends with an error of its own.
FENCED = ("drc", "gltf")
FENCED_LIBRARY = "libdraco"


def seed_folders(name):
    if name in SIDECARS:
        return [GOLDEN, GOLDEN / "invalid"]
    return [folder for folder in [HERE / "seeds" / name] if folder.is_dir()]


def seed_files(name):
    return [str(file) for folder in seed_folders(name) for file in sorted(folder.iterdir()) if file.is_file()]


class Target:
    def __init__(self, name, options, folder):
        self.name, self.options = name, options
        self.binary = options.bin / ("fuzz_" + name)
        self.corpus = (options.corpus or folder) / name
        self.corpus.mkdir(parents=True, exist_ok=True)
        self.artifacts = folder / (name + "-found")
        self.artifacts.mkdir()
        self.scratch = folder / (name + "-tmp")
        self.scratch.mkdir()
        self.executions, self.seconds, self.coverage = 0, 0.0, 0
        self.findings, self.fenced = [], []
        self.process, self.stopped = None, False

    def run(self, arguments, plant=None):
        """Runs the binary; its exit code and all it said."""
        environment = {**os.environ, "TMPDIR": str(self.scratch), "UBSAN_OPTIONS": "print_stacktrace=1"}
        environment.pop("VCD_FUZZ_PLANT", None)
        if plant:
            environment["VCD_FUZZ_PLANT"] = plant
        # A unit that takes a minute has hung; 2 GiB are more than any sound input of these sizes may ask for.
        command = [str(self.binary), "-timeout=60", "-rss_limit_mb=3072", "-malloc_limit_mb=1024", "-print_final_stats=1",
                   f"-max_len={LARGEST[self.name]}", f"-artifact_prefix={self.artifacts}/", *arguments]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as self.process:
            said = self.process.communicate()[0]
        return self.process.returncode, said.decode(errors="replace")

    def take_artifact(self):
        """Moves what was found to the folder of findings; its new path, or None."""
        for file in sorted(self.artifacts.iterdir()):
            self.options.findings.mkdir(parents=True, exist_ok=True)
            kept = self.options.findings / f"{self.name}-{file.name}"
            shutil.move(file, kept)
            return kept
        return None

    def fuzz(self):
        end = time.monotonic() + self.options.seconds
        dictionary = HERE / "dictionaries" / (self.name + ".dict")
        while not self.stopped and (left := end - time.monotonic()) >= 1 and len(self.findings) < MOST_FINDINGS:
            arguments = [f"-max_total_time={int(left)}", "-use_value_profile=1", str(self.corpus), *map(str, seed_folders(self.name))]
            if dictionary.exists():
                arguments.insert(0, f"-dict={dictionary}")
            begin = time.monotonic()
            code, said = self.run(arguments)
            self.seconds += time.monotonic() - begin
            self.executions += int((re.findall(r"stat::number_of_executed_units: (\d+)", said) or [0])[-1])
            self.coverage = max([self.coverage, *map(int, re.findall(r" cov: (\d+)", said))])
            if code not in (0, INTERRUPTED):
                self.judge(said)

    def stop(self):
        self.stopped = True
        if self.process:
            self.process.terminate()

    def judge(self, said):
        """Sorts what libFuzzer stopped for into findings and what the child process fences."""
        kept = self.take_artifact()
        if kept is None:
            self.findings.append((None, "ended without an input: " + " ".join(said.split()[-40:])))
            return
        # Once more: what only took long while the machine was busy with something else is none.
        code, again = self.run([str(kept)])
        if code == 0 and "timeout" in kept.name:
            kept.unlink()
            return
        reason = reason_of(again if code else said)
        kept.with_name(kept.name + ".txt").write_text(again if code else said)
        if self.name in FENCED and is_in_library(again if code else said):
            bake = self.bake(kept)
            self.fenced.append(f"{reason}; vc-bake: {bake}")
            if bake.startswith("exit code"):
                print(f"{self.name}: fenced: {kept}: {self.fenced[-1]}", file=sys.stderr, flush=True)
                return
            reason += "; not fenced: " + bake
        self.findings.append((kept, reason + ("" if code else " (does not come again)")))
        print(f"{self.name}: FINDING: {kept}: {self.findings[-1][1]}", file=sys.stderr, flush=True)

    def bake(self, file):
        """What the program says to it: "exit code N: message" where that is a clear error."""
        named = self.scratch / ("finding." + self.name)
        shutil.copy(file, named)
        try:
            done = subprocess.run([self.options.bake, "--depth", "1", named, "-o", self.scratch / "finding.vcd"], capture_output=True, timeout=120)
        except (OSError, subprocess.TimeoutExpired) as error:
            return str(error)
        said = done.stderr.decode(errors="replace").strip()
        if done.returncode in (2, 3, 4, 5) and str(named) in said:
            return f"exit code {done.returncode}: " + said.splitlines()[-1].replace(str(named), "FILE")[:200]
        return f"ended with {done.returncode}: {said[-200:]}"

    def self_test(self):
        """Every bug that is planted behind the checks is seen, on the seeds alone; and without one they pass."""
        failures = []
        for plant, sign in (("property", "BROKEN PROMISE: planted"), ("memory", "AddressSanitizer: heap-buffer-overflow"),
                            ("undefined", "signed integer overflow"), (None, "")):
            arguments = seed_files(self.name)
            code, said = self.run(arguments, plant)
            noticed = code != 0 and sign in said
            if noticed != (plant is not None):
                failures.append(f"planted {plant}: exit code {code}: {' '.join(said.split()[-30:])}")
        for file in self.artifacts.iterdir():
            file.unlink()
        return failures


def reason_of(said):
    for pattern in (r"BROKEN PROMISE: .*", r".*runtime error: .*", r"SUMMARY: .*", r"==\d+== ERROR: .*"):
        if found := re.search(pattern, said):
            return re.sub(r"==\d+== ?", "", found.group(0))[:200]
    return " ".join(said.split()[-20:])


def is_in_library(said):
    """Whether the code that was running when it ended, or the code that called for memory, is the library's."""
    for frame in re.findall(r"^ +#\d+ 0x[0-9a-f]+ (.*)$", said, re.MULTILINE):
        if FENCED_LIBRARY in frame or "draco::" in frame:
            return True
        if "/baker/" in frame or "/fuzz/" in frame:
            return False
    return False


def print_table(targets):
    rows = [("target", "executions", "per second", "coverage", "findings", "fenced")]
    for t in targets:
        rows.append((t.name, f"{t.executions:,}", f"{t.executions / max(t.seconds, 1e-9):,.0f}", str(t.coverage),
                     str(len(t.findings)), str(len(t.fenced))))
    widths = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        print("  ".join(text.ljust(w) if i == 0 else text.rjust(w) for i, (text, w) in enumerate(zip(row, widths))))


def options_from(arguments):
    build = HERE.parent.parent / "build" / "asan"
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="of " + ", ".join(LARGEST) + "; default: all")
    parser.add_argument("--seconds", type=int, default=60, help="for each target (default 60)")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time (default 2)")
    parser.add_argument("--corpus", type=pathlib.Path, help="folder to start from, one folder a target in it, and to add to")
    parser.add_argument("--findings", type=pathlib.Path, default=pathlib.Path("findings"), help="folder for inputs that broke something (default findings)")
    parser.add_argument("--bin", type=pathlib.Path, default=build / "tests" / "fuzz", help="folder of the built targets")
    parser.add_argument("--bake", type=pathlib.Path, default=build / "bin" / "vc-bake", help="the program that fences libdraco")
    parser.add_argument("--self-test", action="store_true", help="first, plant a bug of each kind in each target: each must be noticed; "
                        "with --seconds 0 that is all")
    options = parser.parse_args(arguments)
    options.targets = options.targets or list(LARGEST)
    for name in options.targets:
        if name not in LARGEST:
            parser.error(f"no target {name}; there are {', '.join(LARGEST)}")
        if not (options.bin / ("fuzz_" + name)).exists():
            parser.error(f"{options.bin}/fuzz_{name} is not built: cmake --preset asan && cmake --build --preset asan --target fuzzers")
    options.bake = options.bake.resolve()
    return options


def main():
    options = options_from(sys.argv[1:])
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # what targets write, they write without a disk
    with tempfile.TemporaryDirectory(prefix="vcd-fuzz-", dir=memory) as folder, \
            concurrent.futures.ThreadPoolExecutor(options.jobs) as pool, contextlib.suppress(BrokenPipeError):
        targets = [Target(name, options, pathlib.Path(folder)) for name in options.targets]
        for number in (signal.SIGTERM, signal.SIGINT):  # ends early, with a table
            signal.signal(number, lambda *_: [target.stop() for target in targets])
        if options.self_test:
            failed = False
            for target, failures in zip(targets, pool.map(Target.self_test, targets)):
                for failure in failures:
                    print(f"{target.name}: self-test: {failure}", file=sys.stderr)
                    failed = True
            if failed:
                return 2
            print(f"self-test: bugs planted in {len(targets)} targets were noticed")
        if options.seconds > 0:
            list(pool.map(Target.fuzz, targets))
            print_table(targets)
    return 1 if any(t.findings for t in targets) else 0


if __name__ == "__main__":
    sys.exit(main())
