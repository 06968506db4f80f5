"""Demands as users meet them. The files here are written from spec/demand.md alone."""
import pathlib
import struct
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "spec" / "reader"), str(ROOT / "tests" / "programs")]

from test_programs import Case, json
from xxh3 import xxh3_64

HASHES = [bytes([number] * 16) for number in (3, 7)]


def demand_bytes(objects, version=(1, 0)):
    """objects: geometry hash → list of (origin, t_min, direction, t_max, weight)."""
    table, segments = b"", b""
    for geometry_hash, asked in sorted(objects.items()):
        packed = [struct.pack("<8fd", *origin, t_min, *direction, t_max, weight)
                  for origin, t_min, direction, t_max, weight in asked]
        own = b"".join(sorted(packed, key=lambda s: struct.unpack("<8I", s[:32])))
        table += geometry_hash + struct.pack("<QQ", len(asked), xxh3_64(own))
        segments += own
    header = b"\x89VCA\r\n\x1a\n" + struct.pack("<HHIQQ24x", *version, len(objects), 64 + len(table) + len(segments), xxh3_64(table))
    return header + struct.pack("<Q", xxh3_64(header)) + table + segments


def segment(number, weight=1):
    return ((number, 0.5, -1), 0, (0, 0.25, 2), float("inf"), weight)


class Demands(Case):
    def demand(self, name, objects, **options):
        path = self.folder / name
        path.write_bytes(demand_bytes(objects, **options))
        return path

    def shown(self, path):
        found, = json.loads(self.run_program("vc-info", path, "--format", "json").stdout)["files"]
        return {entry["geometry_hash"]: (entry["segments"], entry["weight"]) for entry in found["demand"]}

    def test_are_shown_merged_and_thinned(self):
        a = self.demand("a.demand", {HASHES[0]: [segment(1), segment(-2, 3)], HASHES[1]: [segment(0)]})
        b = self.demand("b.demand", {HASHES[0]: [segment(1, 4), segment(5)]})
        self.assertIn("2 segments that stand for 4", self.run_program("vc-info", a).stdout)
        self.assertEqual(self.shown(a), {HASHES[0].hex(): (2, 4), HASHES[1].hex(): (1, 1)})
        self.run_program("vc-info", a, b, "--merge", self.folder / "ab.demand")
        self.run_program("vc-info", b, a, "--merge", self.folder / "ba.demand")
        self.assertEqual(self.shown(self.folder / "ab.demand"), {HASHES[0].hex(): (3, 9), HASHES[1].hex(): (1, 1)})
        merged = (self.folder / "ab.demand").read_bytes()
        self.assertEqual(merged, (self.folder / "ba.demand").read_bytes())
        self.assertEqual(merged, demand_bytes({HASHES[0]: [segment(1, 5), segment(-2, 3), segment(5)], HASHES[1]: [segment(0)]}))
        thinned = self.folder / "thinned.demand"
        self.run_program("vc-info", a, b, "--merge", thinned, "--most-segments", 2, "-q")
        self.assertEqual(sum(count for count, _ in self.shown(thinned).values()), 2)

    def test_that_are_none_or_damaged_say_so_and_leave_nothing(self):
        good = self.demand("good.demand", {HASHES[0]: [segment(1)]})
        damaged = self.folder / "damaged.demand"
        damaged.write_bytes(good.read_bytes()[:-1])
        later = self.demand("later.demand", {HASHES[0]: [segment(1)]}, version=(2, 0))
        before = self.files()
        for path, code, message in ((damaged, 3, "by its header"), (later, 5, "version 1"), (self.mesh(), 3, "not a demand"), (self.folder / "absent", 2, "absent")):
            done = self.run_program("vc-info", good, path, "--merge", self.folder / "out.demand", code=code)
            self.assertIn(message, done.stderr)
        self.assertIn("by its header", self.run_program("vc-info", damaged, code=3).stderr)
        self.run_program("vc-info", good, "--merge", self.folder / "out.vcd", code=1)
        self.run_program("vc-info", good, "--merge", self.folder / "tetrahedron.obj", code=1)
        self.assertEqual(self.files(), sorted(before + ["tetrahedron.obj"]))


del Case  # it has no tests of its own

if __name__ == "__main__":
    unittest.main()
