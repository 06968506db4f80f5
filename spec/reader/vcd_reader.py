#!/usr/bin/env python3
"""An independent reader of .vcd files, written from vcd-format.md and conventions.md alone.

    vcd_reader.py dump [--no-checksums] FILE                                validate, print one JSON object
    vcd_reader.py classify [--no-checksums] FILE OBJECT_INDEX SEGMENTS OUT  one byte a 32-byte segment record

Names between asterisks are sections of vcd-format.md. Exit code 3: the file breaks the specification; the one line on
stderr names the section and the byte offset in the file.
"""
import argparse
import json
import math
import operator
import struct
import subprocess
import sys
from fractions import Fraction
from itertools import combinations, product

from xxh3 import u32, u64, xxh3_64, xxh3_128

NONE = 0xFFFFFFFF
CLEAR, BLOCKED, UNCLASSIFIED, STATISTICALLY_BLOCKED = 0, 1, 2, 3                                             # *Terms*


class VcdError(Exception):
    """A broken rule: which section of the specification, where in the file, and what."""

    def __init__(self, section, offset, message):
        super().__init__(f"*{section}*, byte {offset}: {message}")
        self.section, self.offset = section, offset


def require(condition, section, offset, message):
    if not condition:
        raise VcdError(section, offset, message)


def geometry_hash(positions, triangles):
    """*Geometry hash* of a mesh that has already been welded and sorted. (A file can only be checked against it with
    the source mesh, or with a Draco decoder for GEOM; neither is part of this reader.)"""
    data = [struct.pack("<QQ", len(positions), len(triangles))]
    data += [struct.pack("<3f", *p) for p in positions] + [struct.pack("<3I", *t) for t in triangles]
    return xxh3_128(b"".join(data)).to_bytes(16, "big")


# ---- binary32 (*Line to cell*) ---------------------------------------------------------------------------------------

_F32 = struct.Struct("<f")


