"""Tests of vcd_reader.py. Files come from a mini-writer in this module, which knows the format from vcd-format.md too,
but works from nested trees: a node is a class (0, 1, 2) or a tuple of its sixteen children."""
import contextlib
import hashlib
import io
import itertools
import json
import math
import os
import random
import struct
import subprocess
import tempfile
import unittest
from fractions import Fraction
from functools import lru_cache

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "spec" / "reader"))
import vcd_reader
from vcd_reader import VcdError, VcdFile, classify
from xxh3 import xxh3_64, xxh3_128

NONE = 0xFFFFFFFF
INF, NAN = math.inf, math.nan


# ---- mini-writer -----------------------------------------------------------------------------------------------------

class Node(tuple):
    """Sixteen children. There is one object for equal children, so that nodes compare and hash by identity."""
    __hash__ = object.__hash__
    __eq__ = object.__eq__
    known = {}

    @classmethod
    def of(cls, children):
        children = tuple(children)
        return cls.known.setdefault(children, cls(children))


def random_roots(depth, seed, palette=5):
    """Fifteen face pairs of a tree of the given depth, with shared and unshared nodes, leaves at every level."""
    rng = random.Random(seed)
    nodes = [0, 1, 2]
    for _ in range(depth):
        fresh = [Node.of(rng.choices(nodes, k=16)) for _ in range(palette)]
        fresh.append(Node.of((nodes[-1],) + (0,) * 15))
        nodes = [0, 1, 2] + [node for node in fresh if len(set(node)) > 1]
    return [rng.choice(nodes[3:]) for _ in range(13)] + [rng.choice(nodes), 1]


def descend(node, bits, s, t, u, v):
    """The node `bits` levels below; the coordinates have `bits` bits."""
    for b in reversed(range(bits)):
        if isinstance(node, tuple):
            node = node[(s >> b & 1) * 8 + (t >> b & 1) * 4 + (u >> b & 1) * 2 + (v >> b & 1)]
    return node


@lru_cache(None)
def expand(node, bits):
    return tuple(descend(node, bits, *c) for c in itertools.product(range(2 ** bits), repeat=4))


def brick_bytes(node):
    return bytes(a | b << 2 | c << 4 | d << 6 for a, b, c, d in zip(*[iter(expand(node, 2))] * 4))


def write_tree(roots, levels):
    """(bytes, counts of the blocks of three levels, and of bricks)"""
    top = min(levels - 2, 3)
    layers = [top, *[1] * (levels - 2 - top), 2]
    tables = [{0: 0, 1: 1, 2: 2} for _ in layers[1:]]          # node -> index, in order

    def number(table, node):
        return table.setdefault(node, len(table))

    out = b"".join(struct.pack("<I", number(tables[0], n)) for root in roots for n in expand(root, layers[0]))
    out += bytes(4)
    out += bytes(-len(out) % 64)
    for here, below, bits in zip(tables, tables[1:], layers[1:]):
        out += b"".join(struct.pack("<I", number(below, n)) for node in here for n in expand(node, bits))
    out += b"".join(map(brick_bytes, tables[-1]))
    blocks = [len(table) for table in tables[:-1]]
    return out, [*blocks, *[0] * (3 - len(blocks)), len(tables[-1])]


def naive_counts(roots, levels):
    """cells, nodes_unfolded, nodes_folded, nodes_shared by recursion over the nested tuples, and a set of groups."""
    groups = set()

    @lru_cache(None)
    def visit(node, level):
        if not isinstance(node, tuple):
            return tuple(16 ** (levels - level) * (node == c) for c in range(3)) + (1, 1)
        below = [visit(child, level + 1) for child in node]
        folds = not any(isinstance(child, tuple) for child in node)
        if not folds:
            groups.add((level, node))
        return tuple(sum(b[i] for b in below) for i in range(3)) + (
            1 + sum(b[3] for b in below), 1 if folds else 1 + sum(b[4] for b in below))

    sums = [sum(column) for column in zip(*(visit(root, 0) for root in roots))]
    return sums[:3], sums[3], sums[4], 15 + 16 * len(groups)


def zstd(data, *options):
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        return subprocess.run(["zstd", "-cq", *options, file.name], capture_output=True, check=True).stdout


class Entry:
    """A section to be written."""

    def __init__(self, kind, logical, object=NONE, storage=0, alignment=8, flags=None, stored=None):
        self.kind, self.logical, self.object, self.storage, self.alignment = kind, logical, object, storage, alignment
        self.flags = int(kind in (b"OBJT", b"NAME", b"TREE")) if flags is None else flags
        self.stored = stored if stored is not None else zstd(logical) if storage else logical


class Object:
    def __init__(self, depth, seed=1, name="", storage=0, roots=None, box=((-1.0, 0.0, 2.0), (1.0, 4.0, 3.0)), geom=None):
        self.depth, self.name, self.storage, self.box, self.geom = depth, name.encode(), storage, box, geom
        self.levels = max(depth, 2)
        self.roots = random_roots(depth, seed) if roots is None else roots
        self.tree, self.pools = write_tree(self.roots, self.levels)
        self.counts = naive_counts(self.roots, self.levels)

    def cell(self, pair, s, t, u, v):
        return descend(self.roots[pair], 8, s, t, u, v)


def entries(objects, provenance=((b"a", b"1"), (b"b", b"\xc3\xa9")), extra=()):
    records, names, position = b"", b"", 3 if provenance is not None else 2
    owned = []
    for i, o in enumerate(objects):
        tree, geometry = position + len(owned), NONE
        owned.append(Entry(b"TREE", o.tree, i, o.storage, 8 if o.storage else 4096))
        if o.geom is not None:
            geometry = position + len(owned)
            owned.append(Entry(b"GEOM", o.geom, i))
        cells, *nodes = o.counts
        records += struct.pack("<IIIBB2x6f16s2Q3QII4I8x3Q8I72x", len(names), len(o.name), 7, o.depth, 1, *o.box[0],
                               *o.box[1], bytes(range(16)), 12, 8, *cells, tree, geometry, *o.pools, *nodes,
                               16, 5, 6, 0, 0, 0, 0, 0)
        names += o.name
    result = [Entry(b"OBJT", records), Entry(b"NAME", names)]
    if provenance is not None:
        pairs = b"".join(struct.pack("<II", len(k), len(v)) + k + v for k, v in provenance)
        result.append(Entry(b"PROV", struct.pack("<I", len(provenance)) + pairs))
    return result + owned + list(extra)


