"""Not a test: nanoseconds a segment of arrays from Python, beside C++, and in two threads.

    array_times.py BUILD SIDECAR [COUNT]        # BUILD: as of preset release
"""
import concurrent.futures
import subprocess
import sys
import tempfile
import time


def least_nanoseconds(call, count):
    times = []
    for _ in range(5):
        begun = time.perf_counter()
        call()
        times.append(time.perf_counter() - begun)
    return min(times) / count * 1e9


def main(build, path, count=10_000_000):
    sys.path.insert(0, build + "/python")
    import numpy
    import vcd
    count = int(count)
    begun = time.perf_counter()
    tree = vcd.open(path)[0]
    print(f"{tree.name}: opened in {1e3 * (time.perf_counter() - begun):.1f} ms; {count:,} segments, nanoseconds each")
    random = numpy.random.default_rng(0)
    low, high = numpy.array(tree.record.box_min), numpy.array(tree.record.box_max)
    ends = random.uniform(low - (high - low), high + (high - low), (2, count, 3)).astype(numpy.float32)
    segments = vcd.segments(ends[0], ends[1] - ends[0])
    del ends
    python = [least_nanoseconds(lambda: ask(segments), count) for ask in (tree.classify, tree.occluded)]
    with tempfile.NamedTemporaryFile() as file:
        segments.tofile(file.name)
        cpp = [float(word) for word in subprocess.check_output(
            [build + "/tests/array_times", path, file.name], text=True).split()]
    halves = numpy.array_split(segments, 2)
    with concurrent.futures.ThreadPoolExecutor(2) as threads:
        both = [least_nanoseconds(lambda: list(threads.map(ask, halves)), count)
                for ask in (tree.classify, tree.occluded)]
    for name, c, p, two in zip(("classify", "occluded"), cpp, python, both):
        print(f"{name}: C++ {c:.2f}, Python {p:.2f} ({p / c:.2f} times), two threads {two:.2f} ({p / two:.2f} times the rate)")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