def f32(x):
    """A double rounded to binary32. For + - * / of two binary32 numbers, the double result rounded again is the
    binary32 result: products and sums with a subnormal result are exact in a double, and 53 ≥ 2 · 24 + 2 for the rest;
    a quotient of 24-bit numbers is no nearer than 2^-48 to a rounding boundary that it is not on, subnormal or not."""
    try:
        return _F32.unpack(_F32.pack(x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)


# ---- file, header, section table -------------------------------------------------------------------------------------

class Section:
    """One entry of the *Section table*."""
    FORMAT = struct.Struct("<4sIII5QII")

    def __init__(self, data, index):
        self.index, self.at = index, 64 + 64 * index
        (kind, self.flags, self.object, self.storage, self.offset, self.stored_size, self.logical_size,
         self.stored_xxh3, self.logical_xxh3, self.alignment, self.reserved) = self.FORMAT.unpack_from(data, self.at)
        self.type = kind.decode("latin-1")
        self.end = self.offset + self.stored_size

    def describe(self):
        return {"type": self.type, "object": self.object, "storage": self.storage, "offset": self.offset,
                "stored_size": self.stored_size, "logical_size": self.logical_size,
                "stored_xxh3": f"{self.stored_xxh3:016x}", "logical_xxh3": f"{self.logical_xxh3:016x}"}


#            critical, owned by an object, storages
KNOWN = {"OBJT": (1, False, (0,)), "NAME": (1, False, (0,)), "PROV": (0, False, (0,)),
         "TREE": (1, True, (0, 1)), "GEOM": (0, True, (0,)),
         "CLEA": (0, True, (0,)), "HIER": (0, True, (0, 1)), "HORZ": (0, True, (0, 1))}
RAW_ALIGNMENT = {"TREE": 4096, "HIER": 64, "HORZ": 64}                                               # of the others: 8


class VcdFile:
    """A validated file. TREE and HIER sections are validated when `tree` and `hierarchy` ask for them."""

    def __init__(self, data, checksums=True):
        self.data, self.checksums = data, checksums
        self.read_header()
        self.read_section_table()
        self.contents = {s.index: self.read_section(s) for s in self.sections}
        self.read_objects()
        self.read_names()
        self.read_provenance()

    def read_header(self):
        """*Header*, *Versions*, *Reserved fields*"""
        d = self.data
        require(d[:8] == b"\x89VCD\r\n\x1a\n", "Header", 0,
                "damaged in transfer: bytes 1 to 3 say VCD" if d[1:4] == b"VCD" else "no .vcd file")
        require(len(d) >= 64, "Header", len(d), "the file ends inside the header")
        self.major, self.minor, self.count, size, table_xxh3 = struct.unpack_from("<HHIQQ", d, 8)
        require(self.major == 1, "Versions", 8, f"major version {self.major}")
        require(xxh3_64(d[:56]) == u64(d, 56), "Header", 56, "header_xxh3 is wrong")
        require(size == len(d), "Header", 16, f"file_size says {size}, the file has {len(d)} bytes")
        self.reserved(32, 24)
        self.table_end = 64 + 64 * self.count
        require(self.table_end <= len(d), "Header", 12, "the section table does not fit into the file")
        require(xxh3_64(d[64:self.table_end]) == table_xxh3, "Header", 24, "section_table_xxh3 is wrong")

    def reserved(self, at, size):
        """*Reserved fields*: zero in files of versions 1.0 to 1.2; ignored in those of later minor versions."""
        require(self.minor > 2 or not any(self.data[at:at + size]), "Reserved fields", at, "reserved field is not zero")

    def read_section_table(self):
        """*Section table*: the entries one by one, and the layout."""
        where = "Section table"
        self.sections = [Section(self.data, i) for i in range(self.count)]
        end = self.table_end
        for s in self.sections:
            require(s.type.isascii() and s.type.isalpha(), where, s.at, "type is not four ASCII letters")
            require(s.flags in (0, 1), where, s.at + 4, "a flag other than bit 0 is set")
            require(s.type in KNOWN or not s.flags, "Versions", s.at, f"unknown critical section {s.type}")
            require(s.storage in (0, 1), where, s.at + 12, f"storage {s.storage}")
            require(s.alignment in (8, 64, 4096), where, s.at + 56, f"alignment {s.alignment}")
            self.reserved(s.at + 60, 4)
            if s.type in KNOWN:
                critical, owned, storages = KNOWN[s.type]
                require(s.flags == critical, where, s.at + 4, f"{s.type} with critical flag {s.flags}")
                require(owned or s.object == NONE, where, s.at + 8, f"{s.type} with an owner")
                require(s.storage in storages, where, s.at + 12, f"{s.type} with storage {s.storage}")
                require(s.alignment == (RAW_ALIGNMENT.get(s.type, 8) if s.storage == 0 else 8), where, s.at + 56,
                        f"{s.type} with alignment {s.alignment}")
            if s.storage == 0:
                require(s.logical_size == s.stored_size, where, s.at + 32, "raw with different sizes")
                require(s.logical_xxh3 == s.stored_xxh3, where, s.at + 48, "raw with different checksums")
            else:
                require(s.logical_size <= 1048576 + 256 * s.stored_size, where, s.at + 32, "logical_size is too large")
            start = end if s.index == 0 else -(-end // s.alignment) * s.alignment
            require(s.offset % s.alignment == 0, where, s.at + 16, "offset is no multiple of the alignment")
            require(s.offset == start, where, s.at + 16, f"offset is {s.offset}, not {start}")
            require(s.end <= len(self.data), where, s.at + 24, "the section does not fit into the file")
            require(not any(self.data[end:s.offset]), where, end, "padding is not zero")
            end = s.end
        require(end == len(self.data), where, end, "the last section does not end at file_size")

    def read_section(self, s):
        """*Section table*: the logical bytes of a section, checksums verified."""
        stored = self.data[s.offset:s.end]
        self.verify(stored, s.stored_xxh3, s, s.at + 40, "stored_xxh3")
        if s.storage == 0:
            return stored
        logical = decompress(stored, s.logical_size, s.offset)
        self.verify(logical, s.logical_xxh3, s, s.at + 48, "logical_xxh3")
        return logical

    def verify(self, content, checksum, s, at, field):
        require(not self.checksums or xxh3_64(content) == checksum, "Section table", at,
                f"{field} of section {s.index} ({s.type}) is wrong")

    def only(self, kind, at_least):
        """*Section table*, column "how many", of the sections that no object owns."""
        found = [s for s in self.sections if s.type == kind]
        require(at_least <= len(found) <= 1, "Section table", 64, f"{len(found)} sections {kind}")
        return found[0] if found else None

    def read_objects(self):
        """*OBJT section*, and which TREE, HIER, GEOM and CLEA belong to which object."""
        section = self.only("OBJT", 1)
        require(section.stored_size % 256 == 0, "OBJT section", section.at + 24, "size is no multiple of 256")
        self.objects = [ObjectRecord(self, section.offset + at) for at in range(0, section.stored_size, 256)]
        owned = {}
        for s in self.sections:
            if s.type in KNOWN and KNOWN[s.type][1]:
                require(s.object < len(self.objects), "Section table", s.at + 8, f"no object {s.object}")
                require((s.type, s.object) not in owned, "Section table", s.at + 8,
                        f"second {s.type} of object {s.object}")
                owned[s.type, s.object] = s.index
                require(s.type != "CLEA" or s.logical_size == 1536, "CLEA section", s.at + 32, "size is not 1536")
        self.owned = owned
        for i, o in enumerate(self.objects):
            require((("TREE", i) in owned) == (o.method != NO_METHOD), "Section table", o.at,
                    f"object {i}: a TREE, or none, which its method does not have")
            require(o.tree_section == owned.get(("TREE", i), NONE), "OBJT section", o.at + 96, "tree_section is wrong")
            require(o.geometry_section == owned.get(("GEOM", i), NONE), "OBJT section", o.at + 100,
                    "geometry_section is wrong")

    def text(self, content, section, at):
        try:
            return content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise VcdError(section, at + error.start, "text is not UTF-8") from None

    def read_names(self):
        """*NAME section*"""
        section = self.only("NAME", 1)
        names, end = self.contents[section.index], 0
        for o in self.objects:
            require(o.name_offset == end, "NAME section", o.at, f"name_offset is {o.name_offset}, not {end}")
            end += o.name_length
            require(end <= len(names), "NAME section", o.at + 4, "the name does not fit into the section")
            o.name = self.text(names[o.name_offset:end], "NAME section", section.offset + o.name_offset)
        require(end == len(names), "NAME section", section.offset + end, "bytes after the last name")

    def read_provenance(self):
        """*PROV section*"""
        self.provenance, section, where = {}, self.only("PROV", 0), "PROV section"
        if not section:
            return
        content, at, last = self.contents[section.index], 4, None
        require(len(content) >= 4, where, section.offset, "the section ends inside the count")
        for _ in range(u32(content, 0)):
            require(at + 8 <= len(content), where, section.offset + at, "the section ends inside a pair")
            split = at + 8 + u32(content, at)
            end = split + u32(content, at + 4)
            require(end <= len(content), where, section.offset + at, "the section ends inside a pair")
            key = content[at + 8:split]
            require(last is None or last < key, where, section.offset + at + 8, "keys are not strictly ascending")
            self.provenance[self.text(key, where, section.offset + at + 8)] = \
                self.text(content[split:end], where, section.offset + split)
            last, at = key, end
        require(at == len(content), where, section.offset + at, "bytes after the last pair")

    def tree(self, index):
        """The validated tree of an object."""
        o = self.objects[index]
        if o.method == NO_METHOD:
            return Tree(UNCLASSIFIED_TREE, o, None)
        section = self.sections[o.tree_section]
        return Tree(self.contents[section.index], o, section)

    def clearance(self, index):
        """*CLEA section* of an object: its 1536 bytes, or None."""
        section = self.owned.get(("CLEA", index))
        return None if section is None else self.contents[section]

    def hierarchy(self, index):
        """The validated hierarchy of an object, or None."""
        section = self.owned.get(("HIER", index))
        return None if section is None else Hierarchy(self.contents[section], self.objects[index], self.sections[section])

    def check_horizons(self, index):
        """*HORZ section* of an object, if it has one: every rule that needs no mesh."""
        if ("HORZ", index) not in self.owned:
            return
        section = self.sections[self.owned["HORZ", index]]
        data, where, at = self.contents[section.index], "HORZ section", section.offset
        require(("HIER", index) in self.owned, where, at, "its object has no HIER section")
        require(len(data) >= 320, where, at, "the section is too small")
        entries, reserved = struct.unpack_from("<II", data)
        uniform, cosine = struct.unpack_from("<2f", data, 16)
        require(len(data) == 320 + 12 * entries, where, at, "entries is not the section's size")
        require(reserved == 0 and not any(data[280:320]), where, at, "the header's padding is not zero")
        require(0 <= uniform <= 1 and 0 <= cosine <= 1, where, at + 16, "no shares")
        for table in range(4):
            slopes = struct.unpack_from("<16f", data, 24 + 64 * table)
            require(0 < slopes[0] and slopes[14] <= 16 and math.isinf(slopes[15]) and slopes[15] > 0
                    and all(a <= b for a, b in zip(slopes, slopes[1:])), where, at + 24 + 64 * table, "slopes")
        leaves = self.hierarchy(index).leaf_sizes
        for i in range(entries):
            place, codes = struct.unpack_from("<I8s", data, 320 + 12 * i)
            if place == 0:
                require(codes == b"\xff" * 8, where, at + 320 + 12 * i, "codes without a place")
                continue
            large, count = leaves.get(place & 0xFFFFFF, (None, 0))
            require(large == (place >> 26 & 1) and place >> 27 & 15 < count, where, at + 320 + 12 * i, "no triangle")

    def dump(self):
        for i, o in enumerate(self.objects):
            self.tree(i).check_counts()
            o.hierarchy = self.hierarchy(i)
            self.check_horizons(i)
        return {"version": [self.major, self.minor], "sections": [s.describe() for s in self.sections],
                "objects": [o.describe() for o in self.objects], "provenance": self.provenance}


def decompress(stored, logical_size, at):
    """*Section table*, `zstd`: exactly one frame (RFC 8878, 3.1.1) that states its content size. The frame is walked
    block by block to see that it ends where the stored bytes end; the zstd program does the rest."""
    def check(condition, message):
        require(condition, "Section table", at, message)

    check(len(stored) >= 6 and stored[:4] == b"\x28\xb5\x2f\xfd", "no Zstandard frame")
    descriptor = stored[4]
    single_segment, size_flag = descriptor >> 5 & 1, descriptor >> 6
    content_at = 5 + (1 - single_segment) + (0, 1, 2, 4)[descriptor & 3]
    content_bytes = (single_segment, 2, 4, 8)[size_flag]
    check(content_bytes, "the frame does not state its content size")
    content = int.from_bytes(stored[content_at:content_at + content_bytes], "little") + (256 if size_flag == 1 else 0)
    check(content == logical_size, f"the frame holds {content} bytes, not logical_size")
    end, last = content_at + content_bytes, False
    while not last:
        check(end + 3 <= len(stored), "the frame is cut")
        block = int.from_bytes(stored[end:end + 3], "little")
        last, kind, size = block & 1, block >> 1 & 3, block >> 3
        check(kind != 3, "reserved block type in the frame")
        end += 3 + (1 if kind == 1 else size)
    check(end + 4 * (descriptor >> 2 & 1) == len(stored), "not exactly one frame")
    run = subprocess.run(["zstd", "-dcq", "--long=31"], input=stored, capture_output=True)
    check(run.returncode == 0 and len(run.stdout) == logical_size, "zstd cannot decompress the frame")
    return run.stdout


NO_METHOD, SAMPLED, PROVEN, HYBRID = range(4)                                            # *Methods*
# *Methods*, `none`: the top table and the three uniform bricks of a tree of depth 1 in which all cells are unclassified.
UNCLASSIFIED_TREE = struct.pack("<16I", *[2] * 15, 0) + b"".join(bytes([i * 0x55]) * 64 for i in range(3))
PARTS_LEFT_OUT, LOOK_UP_FROM_OUTSIDE, LOOK_UP_FROM_INSIDE = 1, 2, 4                      # bits of `flags`
LOOK_UP_TOGETHER_FROM_OUTSIDE, LOOK_UP_TOGETHER_FROM_INSIDE = 8, 16
LOOK_UP_ONE_FROM_OUTSIDE, LOOK_UP_ONE_FROM_INSIDE = 32, 64


class ObjectRecord:
    """One record of the *OBJT section*."""
    FORMAT = struct.Struct("<IIIBBH3f3f16sQQ3QII4IQQQQ8IQ2Q2Qff3d")
    NAMES = ("source_index", "depth", "method", "method_parameters", "box_min", "box_max", "triangle_count",
             "vertex_count", "cells", "block_counts", "brick_count",
             "nodes_unfolded", "nodes_folded", "nodes_shared", "statistical_cells", "audit_lines", "audit_wrong",
             "audit_bound_95", "guard_band", "shift")

    def __init__(self, file, at):
        self.at, self.name, self.hierarchy, where = at, "", None, "OBJT section"
        f = self.FORMAT.unpack_from(file.data, at)
        self.name_offset, self.name_length, self.source_index, self.depth, self.method, self.flags = f[:6]
        self.box_min, self.box_max, self.geometry_hash = f[6:9], f[9:12], f[12]
        self.triangle_count, self.vertex_count, self.cells = f[13], f[14], list(f[15:18])
        self.tree_section, self.geometry_section = f[18:20]
        self.block_counts, self.brick_count, reserved = list(f[20:23]), f[23], f[24]
        self.nodes_unfolded, self.nodes_folded, self.nodes_shared = f[25:28]
        self.method_parameters = list(f[28:36])
        self.statistical_cells, self.audit_lines, self.audit_wrong = f[36], list(f[37:39]), list(f[39:41])
        self.audit_bound_95, self.guard_band, self.shift = f[41], f[42], list(f[43:46])
        known = {0: 8, 1: 32, 2: 128}.get(file.minor, 1 << 16)
        require(self.flags < known, "Reserved fields", at + 14, f"flags {self.flags:#x}")
        require(file.minor > 2 or reserved == 0, "Reserved fields", at + 120, "of an object")
        require(all(map(math.isfinite, self.shift)), where, at + 232, "shift is not finite")
        require(1 <= self.depth <= 8, where, at + 12, f"depth {self.depth}")
        self.check_method(where)
        self.scale = []                                                    # *Line to cell*, step 1
        for a in range(3):
            extent = f32(self.box_max[a] - self.box_min[a])
            require(2.0 ** -100 <= extent <= 2.0 ** 100, where, at + 28 + 4 * a, "box_max - box_min is out of range")
            self.scale.append(f32(256.0 / extent))
        self.levels = max(self.depth, 2)                                   # L of *TREE section*
        require(sum(self.cells) + self.statistical_cells == 15 * 16 ** self.levels, where, at + 72,
                "the cells do not add up to 15 · 16^L")

    def check_method(self, where):
        at, samples = self.at, self.method_parameters[0]
        require(self.method <= HYBRID, where, at + 13, f"unknown method {self.method}")
        require(samples in {NO_METHOD: (0,), SAMPLED: (16, 81, 256), PROVEN: (0,), HYBRID: (81, 256)}[self.method], where,
                at + 152, "samples a cell")
        require(not any(self.method_parameters[0 if self.method == NO_METHOD else 3:]), where, at + 164,
                "method parameters that are not used are not zero")
        guarded = self.method in (PROVEN, HYBRID)
        require(0 < self.guard_band < float("inf") if guarded else self.guard_band == 0, where, at + 228, "guard band")
        require(self.method == HYBRID or self.statistical_cells == 0, where, at + 184, "statistical cells")
        require(self.method != NO_METHOD or (self.depth == 1 and self.cells[:2] == [0, 0]), where, at + 72,
                "method none, and not wholly unclassified at depth 1")
        for lines, wrong in zip(self.audit_lines, self.audit_wrong):
            require(wrong <= lines, where, at + 208, "more wrong lines than lines")
            require(self.method != PROVEN or wrong == 0, where, at + 208, "proven, and wrong lines")
        if self.audit_lines[0] == 0:
            require(self.audit_bound_95 == 0, where, at + 224, "a bound without an audit")
        else:
            require(self.audit_wrong[0] / self.audit_lines[0] <= self.audit_bound_95 <= 1, where, at + 224, "the bound")

    def describe(self):
        return {"name": self.name, "geometry_hash": self.geometry_hash.hex(),
                "parts_left_out": bool(self.flags & PARTS_LEFT_OUT),
                "look_up_first": {"from_outside": bool(self.flags & LOOK_UP_FROM_OUTSIDE),
                                  "from_inside": bool(self.flags & LOOK_UP_FROM_INSIDE),
                                  "together_from_outside": bool(self.flags & LOOK_UP_TOGETHER_FROM_OUTSIDE),
                                  "together_from_inside": bool(self.flags & LOOK_UP_TOGETHER_FROM_INSIDE),
                                  "one_from_outside": bool(self.flags & LOOK_UP_ONE_FROM_OUTSIDE),
                                  "one_from_inside": bool(self.flags & LOOK_UP_ONE_FROM_INSIDE)},
                "hierarchy": self.hierarchy and self.hierarchy.describe(),
                **{name: getattr(self, name) for name in self.NAMES}}


# ---- the tree --------------------------------------------------------------------------------------------------------

def row_major(s, t, u, v, bits):
    """*TREE section*, Row-major order."""
    return ((s << bits | t) << bits | u) << bits | v


def sibling_groups(bits):
    """For each cell one level up, in row-major order: the indices of the sixteen cells inside it. bits ≥ 1."""
    half, pair = range(2 ** (bits - 1)), range(2)
    return [operator.itemgetter(*(row_major(2 * s + a, 2 * t + b, 2 * u + c, 2 * v + d, bits)
                                  for a, b, c, d in product(pair, repeat=4)))
            for s, t, u, v in product(half, repeat=4)]


GROUPS = {bits: sibling_groups(bits) for bits in (1, 2, 3)}
BRICK_BYTE = [bytes(byte >> 2 * i & 3 for i in range(4)) for byte in range(256)]


class Pool:
    """One array of blocks of a *TREE section*: `blocks[i][slot]` is an index into the next array, or a class."""

    def __init__(self, name, bits, raw):
        self.name, self.bits = name, bits
        if name == "brick":
            self.blocks = [b"".join(map(BRICK_BYTE.__getitem__, block)) for block in raw]
        else:
            self.blocks = [struct.unpack(f"<{16 ** bits}I", block) for block in raw]


class Tree:
    """*TREE section*: the arrays of one object, every rule checked."""

    def __init__(self, data, record, section):
        self.record, self.levels, self.section = record, record.levels, section
        levels, top_bits = self.levels, min(self.levels - 2, 3)
        self.top_bits, slots = top_bits, 15 * 16 ** top_bits
        top_bytes = -(-(slots + 1) * 4 // 64) * 64
        present = levels - 2 - top_bits
        layout = [(f"block of level {3 + k}", 1, record.block_counts[k]) for k in range(present)]
        layout.append(("brick", 2, record.brick_count))
        require(not any(record.block_counts[present:]), "TREE section", record.at + 104 + 4 * present,
                "blocks that the depth does not have")
        for name, _, count in layout:
            require(count >= 3, "TREE section", record.at + 104, f"{name} count is {count}")
        size = top_bytes + sum(64 * count for _, _, count in layout)
        require(len(data) == size, "TREE section", section.at + 32 if section else record.at + 116,
                f"the tree has {len(data)} bytes, not {size}")

        self.top = struct.unpack_from(f"<{slots}I", data)
        self.check(u32(data, 4 * slots) == 0, 4 * slots, "the spare slot is not 0")
        self.check(not any(data[4 * slots + 4:top_bytes]), 4 * slots + 4, "the top table's padding is not zero")
        self.pools, at = [], top_bytes
        before, before_at = [self.top], 0
        for name, bits, count in layout:
            raw = [data[i:i + 64] for i in range(at, at + 64 * count, 64)]
            self.check_pool(name, raw, at, before, before_at)
            self.pools.append(Pool(name, bits, raw))
            before, before_at = self.pools[-1].blocks, at
            at += 64 * count
        if record.depth == 1:
            for i, brick in enumerate(self.pools[0].blocks):
                self.check(all(len(set(group(brick))) == 1 for group in GROUPS[2]), top_bytes + 64 * i,
                           "depth 1, and cells of level 2 inside one cell of level 1 differ")

    def check(self, condition, logical, message):
        """For a compressed section the byte offset is that of the section; the message has the logical one."""
        if not condition:
            where = self.section.offset + (logical if self.section.storage == 0 else 0)
            raise VcdError("TREE section", where, f"{message} (logical byte {logical} of section {self.section.index})")

    def check_pool(self, name, raw, at, before, before_at):
        """*TREE section*: indices below the count, uniform blocks, value 3, equal blocks, unused blocks."""
        used = {0, 1, 2}
        for i, block in enumerate(before):
            used.update(block)
            if max(block) >= len(raw):
                slot = next(k for k, word in enumerate(block) if word >= len(raw))
                self.check(False, before_at + 4 * (i * len(block) + slot), f"{name} index {block[slot]} is too large")
        for i in range(3):
            uniform = bytes([i * 0x55]) * 64 if name == "brick" else struct.pack("<I", i) * 16
            self.check(raw[i] == uniform, at + 64 * i, f"{name} {i} is not the uniform one")
        if name == "brick" and self.record.method != HYBRID:
            for i, block in enumerate(raw):
                bits = int.from_bytes(block, "little")
                self.check(not bits & bits >> 1 & int.from_bytes(b"\x55" * 64, "little"), at + 64 * i,
                           f"brick {i} has a cell of value 3")
        seen = {}
        for i, block in enumerate(raw):
            self.check(seen.setdefault(block, i) == i, at + 64 * i, f"{name} {i} equals {name} {seen[block]}")
        if len(used) < len(raw):
            unused = next(i for i in range(len(raw)) if i not in used)
            self.check(False, at + 64 * unused, f"{name} {unused} is not referred to")

    def cell_class(self, pair, s, t, u, v):
        """*TREE section*, From bytes to class."""
        shift = 8 - self.top_bits
        slot = row_major(s >> shift, t >> shift, u >> shift, v >> shift, self.top_bits)
        index = self.top[(pair << 4 * self.top_bits) + slot]
        for pool in self.pools:
            shift -= pool.bits
            mask = (1 << pool.bits) - 1
            index = pool.blocks[index][row_major(s >> shift & mask, t >> shift & mask, u >> shift & mask,
                                                 v >> shift & mask, pool.bits)]
        return index

    def check_counts(self):
        """`cells` of the *OBJT section* and the three numbers of *Node counts*, from the tree."""
        record, forest, level = self.record, Forest(self.levels), self.levels
        nodes = [CLEAR, BLOCKED, UNCLASSIFIED, STATISTICALLY_BLOCKED]  # the node of each index of the array below
        for pool in reversed(self.pools):
            nodes = [forest.join([nodes[word] for word in block], pool.bits, level) for block in pool.blocks]
            level -= pool.bits
        width = 16 ** self.top_bits
        roots = [forest.join([nodes[word] for word in self.top[pair * width:(pair + 1) * width]], self.top_bits, level)
                 for pair in range(15)]
        *cells, statistical, unfolded, folded = map(sum, zip(*(forest.totals[0][root] for root in roots)))
        for name, offset, found in (("cells", 72, cells), ("statistical_cells", 184, statistical),
                                    ("nodes_unfolded", 128, unfolded),
                                    ("nodes_folded", 136, folded), ("nodes_shared", 144, 15 + 16 * forest.groups)):
            stated = getattr(record, name)
            require(stated == found, "OBJT section" if "cells" in name else "Node counts", record.at + offset,
                    f"{name} says {stated}, the tree has {found}")


class Forest:
    """*Node counts*. A node is a number that only makes sense with its level: 0 to 3 are the leaves of the four
    classes; equal subtrees of one level, of whichever face pair, are the same node."""

    def __init__(self, levels):
        self.known = [{} for _ in range(levels)]               # by level: sixteen children -> node
        self.totals = []                                       # by level and node: four cell counts, unfolded, folded
        for level in range(levels + 1):
            cells = 16 ** (levels - level)
            self.totals.append([tuple(cells * (c == leaf) for c in range(4)) + (1, 1) for leaf in range(4)])
        self.groups = 0                                        # g

    def join(self, nodes, bits, level):
        """The one node `bits` levels above a row-major array of nodes of `level`."""
        for b in range(bits, 0, -1):
            level -= 1
            nodes = [self.parent(group(nodes), level) for group in GROUPS[b]]
        return nodes[0]

    def parent(self, children, level):
        if children[0] <= 3 and children.count(children[0]) == 16:
            return children[0]                                 # all cells inside have one class: a leaf
        node = self.known[level].get(children)
        if node is None:
            *cells, unfolded, folded = map(sum, zip(*(self.totals[level + 1][child] for child in children)))
            folds = max(children) <= 3                         # all sixteen children are leaves
            self.groups += not folds
            node = self.known[level][children] = len(self.totals[level])
            self.totals[level].append((*cells, 1 + unfolded, 1 if folds else 1 + folded))
        return node


# ---- the hierarchy ---------------------------------------------------------------------------------------------------

UNIT, NODE_UNITS, NO_CHILD = 64, 7, 0x80000000


def columns(raw, at, count, rows=3, kind="f"):
    """`count` tuples of `rows` numbers, which are stored as `rows` arrays of `count`."""
    numbers = struct.unpack_from(f"<{rows * count}{kind}", raw, at)
    return list(zip(*(numbers[row * count:(row + 1) * count] for row in range(rows))))


def box_of(points):
    points = list(points)
    return tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))


def rounded_up(x):
    """The least binary32 that is not below a fraction of at least 0."""
    nearest = f32(float(x))
    return nearest if nearest >= x else _F32.unpack(struct.pack("<I", u32(_F32.pack(nearest), 0) + 1))[0]


class Hierarchy:
    """*HIER section* of one object, every rule checked that needs no mesh. `triangles` holds their corners."""

    def __init__(self, data, record, section):
        self.data, self.section, self.triangles = data, section, []
        self.leaf_sizes = {}                                   # by unit: whether it is a large leaf, and its triangles
        self.check(len(data) >= (1 + NODE_UNITS) * UNIT, 0, "the section is too small")
        self.units, self.node_count, self.leaf_count, self.levels, triangle_count = struct.unpack_from("<IIIIQ", data)
        self.check(len(data) == UNIT * self.units and self.units <= 0x1FFFFFFF, 0, "units is not the section's size")
        self.check(1 <= self.levels <= 64, 0, f"{self.levels} levels")
        self.check(not any(data[48:64]), 0, "the header's padding is not zero")
        self.check(triangle_count == record.triangle_count, 0, "triangle_count is not the record's")
        low, high = struct.unpack_from("<3f", data, 24), struct.unpack_from("<3f", data, 36)
        self.check(all(map(math.isfinite, low + high)), 0, "the header's box is not finite")
        self.check(2.0 ** -30 <= max(map(abs, low + high)) <= 2.0 ** 40, 0, "the coordinates are too large or too small")
        self.check(all(m <= a and b <= n for m, a, b, n in zip(record.box_min, low, high, record.box_max)), 0,
                   "the header's box is not inside the record's")
        self.next, self.nodes, self.leaves, self.deepest = 1, 0, 0, 0
        self.check(self.read_node(1, 1) == (low, high), 0, "the header's box is not that of the vertices")
        self.check((self.next, self.nodes, self.leaves, self.deepest, len(self.triangles))
                   == (self.units, self.node_count, self.leaf_count, self.levels, triangle_count), 0,
                   "the section does not hold what its header says")

    def check(self, condition, unit, message):
        """For a compressed section the byte offset is that of the section; the message has the unit."""
        where = self.section.offset + (UNIT * unit if self.section.storage == 0 else 0)
        require(condition, "HIER section", where, f"{message} (unit {unit} of section {self.section.index})")

    def take(self, unit, units):
        """Order: what begins at `unit` is next."""
        self.check(unit == self.next, self.next, f"unit {unit} is where unit {self.next} is due")
        self.check(unit + units <= self.units, unit, "the section ends inside a node or leaf")
        self.next += units

    def read_node(self, unit, level):
        """The box of what is below the node, which is level `level`."""
        self.check(level <= 64, unit, "too many levels")
        self.take(unit, NODE_UNITS)
        self.nodes, self.deepest = self.nodes + 1, max(self.deepest, level)
        at = UNIT * unit
        words = struct.unpack_from("<16I", self.data, at + 384)
        boxes = list(zip(columns(self.data, at, 16), columns(self.data, at + 192, 16)))
        count = words.index(NO_CHILD) if NO_CHILD in words else 16
        self.check(count > 0, unit, "a node without children")
        empty = (math.inf,) * 3, (-math.inf,) * 3
        self.check(all(w == NO_CHILD and b == empty for w, b in zip(words[count:], boxes[count:])), unit,
                   "a child behind absent ones, or an absent one with a box")
        children = list(zip(words[:count], boxes))
        for word, box in children:
            if word >> 31:
                self.check(self.read_leaf(word) == box, word & 0x1FFFFFFF, "the leaf's box is not that of its vertices")
        for word, box in children:
            if not word >> 31:
                self.check(self.read_node(word, level + 1) == box, unit, "a child's box is not that of what is below")
        return box_of(corner for box in boxes[:count] for corner in box)

    def read_leaf(self, word):
        """The box of the leaf's vertices."""
        unit, large, at = word & 0x1FFFFFFF, word >> 30 & 1, UNIT * (word & 0x1FFFFFFF)
        self.check(not word >> 29 & 1, self.next, "bit 29 of a child is set")
        self.take(unit, 7 if large else 4)
        self.leaves += 1
        count = 32 if large else 16
        vertices, corners = columns(self.data, at, count), columns(self.data, at + 12 * count, 16, 3, "B")
        present, zero, extent, *padding = struct.unpack_from("<HHf2I", self.data, at + 12 * count + 48)
        n = present.bit_length()
        self.check(n and present == 2 ** n - 1, unit, "present is not 2^n - 1")
        self.check(not zero and not any(padding), unit, "the leaf's padding is not zero")
        self.check(not any(map(any, corners[n:])), unit, "an absent triangle has corners")
        used = {corner for triangle in corners[:n] for corner in triangle}
        self.check(max(used) < count and used == set(range(max(used) + 1)), unit, "a vertex is not used, or is not there")
        self.check(all(math.isfinite(x) for vertex in vertices for x in vertex), unit, "a vertex is not finite")
        self.check(all(vertex == vertices[max(used)] for vertex in vertices[max(used):]), unit,
                   "vertices behind the last one do not repeat it")
        self.leaf_sizes[unit] = (large, n)
        self.triangles += [tuple(vertices[corner] for corner in triangle) for triangle in corners[:n]]
        low, high = box_of(vertices)
        self.check(extent == max(rounded_up(Fraction(b) - Fraction(a)) for a, b in zip(low, high)), unit, "extent is not the longest side")
        return low, high

    def describe(self):
        return {"bytes": len(self.data), "nodes": self.node_count, "leaves": self.leaf_count, "levels": self.levels}


# ---- segments --------------------------------------------------------------------------------------------------------

PAIRS = {faces: i for i, faces in enumerate(combinations(range(6), 2))}
OTHER_AXES = ((1, 2), (0, 2), (0, 1))


def line_to_cell(record, origin, direction):
    """*Line to cell*, steps 2 to 9. None: not valid; else (t_entry, t_exit, cell, swapped), where cell is (pair, s, t, u, v),
    or None if the line misses the box, and swapped says that it enters by the second face."""
    p = [f32(f32(o - m) * k) for o, m, k in zip(origin, record.box_min, record.scale)]                       # 2
    q = [f32(d * k) for d, k in zip(direction, record.scale)]
    distance = f32(f32(abs(p[0]) + abs(p[1])) + abs(p[2]))                                                   # 3
    length = f32(f32(abs(q[0]) + abs(q[1])) + abs(q[2]))
    if not (distance <= 2.0 ** 17 and 2.0 ** -40 <= length <= 2.0 ** 100):
        return None
    near, far = [], []
    for a in range(3):
        q[a] = math.copysign(max(abs(q[a]), 2.0 ** -100), q[a])                                              # 4
        r = f32(1.0 / q[a])                                                                                  # 5
        low, high = f32(f32(0.0 - p[a]) * r), f32(f32(256.0 - p[a]) * r)
        near.append(min(low, high))
        far.append(max(low, high))
    t_entry, t_exit = max(near), min(far)                                                                    # 6
    if not t_entry < t_exit:
        return t_entry, t_exit, None, False
    entry_axis, exit_axis = near.index(t_entry), far.index(t_exit)
    entry_face = 2 * entry_axis + (q[entry_axis] < 0)                                                        # 7
    exit_face = 2 * exit_axis + (not q[exit_axis] < 0)
    points = [(entry_face, t_entry), (exit_face, t_exit)]
    coordinates = []
    for face, t in sorted(points):                                                                           # 8, 9
        for a in OTHER_AXES[face // 2]:
            coordinates.append(int(min(max(f32(f32(q[a] * t) + p[a]), 0.0), 255.0)))
    return t_entry, t_exit, (PAIRS[min(entry_face, exit_face), max(entry_face, exit_face)], *coordinates), entry_face > exit_face


def covers(clearance, cell, t_entry, t_exit, swapped, t_min, t_max):
    """*The answer*: whether a segment leaves out no more of its line's way through the box than the clearance at its ends.
    clearance: bytes or None."""
    if clearance is None:
        return t_min <= t_entry and t_max >= t_exit
    pair, *coordinates = cell
    ends = []
    for face, (first, second) in zip(tuple(PAIRS)[pair], (coordinates[:2], coordinates[2:])):
        ends.append(clearance[256 * face + 16 * (first >> 4) + (second >> 4)] / 256)
    at_entry, at_exit = reversed(ends) if swapped else ends
    way = f32(t_exit - t_entry)
    late, early = (f32(a - b) if math.isfinite(a - b) else a - b for a, b in ((t_min, t_entry), (t_exit, t_max)))
    return t_min < t_max and late <= f32(at_entry * way) and early <= f32(at_exit * way)


def classify(record, tree, origin, t_min, direction, t_max, clearance=None):
    """*Line to cell*, The answer."""
    line = line_to_cell(record, origin, direction)
    if line is None or record.method == NO_METHOD:
        return UNCLASSIFIED
    t_entry, t_exit, cell, swapped = line
    if cell is None or t_min >= t_exit or t_max <= t_entry:
        return CLEAR
    found = tree.cell_class(*cell)
    if found == CLEAR:
        return CLEAR
    blocked = found in (BLOCKED, STATISTICALLY_BLOCKED)
    return BLOCKED if blocked and covers(clearance, cell, t_entry, t_exit, swapped, t_min, t_max) else UNCLASSIFIED


def classify_file(file, index, segments):
    record, tree, clearance = file.objects[index], file.tree(index), file.clearance(index)
    return bytes(classify(record, tree, (ox, oy, oz), t_min, (dx, dy, dz), t_max, clearance)
                 for ox, oy, oz, t_min, dx, dy, dz, t_max in struct.iter_unpack("<8f", segments))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, positions in (("dump", ["FILE"]), ("classify", ["FILE", "OBJECT_INDEX", "SEGMENTS", "OUT"])):
        command = commands.add_parser(name)
        command.add_argument("--no-checksums", action="store_true", help="do not verify the checksums of the sections")
        for position in positions:
            command.add_argument(position, type=int if position == "OBJECT_INDEX" else str)
    options = parser.parse_args(arguments)
    try:
        with open(options.FILE, "rb") as stream:
            file = VcdFile(stream.read(), not options.no_checksums)
        if options.command == "dump":
            print(json.dumps(file.dump(), sort_keys=True, indent=2))
            return 0
        if not 0 <= options.OBJECT_INDEX < len(file.objects):
            parser.error(f"the file has {len(file.objects)} objects")
        with open(options.SEGMENTS, "rb") as stream:
            segments = stream.read()
        if len(segments) % 32:
            parser.error("SEGMENTS is not a multiple of 32 bytes")
        answers = classify_file(file, options.OBJECT_INDEX, segments)
        with open(options.OUT, "wb") as stream:
            stream.write(answers)
        return 0
    except VcdError as error:
        print(f"vcd_reader: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        parser.error(str(error))


if __name__ == "__main__":
    sys.exit(main())