def assemble(sections, minor=0):
    end, table, body = 64 + 64 * len(sections), b"", b""
    for s in sections:
        padding = -end % s.alignment
        offset, end = end + padding, end + padding + len(s.stored)
        body += bytes(padding) + s.stored
        table += struct.pack("<4sIIIQQQQQII", s.kind, s.flags, s.object, s.storage, offset, len(s.stored),
                             len(s.logical), xxh3_64(s.stored), xxh3_64(s.logical), s.alignment, 0)
    header = struct.pack("<8sHHIQQ24x", b"\x89VCD\r\n\x1a\n", 1, minor, len(sections), end, xxh3_64(table))
    return header + struct.pack("<Q", xxh3_64(header)) + table + body


def patched(data, *patches, contents=True, table=True, header=True):
    """Bytes replaced, and all checksums that lie above the change made right again."""
    data = bytearray(data)
    for at, new in patches:
        data[at:at + len(new)] = new
    count = struct.unpack_from("<I", data, 12)[0]
    if contents:
        for at in range(64, 64 + 64 * count, 64):
            storage, offset, size = struct.unpack_from("<IQQ", data, at + 12)
            if storage == 0:
                struct.pack_into("<QQ", data, at + 40, *[xxh3_64(bytes(data[offset:offset + size]))] * 2)
    if table:
        struct.pack_into("<Q", data, 24, xxh3_64(bytes(data[64:64 + 64 * count])))
    if header:
        struct.pack_into("<Q", data, 56, xxh3_64(bytes(data[:56])))
    return bytes(data)


def u32(x):
    return struct.pack("<I", x)


def u64(x):
    return struct.pack("<Q", x)


# ---- an exact binary32 made of fractions -----------------------------------------------------------------------------

def round32(x):
    """A fraction rounded to nearest, ties to even; infinite beyond the range."""
    if x == 0:
        return x
    exponent = abs(x).numerator.bit_length() - abs(x).denominator.bit_length()
    exponent -= abs(x) < Fraction(2) ** exponent
    unit = Fraction(2) ** (max(exponent, -126) - 23)
    result = round(x / unit) * unit
    return result if abs(result) < Fraction(2) ** 128 else None


def exact_line(box, origin, direction):
    """*Line to cell* with fractions: None if not valid, (t_entry, t_exit, cell or None) otherwise. Needs finite input."""
    negative = [math.copysign(1, d) < 0 for d in direction]
    low_corner, high_corner = [[Fraction(x) for x in corner] for corner in box]
    scale = [round32(256 / round32(h - l)) for h, l in zip(high_corner, low_corner)]
    steps = [round32(Fraction(o) - l) for o, l in zip(origin, low_corner)]
    if None in steps:
        return None
    p = [round32(x * k) for x, k in zip(steps, scale)]
    q = [round32(Fraction(d) * k) for d, k in zip(direction, scale)]
    if None in p + q:
        return None
    sums = []
    for a in (p, q):
        partial = round32(abs(a[0]) + abs(a[1]))
        sums.append(None if partial is None else round32(partial + abs(a[2])))
    if None in sums or sums[0] > 2 ** 17 or not Fraction(1, 2 ** 40) <= sums[1] <= 2 ** 100:
        return None
    q = [max(abs(x), Fraction(1, 2 ** 100)) * (-1 if n else 1) for x, n in zip(q, negative)]
    r = [round32(1 / x) for x in q]
    one = [round32(round32(-x) * k) for x, k in zip(p, r)]
    two = [round32(round32(256 - x) * k) for x, k in zip(p, r)]
    near, far = list(map(min, one, two)), list(map(max, one, two))
    t_entry, t_exit = max(near), min(far)
    if t_entry >= t_exit:
        return t_entry, t_exit, None
    a, b = near.index(t_entry), far.index(t_exit)
    faces = {2 * a + negative[a]: t_entry, 2 * b + 1 - negative[b]: t_exit}
    cell = [list(itertools.combinations(range(6), 2)).index(tuple(sorted(faces)))]
    for face in sorted(faces):
        for axis in range(3):
            if axis != face // 2:
                x = round32(round32(q[axis] * faces[face]) + p[axis])
                cell.append(math.floor(min(max(x, 0), 255)))
    return t_entry, t_exit, tuple(cell)


def expected_answer(o, origin, t_min, direction, t_max):
    if not all(map(math.isfinite, (*origin, *direction))):
        return 2
    line = exact_line(o.box, origin, direction)
    if line is None:
        return 2
    t_entry, t_exit, cell = line
    if cell is None or t_min >= t_exit or t_max <= t_entry:
        return 0
    found = o.cell(*cell)
    return 0 if found == 0 else 1 if found == 1 and t_min <= t_entry and t_max >= t_exit else 2


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def random_segment(rng, box):
    low, high = box
    centre = [(l + h) / 2 for l, h in zip(low, high)]
    size = [h - l for l, h in zip(low, high)]
    kind = rng.randrange(8)
    origin = [c + k * rng.uniform(-2, 2) for c, k in zip(centre, size)]
    target = [c + k * rng.uniform(-.55, .55) for c, k in zip(centre, size)]
    direction = [t - o for t, o in zip(target, origin)]
    if kind == 1:                                                       # axis-parallel, zeros of both signs
        for a in rng.sample(range(3), 2):
            direction[a] = rng.choice([0.0, -0.0, 1e-40, -1e-45, 1e-30, -1e-36])
    elif kind == 2:                                                     # through corners and edges
        origin = [rng.choice([l - k, l, h, h + k, c]) for l, h, k, c in zip(low, high, size, centre)]
        direction = [k * rng.choice([1, -1, .5, 0.0, -0.0, 2]) for k in size]
    elif kind == 3:                                                     # all lengths
        factor = 2.0 ** rng.uniform(-45, 101)
        direction = [d * factor if abs(d * factor) < 3e38 else 3e38 for d in direction]
    elif kind == 4:                                                     # all distances
        factor = 2.0 ** rng.uniform(0, 12)
        origin = [t - d * factor for t, d in zip(target, direction)]
    elif kind == 5 and rng.random() < .5:
        (origin if rng.random() < .5 else direction)[rng.randrange(3)] = rng.choice([INF, -INF, NAN, 3e38, -3e38])
    t_min = rng.choice([-INF, 0.0, 0.0, -1.0, rng.uniform(-1, 2), NAN])
    t_max = rng.choice([INF, INF, 1.0, 3.0, rng.uniform(-1, 2), NAN])
    return [single(x) for x in origin], single(t_min), [single(x) for x in direction], single(t_max)


