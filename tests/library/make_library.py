"""A library of meshes for trials: shapes of our own in every format, copies, renamed, re-exported and broken ones, and where the folder
of real meshes is at hand, those too. Same arguments, same bytes."""
import json
import math
import os
import pathlib
import random
import shutil
import struct


def shape(seed):
    """A closed or open surface: positions and triangles."""
    rng = random.Random(seed)
    kind = rng.choice(("blob", "ring", "leaves", "comb"))
    positions, triangles = [], []
    if kind in ("blob", "ring"):
        columns, rows = rng.randrange(6, 30), rng.randrange(4, 24)
        waves, depth = rng.randrange(2, 6), rng.uniform(0.05, 0.4)
        for r in range(rows):
            for c in range(columns):
                u, v = 2 * math.pi * c / columns, math.pi * (r + 0.5) / rows if kind == "blob" else 2 * math.pi * r / rows
                radius = 1 + depth * math.sin(waves * u) * math.sin(v)
                if kind == "blob":
                    positions.append((radius * math.sin(v) * math.cos(u), radius * math.sin(v) * math.sin(u), math.cos(v)))
                else:
                    positions.append(((2 + 0.6 * math.cos(v) * radius) * math.cos(u), (2 + 0.6 * math.cos(v) * radius) * math.sin(u), 0.6 * math.sin(v)))
        for r in range(rows - (kind == "blob")):
            for c in range(columns):
                a, b = r * columns + c, r * columns + (c + 1) % columns
                d, e = (a + columns) % len(positions), (b + columns) % len(positions)
                triangles += [(a, b, e), (a, e, d)]
    elif kind == "leaves":
        for _ in range(rng.randrange(50, 600)):
            at = [rng.gauss(0, 1) for _ in range(3)]
            i = len(positions)
            positions += [tuple(x + rng.uniform(-0.15, 0.15) for x in at) for _ in range(3)]
            triangles.append((i, i + 1, i + 2))
    else:
        for tooth in range(rng.randrange(5, 40)):
            i = len(positions)
            positions += [(tooth * 0.1, y, z) for y in (0, rng.uniform(0.5, 2)) for z in (0, rng.uniform(0.5, 2))]
            triangles += [(i, i + 1, i + 3), (i, i + 3, i + 2)]
    f = lambda x: struct.unpack("<f", struct.pack("<f", x))[0]
    return [tuple(map(f, p)) for p in positions], triangles


def as_obj(positions, triangles):
    lines = ["v %.9g %.9g %.9g" % p for p in positions] + ["f %d %d %d" % (a + 1, b + 1, c + 1) for a, b, c in triangles]
    return ("\n".join(lines) + "\n").encode()


def as_off(positions, triangles):
    lines = ["OFF", f"{len(positions)} {len(triangles)} 0"] + ["%.9g %.9g %.9g" % p for p in positions] + ["3 %d %d %d" % t for t in triangles]
    return ("\n".join(lines) + "\n").encode()


def as_ply(positions, triangles):
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n").encode()
    return head + b"".join(struct.pack("<3f", *p) for p in positions) + b"".join(struct.pack("<B3i", 3, *t) for t in triangles)


def as_stl(positions, triangles):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *positions[a], *positions[b], *positions[c], 0) for a, b, c in triangles)
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + facets


def gltf_parts(positions, triangles, uri=None):
    data = b"".join(struct.pack("<3f", *p) for p in positions) + b"".join(struct.pack("<3I", *t) for t in triangles)
    split = 12 * len(positions)
    low, high = ([f(p[a] for p in positions) for a in range(3)] for f in (min, max))
    document = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data), **({"uri": uri} if uri else {})}],
                "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": split}, {"buffer": 0, "byteOffset": split, "byteLength": len(data) - split}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", "min": low, "max": high},
                              {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"}],
                "meshes": [{"name": "shape", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]}
    return json.dumps(document).encode(), data


def as_glb(positions, triangles):
    text, data = gltf_parts(positions, triangles)
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


WRITERS = {".obj": as_obj, ".off": as_off, ".ply": as_ply, ".stl": as_stl, ".glb": as_glb}
MESHES = {".obj", ".off", ".ply", ".stl", ".glb", ".gltf", ".drc"}


def broken(rng, content):
    how = rng.randrange(3)
    if how == 0:
        return content[:rng.randrange(1, len(content))]
    if how == 1:
        return b""
    return bytes(rng.randrange(256) for _ in range(rng.randrange(1, 400)))


def make(folder, count, data=None):
    """Fills the folder; returns how many mesh files there are. A quarter are copies or re-exports of another, a twentieth are broken."""
    folder = pathlib.Path(folder)
    rng = random.Random(count)
    made = 0
    for source in sorted(pathlib.Path(data).rglob("*")) if data else ():
        if source.is_file():
            target = folder / "real" / source.relative_to(data)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
            made += source.suffix.lower() in MESHES
    number = 0
    while made < count:
        number += 1
        place = folder / f"set {number % 7}" / f"{number % 11}"
        place.mkdir(parents=True, exist_ok=True)
        seed = rng.randrange(number) if rng.random() < 0.25 else number
        mesh = shape(seed)
        made += 1
        if rng.random() < 0.04:
            text, data_bytes = gltf_parts(*mesh, uri=f"{number}.bin")
            (place / f"{number}.gltf").write_bytes(text)
            (place / f"{number}.bin").write_bytes(data_bytes)
            continue
        extension = rng.choice(sorted(WRITERS))
        content = WRITERS[extension](*mesh)
        name = f"{number}"
        if rng.random() < 0.05:
            content, name = broken(rng, content), f"{number} broken"
        elif rng.random() < 0.02:
            name = f"{number} 'odd' \"näme\"\n"
        (place / (name + extension)).write_bytes(content)
    return made
