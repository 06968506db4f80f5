#!/usr/bin/env python3
"""Makes shrub.glb, the bundled example asset: a branching shrub of tapering stems with leaves, about 9,000 triangles.

    python3 assets/make_shrub.py assets/shrub.glb

The same script gives the same bytes everywhere: one seed, and all coordinates rounded to 1/4096 of a metre.
"""
import json
import math
import random
import struct
import sys


def add(a, b): return tuple(x + y for x, y in zip(a, b))
def scale(a, s): return tuple(x * s for x in a)
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
def unit(a): return scale(a, 1 / math.sqrt(sum(x * x for x in a)))


class Shrub:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.positions, self.indices = [], []

    def vertex(self, p):
        self.positions.append(tuple(round(x * 4096) / 4096 for x in p))
        return len(self.positions) - 1

    def frame(self, axis):
        side = unit(cross(axis, (0.36, 0.48, 0.8) if abs(axis[1]) > 0.9 else (0, 1, 0)))
        return side, cross(axis, side)

    def stem(self, start, end, r0, r1, sides=5):
        side, up = self.frame(unit(add(end, scale(start, -1))))
        rings = []
        for centre, radius in ((start, r0), (end, r1)):
            angles = [2 * math.pi * k / sides for k in range(sides)]
            rings.append([self.vertex(add(centre, add(scale(side, radius * math.cos(a)), scale(up, radius * math.sin(a)))))
                          for a in angles])
        for k in range(sides):
            a, b = rings[0][k], rings[0][(k + 1) % sides]
            c, d = rings[1][k], rings[1][(k + 1) % sides]
            self.indices += [a, b, c, b, d, c]

    def leaf(self, base, axis, length):
        side, up = self.frame(axis)
        turn = self.random.uniform(0, 2 * math.pi)
        across = add(scale(side, math.cos(turn)), scale(up, math.sin(turn)))
        middle = add(base, scale(axis, 0.5 * length))
        corners = (base, add(middle, scale(across, 0.3 * length)), add(base, scale(axis, length)),
                   add(middle, scale(across, -0.3 * length)))
        a, b, c, d = (self.vertex(p) for p in corners)
        self.indices += [a, b, c, a, c, d]

    def spread(self, axis, angle):
        side, up = self.frame(axis)
        turn = self.random.uniform(0, 2 * math.pi)
        away = add(scale(side, math.cos(turn)), scale(up, math.sin(turn)))
        return unit(add(add(scale(axis, math.cos(angle)), scale(away, math.sin(angle))), (0, 0.12, 0)))

    def branch(self, start, axis, length, radius, level):
        end = add(start, scale(axis, length))
        self.stem(start, end, radius, 0.7 * radius)
        if level == 0:
            for _ in range(11):
                at = add(start, scale(axis, length * self.random.uniform(0.2, 1)))
                self.leaf(at, self.spread(axis, self.random.uniform(0.5, 1.3)), self.random.uniform(0.05, 0.1))
            return
        for _ in range(4):
            angle = self.random.uniform(0.3, 0.9)
            self.branch(end, self.spread(axis, angle), length * self.random.uniform(0.6, 0.8), 0.6 * radius, level - 1)


def write_glb(path, positions, indices):
    index_bytes = struct.pack(f"<{len(indices)}H", *indices)
    index_bytes += b"\0" * (-len(index_bytes) % 4)
    position_bytes = b"".join(struct.pack("<3f", *p) for p in positions)
    document = {
        "asset": {"version": "2.0", "generator": "vcd assets/make_shrub.py"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "shrub"}],
        "meshes": [{"name": "shrub", "primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": [min(p[a] for p in positions) for a in range(3)],
             "max": [max(p[a] for p in positions) for a in range(3)]}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(index_bytes), "target": 34963},
            {"buffer": 0, "byteOffset": len(index_bytes), "byteLength": len(position_bytes), "target": 34962}],
        "buffers": [{"byteLength": len(index_bytes) + len(position_bytes)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = index_bytes + position_bytes
    with open(path, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def main():
    shrub = Shrub(7)
    for _ in range(4):
        shrub.branch((0, 0, 0), shrub.spread((0, 1, 0), 0.5), 0.3, 0.018, 3)
    write_glb(sys.argv[1], shrub.positions, shrub.indices)
    print(f"{len(shrub.indices) // 3} triangles")


if __name__ == "__main__":
    main()