# ---- tests -----------------------------------------------------------------------------------------------------------

class Hashes(unittest.TestCase):
    """Known values from xxhsum 0.8.1 -H3 and -H2, of the first n bytes of 0, 1, ... 255, 0, 1, ..."""
    KNOWN = {
        0: (0x2d06800538d394c2, 0x99aa06d3014798d86001c324468d497f),
        1: (0xc44bdff4074eecdb, 0xa6cd5e9392000f6ac44bdff4074eecdb),
        2: (0xd6645fc3051a9457, 0x6a4a5274c1b0d3add6645fc3051a9457),
        3: (0x5f4299fc161c9cbb, 0xe3b55f57945a17cf5f4299fc161c9cbb),
        4: (0x60dab036a58211f2, 0xeb70bf5fc779e9e6a6111d53e80a3db5),
        5: (0xb075753a84ca0fbe, 0x9434532106a7c141c920d2347a85929b),
        7: (0x0cd2084a62406b69, 0x61ce291bc3a4357ddbb207821e6d5efe),
        8: (0x3a1c2d7c85af88f8, 0xe1e4432a62217fe4cfd50c61c8bb98c1),
        9: (0xe9612598145bb9dc, 0x16c769d83e4aebce907931979dca3746),
        12: (0x5ace6a511c10894b, 0x38f92247a7f73cc57780eb31198f13ca),
        15: (0x55ecedc2b87bb042, 0x301a9f754e8f569a0017ea4be19bc787),
        16: (0x8355e3a6f61770db, 0x72950631827607e2842812cc870dcae2),
        17: (0x9ef341a99de37328, 0x685bc458b37d057fc06e233df7729217),
        31: (0x4f36db8e4df378fd, 0x4ed3946d393b687bb54de3993874ed20),
        32: (0x3523581fe96e4c05, 0x25e7c9b3424ceed2457d9566b6fcd697),
        33: (0xe68c56ba88991e58, 0x02175c3aabb00637e08d84951339de86),
        64: (0x6187eb9089b0ed55, 0x9c6e140a465545e590c1971ddb04ce74),
        65: (0x6928c76ce90422d0, 0xebedf05eeadc28f11aee64a1615de88f),
        96: (0x278a3e12ea046dfb, 0xc57556e9ccb97efa6e53ab55b4f5558b),
        97: (0xe7220282dc4e14f4, 0x9b09227e063da5a25b3284a61f91e97d),
        127: (0x120b9787f8425f2f, 0xd5add870c9c9e00f060c2e3ddf0f2fb9),
        128: (0x85c6174c7ff4c46b, 0x14792fc3af88dc6c05321a0b64d67b41),
        129: (0xec7642b431ba3e5a, 0xdd5e74ac6b45f54ebc30b63382b09a3b),
        159: (0x03ff9a757547fbc8, 0xe34482de7831e5f6aea9455053a8845b),
        160: (0x5bea9075ec9401b8, 0x4e95c1cd6dc7bb85c67fcd13c31b09f4),
        191: (0x9b49b643c8fc32d5, 0xf8a8b7d9aad39ee4b224afe71ffd14d8),
        192: (0x981eb7df4a4911d7, 0x10c987dc285c756b050f429c4f52b688),
        223: (0x49c23dc521f5e4bd, 0x1634d1625a498f461357556c8fbf7594),
        224: (0xd12a5973497df13c, 0x21787738bcf2a96cb0e6e8978fa2bfb4),
        239: (0x972b14e3c46f214b, 0x9843ab31a06be0dffe21374628fcc539),
        240: (0x375a384d957fe865, 0x65b5be86da5540e7c92b68e16f83bbb6),
        241: (0x02e8cd95421c6d02, 0x1da1cb61bcb8a2a102e8cd95421c6d02),
        255: (0xb85fd37a0a050e63, 0x5914868aa80541d9b85fd37a0a050e63),
        256: (0x9408a4433b952d71, 0xf1f8a93f50849ac39408a4433b952d71),
        257: (0xd02c25704c5cee8a, 0xfd99e4992437cdf2d02c25704c5cee8a),
        511: (0x5a59555ecf4e4b4c, 0x095ddb455648e3fa5a59555ecf4e4b4c),
        512: (0x1059105ad19bfa09, 0x111d5771df64cbcb1059105ad19bfa09),
        1024: (0xa870f92984398d22, 0x83885e853bb6640ca870f92984398d22),
        1025: (0x78c86e91ee939852, 0xe1e508f110763b4678c86e91ee939852),
        1087: (0x1005d1f576f1fa5d, 0xac1ee4283117d7d61005d1f576f1fa5d),
        1088: (0x280d4e7cb6579eb6, 0x03ecd3dcac9049e9280d4e7cb6579eb6),
        1089: (0x42f8401c93f322b4, 0xcf5af7c44728c2d842f8401c93f322b4),
        2048: (0xdd420471ff96bd00, 0xdf73e0768dd183fadd420471ff96bd00),
        2049: (0x62dff343e7dbac9b, 0x95f65d47a8aa231662dff343e7dbac9b),
        5000: (0x1b74bda2c82a8c7a, 0x7a681524919c28221b74bda2c82a8c7a),
    }

    def test_known_values(self):
        data = bytes(range(256)) * 20
        for n, (short, long) in self.KNOWN.items():
            with self.subTest(n=n):
                self.assertEqual(xxh3_64(data[:n]), short)
                self.assertEqual(xxh3_128(data[:n]), long)

    def test_geometry_hash_is_most_significant_byte_first(self):
        triangle = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]
        data = struct.pack("<QQ9f3I", 3, 1, *itertools.chain(*triangle), 0, 1, 2)
        self.assertEqual(int.from_bytes(vcd_reader.geometry_hash(triangle, [(0, 1, 2)]), "big"), xxh3_128(data))


class Binary32(unittest.TestCase):
    def test_double_rounding_is_innocuous(self):
        rng = random.Random(2)
        for _ in range(20000):
            a, b = (struct.unpack("<f", u32(rng.getrandbits(32)))[0] for _ in range(2))
            if rng.random() < .5:                                       # provoke cancellation and subnormal results
                b = single(a * rng.choice([1, -1, 1.0000001, 0.5]) if abs(a) < 1e38 else 1.0)
            if not (math.isfinite(a) and math.isfinite(b)):
                continue
            for x, y in ((a + b, Fraction(a) + Fraction(b)), (a - b, Fraction(a) - Fraction(b)),
                         (a * b, Fraction(a) * Fraction(b)), (a / b if b else 0.0, Fraction(a) / Fraction(b) if b else 0)):
                want, got = round32(Fraction(y)), vcd_reader.f32(x)
                self.assertTrue(math.isinf(got) if want is None else want == got, (a, b))


