"""The C++ and the Python reader, written apart from one specification, must say the same of every golden file."""
import json
import os
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve()
sys.path.insert(0, str(HERE.parents[2] / "spec" / "reader"))
import vcd_reader

SPECIFICATION = HERE.parents[2] / "spec" / "vcd-format.md"
GOLDEN = HERE.parents[1] / "golden"
BIN = pathlib.Path(os.environ["VCD_BIN"])
TEST_BIN = pathlib.Path(os.environ["VCD_TEST_BIN"])
SEGMENTS = 100_000


def segments_for(box_min, box_max, seed):
    """Piercing lines, ends inside, misses, axis-parallel and odd ones, in the box's frame."""
    rng = random.Random(seed)
    out = bytearray()
    specials = [0.0, -0.0, 1e-40, float("inf"), float("nan"), 1e30, -1e-30]
    extent = [b - a for a, b in zip(box_min, box_max)]
    for i in range(SEGMENTS):
        a = [lo + e * rng.uniform(-1, 2) for lo, e in zip(box_min, extent)]
        b = [lo + e * rng.uniform(0, 1) for lo, e in zip(box_min, extent)]
        d = [2 * (y - x) for x, y in zip(a, b)]
        t_min, t_max = 0.0, rng.choice([1.0, 1.0, 1.0, 0.5, 100.0, float("inf")])
        if i % 8 == 0:
            d[rng.randrange(3)] = rng.choice([0.0, -0.0])
        if i % 50 == 0:
            rng.choice([a, d])[rng.randrange(3)] = rng.choice(specials)
        if i % 3 == 0:  # begins or ends shortly behind a face
            axis, depth = rng.randrange(3), rng.choice([0.001, 0.01, 0.1])
            a[axis] = box_min[axis] + extent[axis] * rng.choice([depth, 1 - depth])
            d = [2 * (y - x) for x, y in zip(a, b)]
            if i % 2 == 0:
                a, d = [x + y for x, y in zip(a, d)], [-x for x in d]
        if i % 97 == 0:
            t_min = rng.choice([float("nan"), -5.0, 0.3])
        out += struct.pack("<8f", *a, t_min, *d, t_max)
    return bytes(out)


class Agreement(unittest.TestCase):
    def golden(self):
        files = sorted(GOLDEN.glob("*.vcd"))
        self.assertGreaterEqual(len(files), 12)
        return files

    def run_program(self, *arguments):
        return subprocess.run([str(a) for a in arguments], capture_output=True, text=True)

    def test_both_show_the_same_content(self):
        for path in self.golden():
            with self.subTest(path.name):
                cpp = json.loads(self.run_program(BIN / "vc-info", path, "--format", "json").stdout)["files"][0]
                dump = self.run_program(sys.executable, HERE.parents[2] / "spec/reader/vcd_reader.py", "dump", path)
                python = json.loads(dump.stdout)
                self.assertEqual(cpp["format_version"], python["version"])
                self.assertEqual(cpp["provenance"], python["provenance"])
                for a, b in zip(cpp["sections"], python["sections"], strict=True):
                    self.assertEqual(None if b["object"] == 0xFFFFFFFF else b["object"], a["object"])
                    for key in ("type", "offset", "stored_size", "logical_size", "stored_xxh3", "logical_xxh3"):
                        self.assertEqual(a[key], b[key], key)
                for a, b in zip(cpp["objects"], python["objects"], strict=True):
                    for key in ("name", "source_index", "depth", "geometry_hash", "triangle_count", "vertex_count",
                                "parts_left_out", "shift"):
                        self.assertEqual(a[key], b[key], key)
                    self.assertEqual(list(a["cells"].values()), b["cells"] + [b["statistical_cells"]])
                    self.assertAlmostEqual(a["guard_band"], b["guard_band"], 6)
                    shown = a["hierarchy"] and {key: a["hierarchy"][key] for key in ("bytes", "nodes", "leaves", "levels")}
                    self.assertEqual(shown, b["hierarchy"])
                    audit = a["audit"] or {"lines": 0, "wrong": 0, "aimed_lines": 0, "aimed_wrong": 0}
                    self.assertEqual([audit["lines"], audit["aimed_lines"]], b["audit_lines"])
                    self.assertEqual([audit["wrong"], audit["aimed_wrong"]], b["audit_wrong"])
                    self.assertEqual(list(a["nodes"].values()),
                                     [b["nodes_unfolded"], b["nodes_folded"], b["nodes_shared"]])
                    for key in ("box_min", "box_max"):  # the C++ prints the shortest decimal of the f32
                        self.assertEqual([struct.unpack("f", struct.pack("f", x))[0] for x in a[key]], b[key])

    def test_both_classify_alike(self):
        for path in self.golden():
            file = vcd_reader.VcdFile(path.read_bytes())
            for index, record in enumerate(file.objects):
                with self.subTest(f"{path.name} object {index}"), tempfile.TemporaryDirectory() as folder:
                    folder = pathlib.Path(folder)
                    (folder / "segments").write_bytes(segments_for(record.box_min, record.box_max, index))
                    done = self.run_program(TEST_BIN / "classify_file", path, index, folder / "segments", folder / "cpp")
                    self.assertEqual(done.returncode, 0, done.stderr)
                    vcd_reader.main(["classify", str(path), str(index), str(folder / "segments"), str(folder / "py")])
                    cpp, python = (folder / "cpp").read_bytes(), (folder / "py").read_bytes()
                    self.assertEqual(len(cpp), SEGMENTS)
                    for i, (a, b) in enumerate(zip(cpp, python)):
                        self.assertEqual(a, b, f"segment {i}")
                    if record.method:
                        self.assertGreater(min(cpp.count(c) for c in (0, 2)), 1000)
                    else:
                        self.assertEqual(cpp.count(2), SEGMENTS)

    def test_the_worked_example_is_the_file(self):
        data = (GOLDEN / "example.vcd").read_bytes()
        rows = re.findall(r"^([0-9a-f]{8}): (.{1,40})", SPECIFICATION.read_text(), re.M)
        self.assertGreater(len(rows), 30)
        for offset, text in rows:
            expected = bytes.fromhex(text.replace(" ", ""))
            self.assertEqual(data[int(offset, 16):][:len(expected)], expected, offset)
        file = vcd_reader.VcdFile(data)
        for origin, answer in (((0.2, 0.2, -2.0), 1), ((0.8, 0.8, -2.0), 0)):
            origin = struct.unpack("3f", struct.pack("3f", *origin))
            self.assertEqual(vcd_reader.classify(file.objects[0], file.tree(0), origin, 0.0, (0.0, 0.0, 4.0), 1.0), answer)

    def test_both_refuse_every_invalid_golden_file(self):
        files = sorted((GOLDEN / "invalid").glob("*.vcd"))
        self.assertGreater(len(files), 30)
        for path in files:
            with self.subTest(path.name):
                cpp = self.run_program(BIN / "vc-verify", path)
                self.assertIn(cpp.returncode, (3, 5), cpp.stdout)
                self.assertIn(path.stem, cpp.stderr)  # the file is named after its finding
                python = self.run_program(sys.executable, HERE.parents[2] / "spec/reader/vcd_reader.py", "dump", path)
                self.assertEqual(python.returncode, 3, python.stdout[:200])


if __name__ == "__main__":
    unittest.main()
