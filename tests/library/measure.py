#!/usr/bin/env python3
"""Measures runs of vc-bake over a library: how busy it keeps the processors, and how much memory the whole process tree takes.

    measure.py throughput --bin BUILD/bin --assets 150 -- --depth 4 --audit 100000     against the same bakes by hand, longest first
    measure.py memory --bin BUILD/bin --budget-mb 4096 -- LIBRARY --depth 3            peak of the sum of all processes' own memory"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import make_library


def throughput(options, more):
    bake = pathlib.Path(options.bin) / "vc-bake"
    folder = pathlib.Path(tempfile.mkdtemp(prefix="vcd-throughput-"))
    try:
        make_library.make(folder / "library", options.assets)
        seconds, ratios = {}, []

        def one(path, number):
            subprocess.run([bake, path, "-o", folder / "hand" / f"{number}.vcd", "-q", "-j", "1", *more], stderr=subprocess.DEVNULL)

        for r in range(options.rounds):
            for name in ("batch", "hand"):
                shutil.rmtree(folder / name, ignore_errors=True)
                (folder / name).mkdir()
            start = time.monotonic()
            out = subprocess.run([bake, folder / "library", "-o", folder / "batch", "-j", str(options.jobs), "--format", "json", *more],
                                 capture_output=True).stdout
            batch = time.monotonic() - start
            for f in json.loads(out)["files"]:
                if isinstance(f["input"], str):
                    seconds.setdefault(f["input"], f["seconds"])
            order = sorted(seconds, key=seconds.get, reverse=True)
            start = time.monotonic()
            with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
                list(pool.map(one, order, range(len(order))))
            hand = time.monotonic() - start
            ratios.append(hand / batch)
            print(f"round {r + 1}: batch {batch:.2f} s, by hand in the best order {hand:.2f} s, throughput {100 * hand / batch:.0f} %", flush=True)
        print(f"median throughput of the batch: {100 * statistics.median(ratios):.0f} % of the bakes by hand")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def own_memory(pid):
    """Proportional set size in bytes of a process and all below it."""
    total, waiting = 0, [pid]
    while waiting:
        p = waiting.pop()
        try:
            for line in open(f"/proc/{p}/smaps_rollup"):
                if line.startswith("Pss:"):
                    total += int(line.split()[1]) * 1024
            waiting += [int(c) for t in os.listdir(f"/proc/{p}/task") for c in open(f"/proc/{p}/task/{t}/children").read().split()]
        except OSError:
            pass
    return total


def memory(options, more):
    with tempfile.TemporaryDirectory() as out:
        process = subprocess.Popen([pathlib.Path(options.bin) / "vc-bake", "-o", out, "--memory-mb", str(options.budget_mb), "-j", str(options.jobs),
                                    "--report", f"{out}/report", "-q", *more], stderr=subprocess.DEVNULL)
        peak = 0
        while process.poll() is None:
            peak = max(peak, own_memory(process.pid))
            time.sleep(0.02)
        report = json.load(open(f"{out}/report.json"))
        print(f"budget {options.budget_mb} MiB, peak {peak / 2 ** 20:.0f} MiB of the whole tree; {report['totals']}, {report['seconds']:.0f} s")
        again = [f for f in report["files"] if f.get("attempts", 0) > 1]
        for f in sorted(report["files"], key=lambda f: -f.get("peak_memory_bytes", 0))[:5] + again[:5]:
            print(f"  {f['input']}: {f['fate']}, {f.get('peak_memory_bytes', 0) / 2 ** 20:.0f} MiB, {f.get('attempts')} attempts, {f.get('error', '')}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("throughput", "memory"))
    parser.add_argument("--bin", required=True)
    parser.add_argument("--assets", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--budget-mb", type=int, default=4096)
    own = sys.argv[1:sys.argv.index("--")] if "--" in sys.argv else sys.argv[1:]
    more = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    options = parser.parse_args(own)
    print("command:", " ".join(sys.argv))
    {"throughput": throughput, "memory": memory}[options.what](options, more)


if __name__ == "__main__":
    main()