class Dump(unittest.TestCase):
    def check(self, objects, **options):
        data = assemble(entries(objects, **options))
        report = VcdFile(data).dump()
        self.assertEqual(len(report["objects"]), len(objects))
        for o, found in zip(objects, report["objects"]):
            self.assertEqual((found["cells"], found["nodes_unfolded"], found["nodes_folded"], found["nodes_shared"]),
                             o.counts)
            self.assertEqual([*found["block_counts"], found["brick_count"]], o.pools)
            self.assertEqual((found["name"].encode(), found["depth"]), (o.name, o.depth))
        return report

    def test_every_depth_raw_and_compressed(self):
        for depth in range(1, 9):
            for storage in (0, 1):
                with self.subTest(depth=depth, storage=storage):
                    self.check([Object(depth, seed=depth, storage=storage)])

    def test_uniform_objects(self):
        for depth in range(1, 9):
            for c in range(3):
                report = self.check([Object(depth, roots=[c] * 15)])["objects"][0]
                self.assertEqual([report["nodes_" + k] for k in ("unfolded", "folded", "shared")], [15, 15, 15])

    def test_several_objects_names_geometry(self):
        report = self.check([Object(2, name="cube"), Object(6, name="", storage=1, geom=b"DRACO"), Object(3, name="é")])
        self.assertEqual([o["name"] for o in report["objects"]], ["cube", "", "é"])
        self.assertEqual(report["provenance"], {"a": "1", "b": "é"})
        self.assertEqual([s["type"] for s in report["sections"]], ["OBJT", "NAME", "PROV", "TREE", "TREE", "GEOM", "TREE"])

    def test_no_objects_no_provenance(self):
        self.assertEqual(self.check([], provenance=None)["provenance"], {})

    def test_unknown_optional_sections_are_skipped(self):
        extra = [Entry(b"LATE", b"xyz"), Entry(b"MORE", b"", alignment=4096)]
        self.assertEqual(len(self.check([Object(2)], extra=extra)["sections"]), 6)

    def test_node_counts_from_dense_cells(self):
        """*Node counts* word for word, from all cells one by one."""
        for depth in (1, 2, 3):
            o = Object(depth, seed=11)
            levels, leaf_below = o.levels, {}
            counts, groups = [0, 0], set()
            for pair in range(15):
                axis = range(2 ** levels)
                dense = {c: descend(o.roots[pair], levels, *c) for c in itertools.product(axis, repeat=4)}

                def cells(level, corner):
                    side = range(2 ** (levels - level))
                    return tuple(dense[tuple(c * len(side) + d for c, d in zip(corner, delta))]
                                 for delta in itertools.product(side, repeat=4))

                def visit(level, corner, counted):
                    inside = cells(level, corner)
                    counts[0] += 1
                    counts[1] += counted
                    if len(set(inside)) == 1:
                        return
                    children = [tuple(2 * c + d for c, d in zip(corner, delta))
                                for delta in itertools.product(range(2), repeat=4)]
                    all_leaves = all(len(set(cells(level + 1, child))) == 1 for child in children)
                    if not all_leaves:
                        groups.add((level, inside))
                    for child in children:
                        visit(level + 1, child, counted and not all_leaves)

                visit(0, (0, 0, 0, 0), True)
            self.assertEqual((*counts, 15 + 16 * len(groups)), o.counts[1:])

    def test_every_cell_is_found(self):
        for depth in range(1, 9):
            o, rng = Object(depth, seed=depth + 50), random.Random(depth)
            tree = VcdFile(assemble(entries([o]))).tree(0)
            for _ in range(3000):
                cell = (rng.randrange(15), *(rng.randrange(256) for _ in range(4)))
                self.assertEqual(tree.cell_class(*cell), o.cell(*cell))


class Classify(unittest.TestCase):
    def test_against_fractions(self):
        boxes = [((-1.0, 0.0, 2.0), (1.0, 4.0, 3.0)), ((0.0, 0.0, 0.0), (256.0, 256.0, 256.0)),
                 ((-0.1, 0.3, 1e-3), (0.7, 0.9, 0.77)), ((1e6, -1e6, 5e5), (1.1e6, -9e5, 6e5)),
                 ((0.0, 0.0, 0.0), (2.0 ** -98, 2.0 ** -99, 2.0 ** -97))]
        for i, depth in enumerate((1, 2, 3, 5, 6, 7, 8)):
            box = tuple(tuple(map(single, corner)) for corner in boxes[i % len(boxes)])
            o, rng = Object(depth, seed=depth, box=box), random.Random(depth)
            file = VcdFile(assemble(entries([o])))
            record, tree = file.objects[0], file.tree(0)
            seen = set()
            for _ in range(1500):
                segment = random_segment(rng, box)
                want = expected_answer(o, *segment)
                self.assertEqual(classify(record, tree, *segment), want, segment)
                seen.add(want)
            self.assertEqual(seen, {0, 1, 2})

    def test_by_hand(self):
        """Box [0, 256]³. Lines from face 0 (x = 0) to face 1 (x = 256): pair 0, s = u = y, t = v = z."""
        low_half = Node.of(1 if i < 8 else 0 for i in range(16))          # blocked if s is below 128
        o = Object(2, roots=[low_half] + [2] * 14, box=((0.0,) * 3, (256.0,) * 3))
        file = VcdFile(assemble(entries([o])))
        record, tree = file.objects[0], file.tree(0)

        def ask(origin, direction, t_min=0.0, t_max=INF):
            return classify(record, tree, origin, t_min, direction, t_max)

        clearance = bytearray(1536)
        clearance[16 * 0 + 1] = 5                                                     # face 0, y in [0, 16], z in [16, 32]

        def ask_with_clearance(origin, direction, t_min=0.0, t_max=INF):
            return classify(record, tree, origin, t_min, direction, t_max, clearance)

        self.assertEqual(ask_with_clearance((5.0, 10.0, 20.0), (1.0, 0.0, 0.0)), 1)   # begins five units behind face 0
        self.assertEqual(ask_with_clearance((5.1, 10.0, 20.0), (1.0, 0.0, 0.0)), 2)
        self.assertEqual(ask_with_clearance((5.0, 20.0, 20.0), (1.0, 0.0, 0.0)), 2)   # another square
        self.assertEqual(ask_with_clearance((257.0, 10.0, 20.0), (-1.0, -0.0, 0.0), 0.0, 252.0), 1)  # ends there
        self.assertEqual(ask_with_clearance((257.0, 10.0, 20.0), (-1.0, -0.0, 0.0), 0.0, 251.9), 2)
        self.assertEqual(ask_with_clearance((250.0, 10.0, 20.0), (-1.0, -0.0, 0.0)), 2)  # no clearance at face 1
        clearance[16 * 0 + 1] = clearance[256 + 16 * 0 + 1] = 200                       # no mesh has these: they overlap
        self.assertEqual(ask_with_clearance((0.0, 10.0, 20.0), (1.0, 0.0, 0.0), 100.0, 101.0), 1)
        self.assertEqual(ask_with_clearance((0.0, 10.0, 20.0), (1.0, 0.0, 0.0), 100.0, 100.0), 2)  # nothing is in an empty interval

        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0)), 1)
        self.assertEqual(ask((-1.0, 200.0, 20.0), (1.0, 0.0, 0.0)), 0)
        self.assertEqual(ask((257.0, 10.0, 20.0), (-1.0, -0.0, 0.0)), 1)            # reversed
        self.assertEqual(ask((1.0, 10.0, 20.0), (1.0, 0.0, 0.0)), 2)                # begins inside
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 0.0, 256.0), 2)   # ends inside
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 0.0, 257.0), 1)
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 0.0, 1.0), 0)     # ends at the box
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 257.0, INF), 0)   # begins behind it
        self.assertEqual(ask((-1.0, 10.0, 300.0), (1.0, 0.0, 0.0)), 0)              # misses
        self.assertEqual(ask((10.0, 10.0, -5.0), (0.0, 0.0, 1.0)), 2)               # another face pair
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), NAN, INF), 2)
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 0.0, NAN), 2)
        self.assertEqual(ask((-1.0, 10.0, 20.0), (1.0, 0.0, 0.0), 5.0, 4.0), 2)     # empty interval
        for origin, direction in (((NAN, 0.0, 0.0), (1.0, 0.0, 0.0)), ((0.0, INF, 0.0), (1.0, 0.0, 0.0)),
                                  ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((0.0, 0.0, 0.0), (0.0, NAN, 0.0)),
                                  ((0.0, 0.0, 0.0), (-INF, 0.0, 0.0)), ((0.0, 0.0, 0.0), (2.0 ** -41, 0.0, 0.0)),
                                  ((0.0, 0.0, 0.0), (2.0 ** 101, 0.0, 0.0)), ((-2.0 ** 17, 300.0, 0.0), (1.0, 0.0, 0.0))):
            self.assertEqual(ask(origin, direction), 2)
        self.assertEqual(ask((-1.0, 10.0, 20.0), (2.0 ** -40, 0.0, 0.0)), 1)
        self.assertEqual(ask((-2.0 ** 17 + 30, 10.0, 20.0), (2.0 ** 100, 0.0, 0.0)), 1)

    def test_program(self):
        o = Object(8, seed=3, storage=1)
        rng = random.Random(9)
        segments = [random_segment(rng, o.box) for _ in range(200)]
        with tempfile.TemporaryDirectory() as folder:
            path = lambda name: os.path.join(folder, name)
            with open(path("f.vcd"), "wb") as stream:
                stream.write(assemble(entries([Object(2), o])))
            with open(path("s"), "wb") as stream:
                for origin, t_min, direction, t_max in segments:
                    stream.write(struct.pack("<8f", *origin, t_min, *direction, t_max))
            self.assertEqual(vcd_reader.main(["classify", path("f.vcd"), "1", path("s"), path("out")]), 0)
            with open(path("out"), "rb") as stream:
                self.assertEqual(stream.read(), bytes(expected_answer(o, *segment) for segment in segments))
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                self.assertEqual(vcd_reader.main(["dump", "--no-checksums", path("f.vcd")]), 0)
            text = out.getvalue()
            self.assertEqual(text, json.dumps(json.loads(text), sort_keys=True, indent=2) + "\n")
            with open(path("bad.vcd"), "wb") as stream:
                stream.write(b"\x89VCD\n\x1a\n" + bytes(60))
            error = io.StringIO()
            with contextlib.redirect_stderr(error):
                self.assertEqual(vcd_reader.main(["dump", path("bad.vcd")]), 3)
            self.assertRegex(error.getvalue(), r"^vcd_reader: \*Header\*, byte 0: .*\n$")


class Golden(unittest.TestCase):
    """Files that were released, which test_agreement.py gives to both readers. They are never made anew: a reader that
    cannot read one is wrong, or of another major version."""
    FOLDER = pathlib.Path(__file__).resolve().parents[1] / "golden"

    def test_files_are_those_that_were_released(self):
        lines = (self.FOLDER / "SHA256SUMS").read_text().splitlines()
        listed = {line.split()[1]: line.split()[0] for line in lines if not line.startswith("#")}
        self.assertEqual({str(path.relative_to(self.FOLDER)) for path in self.FOLDER.rglob("*.vcd")}, set(listed))
        for name, digest in listed.items():
            self.assertEqual(hashlib.sha256((self.FOLDER / name).read_bytes()).hexdigest(), digest, name)


class Broken(unittest.TestCase):
    """Every rule broken once. Sections of the file: 0 OBJT, 1 NAME, 2 PROV, 3 TREE of object 0, ..."""

    def setUp(self):
        self.objects = [Object(8, seed=4, name="one", geom=b"DRACO"), Object(1, seed=5, name="two")]
        self.entries = entries(self.objects)
        self.data = assemble(self.entries)
        self.record = struct.unpack_from("<Q", self.data, 64 + 16)[0]
        self.tree = struct.unpack_from("<Q", self.data, 64 + 3 * 64 + 16)[0]
        VcdFile(self.data).dump()

    def rejects(self, data, section, offset=None):
        with self.assertRaises(VcdError) as caught:
            VcdFile(data).dump()
        self.assertEqual(caught.exception.section, section, caught.exception)
        if offset is not None:
            self.assertEqual(caught.exception.offset, offset, caught.exception)

    def patch(self, at, new, section, offset=None, **options):
        self.rejects(patched(self.data, (at, new), **options), section, at if offset is None else offset)

    def sections(self, section, change, offset=None, **options):
        """The file assembled anew after `change` of its list of sections."""
        changed = entries(self.objects, **options)
        changed = change(changed) or changed
        self.rejects(assemble(changed), section, offset)

    def test_header(self):
        self.patch(0, b"\x09", "Header")
        for major in (b"\0", b"\2", b"\3"):
            self.patch(8, major, "Versions")
        self.patch(16, u64(len(self.data) - 1), "Header")
        self.rejects(self.data + b"\0", "Header", 16)
        self.rejects(self.data[:-1], "Header", 16)
        self.rejects(self.data[:40], "Header", 40)
        self.rejects(b"", "Header", 0)
        self.patch(24, b"xxxx", "Header", table=False)
        self.patch(57, b"x", "Header", 56, header=False)
        self.patch(32, b"x", "Reserved fields", 32)
        self.patch(55, b"x", "Reserved fields", 32)
        huge = bytearray(self.data)
        huge[12:16] = u32(2 ** 32 - 1)
        huge[56:64] = u64(xxh3_64(bytes(huge[:56])))
        self.rejects(bytes(huge), "Header", 12)

    def test_reserved_fields(self):
        for at in (32, 64 + 60, self.record + 14):
            for minor in (b"\0", b"\1", b"\2"):
                self.rejects(patched(self.data, (at, b"\x80"), (10, minor)), "Reserved fields")
            VcdFile(patched(self.data, (at, b"\x80"), (10, b"\3"))).dump()         # ignored in version 1.3
        for bit, last, first in ((b"\x08", b"\0", b"\1"), (b"\x20", b"\1", b"\2")):  # has a meaning since then
            self.rejects(patched(self.data, (self.record + 14, bit), (10, last)), "Reserved fields")
            VcdFile(patched(self.data, (self.record + 14, bit), (10, first))).dump()
        VcdFile(assemble(self.entries, minor=0xFFFF)).dump()

    def test_table_entries(self):
        e = 64
        self.patch(e + 4, u32(3), "Section table")
        self.patch(e + 4, u32(0), "Section table")                                 # OBJT must be critical
        self.patch(e + 2 * 64 + 4, u32(1), "Section table")                        # PROV must not
        self.patch(e + 8, u32(0), "Section table")
        self.patch(e + 12, u32(2), "Section table")
        self.patch(e + 12, u32(1), "Section table")                                # OBJT must be raw
        self.patch(e + 56, u32(16), "Section table")
        self.patch(e + 3 * 64 + 56, u32(8), "Section table")                       # raw TREE: 4096
        self.patch(e + 32, u64(1), "Section table", contents=False)
        self.patch(e + 48, u64(1), "Section table", contents=False)
        self.patch(e + 64 + 16, u64(12345), "Section table")
        self.patch(e + 64 + 16, u64(struct.unpack_from("<Q", self.data, e + 64 + 16)[0] + 8), "Section table")
        self.patch(e, b"OB\0T", "Section table")
        self.patch(e + 6 * 64 - 64 + 24, u64(10 ** 6), "Section table", contents=False, offset=e + 5 * 64 + 32)
        self.patch(e + 40, u64(1) + u64(1), "Section table", contents=False)
        provenance_end = sum(struct.unpack_from("<QQ", self.data, e + 2 * 64 + 16))
        self.patch(self.tree - 1, b"\1", "Section table", offset=provenance_end)

    def test_contents_checksum(self):
        self.rejects(patched(self.data, (self.tree, b"\xff"), contents=False), "Section table", 64 + 3 * 64 + 40)
        with self.assertRaises(VcdError) as caught:                                # --no-checksums: the tree itself
            VcdFile(patched(self.data, (self.tree, b"\xff\xff"), contents=False), False).dump()
        self.assertEqual(caught.exception.section, "TREE section")

    def test_which_sections(self):
        tree = lambda i: Entry(b"TREE", self.objects[1].tree, i, alignment=4096)
        self.sections("Versions", lambda s: None, extra=[Entry(b"LATE", b"", flags=1)])
        self.sections("Section table", lambda s: None, extra=[Entry(b"OBJT", b"")])
        self.sections("Section table", lambda s: None, extra=[Entry(b"PROV", bytes(4))])
        self.sections("Section table", lambda s: None, extra=[tree(1)])
        self.sections("Section table", lambda s: None, extra=[tree(2)])
        self.sections("Section table", lambda s: None, extra=[tree(NONE)])
        self.sections("Section table", lambda s: None, extra=[Entry(b"GEOM", b"", 0)])
        self.sections("Section table", lambda s: s[:-1])
        self.sections("Section table", lambda s: s[1:])
        self.rejects(assemble([Entry(b"OBJT", b"")]), "Section table")
        self.rejects(assemble([]), "Section table")
        self.rejects(assemble(self.entries)[:-64] and patched(self.data + bytes(8), (16, u64(len(self.data) + 8))),
                     "Section table", len(self.data))

    def test_zstd(self):
        o = Object(8, seed=6)
        frame = zstd(o.tree)

        def file(stored, logical=o.tree):
            return assemble(entries([o])[:3] + [Entry(b"TREE", logical, 0, 1, 8, stored=stored)])

        VcdFile(file(frame)).dump()
        VcdFile(file(zstd(o.tree, "--no-check"))).dump()
        where = "Section table"
        self.rejects(file(frame + frame), where)
        self.rejects(file(frame + b"\0"), where)
        self.rejects(file(frame[:-1]), where)
        self.rejects(file(b""), where)
        self.rejects(file(b"\x50\x2a\x4d\x18" + u32(0) + frame), where)            # a skippable frame first
        late = Entry(b"LATE", b"", storage=1)                                      # sections of unknown types too
        self.assertEqual(len(VcdFile(assemble(entries([o]) + [late])).sections), 5)
        late.stored = b"\x50\x2a\x4d\x18" + u32(4) + b"what"                       # no frame but a skippable one
        self.rejects(assemble(entries([o]) + [late]), where)
        streamed = subprocess.run(["zstd", "-cq"], input=o.tree, capture_output=True, check=True).stdout
        self.rejects(file(streamed), where)                                        # no content size
        self.rejects(file(frame, o.tree + b"\0"), where)
        self.rejects(file(zstd(o.tree[:-1] + b"\xff"), o.tree), where)             # logical checksum
        big = bytes(1048576 + 256 * 2000)
        self.assertLess(len(zstd(big)), 1000)
        self.rejects(file(zstd(big), big), where, 64 + 3 * 64 + 32)

    def test_record(self):
        r, where = self.record, "OBJT section"
        self.patch(r, u32(1), "NAME section")
        self.patch(r + 4, u32(10 ** 6), "NAME section")
        self.patch(r + 256 + 4, u32(2), "NAME section", offset=r + 512 + 5)        # a byte after the last name
        self.patch(r + 512, b"\xff", "NAME section")
        self.patch(r + 12, b"\0", where)
        self.patch(r + 12, b"\x09", where)
        self.patch(r + 13, b"\4", where)
        self.patch(r + 13, b"\2", where, offset=r + 152)                           # proven, and 16 samples
        for bad in (INF, NAN):
            self.patch(r + 240, struct.pack("<d", bad), where, offset=r + 232)
        said = VcdFile(patched(self.data, (r + 14, b"\1"), (r + 240, struct.pack("<d", 4649776.25)))).dump()["objects"]
        self.assertEqual([o["parts_left_out"] for o in said], [True, False])
        self.assertEqual([o["shift"] for o in said], [[0, 4649776.25, 0], [0, 0, 0]])
        for bit, name in ((2, "from_outside"), (4, "from_inside"), (8, "together_from_outside"),
                          (16, "together_from_inside"), (32, "one_from_outside"), (64, "one_from_inside")):
            said = VcdFile(patched(self.data, (10, b"\2"), (r + 14, bytes([bit])))).dump()["objects"][0]["look_up_first"]
            self.assertEqual([n for n, is_set in said.items() if is_set], [name])
        for bad in (-1.0, INF, NAN, -1.0 + 1e-9, 3.4e38):
            box = struct.pack("<f", bad)
            if bad == 3.4e38:
                self.rejects(patched(self.data, (r + 28, box), (r + 16, struct.pack("<f", -bad))), where, r + 28)
            else:
                self.patch(r + 28, box, where)
        self.rejects(patched(self.data, (r + 16, bytes(4)), (r + 28, struct.pack("<f", 2.0 ** -121))), where, r + 28)
        self.patch(r + 72, u64(1), where)
        self.patch(r + 96, u32(4), where)
        self.patch(r + 100, u32(NONE), where)
        self.patch(r + 256 + 100, u32(4), where)
        self.patch(r + 152, u32(17), where)
        self.patch(r + 180, u32(1), where, offset=r + 164)
        self.sections(where, lambda s: [Entry(b"OBJT", s[0].logical + b"\0")] + s[1:], 64 + 24)

    def test_no_method(self):
        """An object of method none: a record, and no TREE."""
        def record(tree=NONE, cells=(0, 0, 3840), pools=(0, 0, 0, 3), nodes=(15, 15, 15), depth=1, samples=0):
            return struct.pack("<IIIBB2x6f16s2Q3QII4I8x3Q8I72x", 0, 0, 0, depth, 0, 0, 0, 0, 1, 1, 1, bytes(16), 12, 8, *cells,
                               tree, NONE, *pools, *nodes, samples, *[0] * 7)

        def file(*extra, **fields):
            return assemble([Entry(b"OBJT", record(**fields)), Entry(b"NAME", b""), *extra])

        good = VcdFile(file())
        self.assertEqual(good.dump()["objects"][0]["cells"], [0, 0, 3840])
        self.assertEqual(classify(good.objects[0], good.tree(0), (9.0, 9.0, 9.0), 0.0, (1.0, 0.0, 0.0), 1.0), 2)
        where = "OBJT section"
        self.rejects(file(tree=1), where)
        self.rejects(file(depth=2), where)
        self.rejects(file(cells=(1, 0, 3839)), where)
        self.rejects(file(samples=16), where)
        self.rejects(file(pools=(0, 0, 0, 4)), "TREE section")
        self.rejects(file(nodes=(15, 15, 31)), "Node counts")
        self.rejects(file(Entry(b"TREE", vcd_reader.UNCLASSIFIED_TREE, 0, alignment=4096), tree=2), "Section table")

    def test_hierarchy(self):
        """One object of method none with a hierarchy: the root has a small leaf and a node, which has a large leaf."""
        fan = [(0.0, float(i), 0.0) for i in range(17)]                            # 16 triangles over 18 vertices
        fan_triangles = [(i, i + 1, 17) for i in range(16)]
        fan.append((1.0, 8.0, 0.0))
        one = [(-3.0, 0.0, 0.0), (-2.0, 0.0, 0.0), (-2.0, 1.0, 0.1)]

        def columns(tuples, kind, count, rest):
            tuples = [*tuples, *[rest] * count][:count]
            return b"".join(struct.pack(f"<{count}{kind}", *column) for column in zip(*tuples))

        def leaf(vertices, triangles, count):
            sides = [max(axis) - min(axis) for axis in zip(*vertices)]
            return columns(vertices, "f", count, vertices[-1]) + columns(triangles, "B", 16, (0, 0, 0)) \
                + struct.pack("<HHf8x", 2 ** len(triangles) - 1, 0, max(sides))

        def node(boxes, children):
            return columns((low for low, _ in boxes), "f", 16, (INF,) * 3) \
                + columns((high for _, high in boxes), "f", 16, (-INF,) * 3) \
                + struct.pack("<16I", *children, *[0x80000000] * (16 - len(children)))

        def box(vertices):
            return tuple(map(min, zip(*vertices))), tuple(map(max, zip(*vertices)))

        one = [struct.unpack("<3f", struct.pack("<3f", *v)) for v in one]
        whole = box(one + fan)
        header = struct.pack("<IIIIQ6f16x", 26, 2, 2, 2, 17, *whole[0], *whole[1])
        good = header + node([box(one), box(fan)], [0x80000008, 12]) + leaf(one, [(0, 1, 2)], 16) \
            + node([box(fan)], [0xC0000013]) + leaf(fan, fan_triangles, 32)
        self.assertEqual(len(good), 26 * 64)
        root, small, below, large = 64, 8 * 64, 12 * 64, 19 * 64

        def file(hierarchy=good, storage=0, owners=(0,), triangles=17, low=-4.0, high=20.0):
            record = struct.pack("<IIIBB2x6f16s2Q3QII4I8x3Q8I72x", 0, 0, 0, 1, 0, low, low, low, high, high, high, bytes(16),
                                 triangles, 21, 0, 0, 3840, NONE, NONE, 0, 0, 0, 3, 15, 15, 15, *[0] * 8)
            sections = [Entry(b"HIER", hierarchy, i, storage, 8 if storage else 64) for i in owners]
            return assemble([Entry(b"OBJT", record), Entry(b"NAME", b""), *sections])

        for storage in (0, 1):
            read = VcdFile(file(storage=storage))
            self.assertEqual(read.dump()["objects"][0]["hierarchy"], {"bytes": 26 * 64, "nodes": 2, "leaves": 2, "levels": 2})
            self.assertEqual(read.hierarchy(0).triangles,
                             [tuple(one)] + [tuple(fan[c] for c in t) for t in fan_triangles])
        self.assertIsNone(VcdFile(file(owners=())).dump()["objects"][0]["hierarchy"])
        self.rejects(file(owners=(1,)), "Section table")
        self.rejects(file(owners=(0, 0)), "Section table")

        where = "HIER section"
        self.rejects(file(triangles=18), where)
        self.rejects(file(low=-3.0 + 2.0 ** -10), where)
        self.rejects(file(good + bytes(64)), where)
        self.rejects(file(good[:-64]), where)
        self.rejects(file(good[:64]), where)
        f32 = lambda x: struct.pack("<f", x)
        damages = [(at, u32(value)) for at, value in (
            (0, 25), (4, 3), (8, 3), (12, 1), (12, 0), (12, 65), (16, 16), (48, 1), (60, 1),           # header
            (root + 384, 0x80000009), (root + 384, 0xC0000008), (root + 384, 8), (root + 384, 0xA0000008),
            (root + 388, 0x80000000), (root + 388, 11), (root + 388, 0x2000000C), (root + 392, 12),
            (below + 384, 0x80000000), (below + 384, 0x80000013), (below + 384, 1),
            (small + 12 * 16 + 48, 2), (small + 12 * 16 + 48, 3), (small + 12 * 16 + 48, 0x10001), (small + 252, 1))]
        damages += [(at, bytes([value])) for at, value in (
            (small + 12 * 16, 3), (small + 12 * 16, 16), (small + 12 * 16 + 1, 1), (large + 12 * 32, 32))]
        damages += [(at, f32(value)) for at, value in (
            (24, -3.5), (24, NAN), (36, INF), (root, -3.5), (root + 4, 0.5), (root + 8, 0.0), (root + 192, -1.0),
            (below, -0.5), (small, -3.5), (small, NAN), (small + 12, -1.9), (small + 12 * 16 + 52, 1.1),
            (large + 4 * 31, 0.5))]
        for at, new in damages:
            with self.subTest(at=at, new=new):
                self.rejects(file(good[:at] + new + good[at + len(new):]), where)
                self.rejects(file(good[:at] + new + good[at + len(new):], storage=1), where)
        for exponent, is_good in ((36, True), (37, False), (-34, True), (-35, False)):  # the largest coordinate is 16
            scaled = [tuple(2.0 ** exponent * x for x in v) for v in fan]
            header = struct.pack("<IIIIQ6f16x", 15, 1, 1, 1, 16, *box(scaled)[0], *box(scaled)[1])
            data = file(header + node([box(scaled)], [0xC0000008]) + leaf(scaled, fan_triangles, 32), triangles=16,
                        low=-2.0 ** 50, high=2.0 ** 50)
            if is_good:
                VcdFile(data).dump()
            else:
                self.rejects(data, where)

    def test_counts(self):
        r = self.record
        cells = self.objects[0].counts[0]
        self.patch(r + 72, u64(cells[0] + 1) + u64(cells[1] - 1), "OBJT section")
        for i, value in enumerate(self.objects[0].counts[1:]):
            self.patch(r + 128 + 8 * i, u64(value + 16), "Node counts")
        for i in range(4):
            self.rejects(patched(self.data, (r + 104 + 4 * i, u32(2))), "TREE section")
            self.rejects(patched(self.data, (r + 104 + 4 * i, u32(self.objects[0].pools[i] + 1))), "TREE section")
        self.patch(r + 256 + 104, u32(3), "TREE section")                          # depth 1 has no blocks
        self.patch(r + 120, u32(1), "Reserved fields")
        self.patch(r + 124, u32(1), "Reserved fields", offset=r + 120)

    def test_provenance(self):
        def bad(pairs=(), raw=None):
            self.rejects(assemble([Entry(b"OBJT", b""), Entry(b"NAME", b""), Entry(b"PROV", raw)] if raw is not None
                                  else entries([], provenance=pairs)), "PROV section")
        bad([(b"b", b""), (b"a", b"")])
        bad([(b"a", b""), (b"a", b"")])
        bad([(b"\xff", b"")])
        bad([(b"a", b"\xff")])
        bad(raw=b"\0\0\0")
        bad(raw=u32(1) + u32(1))
        bad(raw=u32(1) + u32(1) + u32(2) + b"ab")
        bad(raw=u32(0) + b"\0")

    def test_tree(self):
        t, where = self.tree, "TREE section"
        top, pools = 245824, self.objects[0].pools
        starts = [t + top + 64 * sum(pools[:k]) for k in range(4)]
        brick = starts[3]
        self.patch(t, u32(pools[0]), where)
        for start, below in zip(starts, pools[1:]):
            self.patch(start + 3 * 64 + 4, u32(below), where)
        self.patch(t + 4 * 61440, u32(1), where)                                   # spare slot
        self.patch(t + 4 * 61441 + 3, b"\1", where, offset=t + 4 * 61441)          # padding
        for first in starts:
            for i in range(3):                                                     # uniform blocks
                self.patch(first + 64 * i + 4, u32(1 if i != 1 else 2), where, offset=first + 64 * i)
        self.patch(brick + 3 * 64 + 5, b"\xc0", where, offset=brick + 3 * 64)      # value 3
        for first in starts:                                                       # equal ones
            self.patch(first + 4 * 64, self.data[first + 3 * 64:first + 4 * 64], where)
        o = Object(2)                                                              # a brick that nothing refers to
        o.tree, o.pools[3] = o.tree + b"\1" * 64, o.pools[3] + 1
        self.rejects(assemble(entries([o])), where)
        o = Object(2)                                                              # the wrong size
        o.tree += bytes(64)
        self.rejects(assemble(entries([o])), where)
        o = Object(2)                                                              # depth 1 with the tree of depth 2
        o.depth = 1
        self.rejects(assemble(entries([o])), where)


if __name__ == "__main__":
    unittest.main()
