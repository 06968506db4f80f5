#!/usr/bin/env python3
"""make_seeds.py [FOLDER]: writes the seed corpora of tiny meshes and of all mesh formats but Draco, the same bytes each time.

The seeds in tests/fuzz/seeds were made by this script and, where encoders are needed, by make_seeds.cpp.
Sidecars are seeded by tests/golden.
"""
import base64
import hashlib
import json
import pathlib
import struct
import sys

CUBE = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]


def lines(*parts):
    return ("\n".join(parts) + "\n").encode()


def obj():
    v = [f"v {x} {y} {z}" for x, y, z in CUBE]
    quads = ["f " + " ".join(str(i + 1) for i in q) for q in QUADS]
    yield "cube", lines("# cube", "o cube", *v, *quads)
    yield "crlf", lines(*v, *quads).replace(b"\n", b"\r\n")
    yield "relative", lines("v 0 0 0", "v 1e0 0 0", "v 0 1 -.5", "f -3 -2 -1", "v 1 1 1 1", "fo -1 -2 -3")
    yield "texture", lines(*v[:4], "vt 0 0", "vn 0 0 1", "usemtl m", "f 1/1/1 2/1/1 3/1/1", "f 1//1 3//1 4//1", "f 1/1 2/1 4/1")
    yield "concave", lines("v 0 0 0", "v 4 0 0", "v 4 4 0", "v 2 1 0", "v 0 4 0", "f 1 2 3 \\", "4 5", "g other", "s off")
    yield "other", b"\xef\xbb\xbf" + lines(*v[:3], "l 1 2", "p 1", "f 1 2 3", "curv 0 1 1 2", "mtllib none.mtl")


def off():
    v = [f"{x} {y} {z}" for x, y, z in CUBE]
    quads = ["4 " + " ".join(map(str, q)) for q in QUADS]
    yield "cube", lines("OFF", "8 6 12", *v, *quads)
    yield "inline", lines("OFF 3 1 0", "0 0 0", "1 0 0", "0 1 .5", "3 0 1 2 255 0 0")
    yield "colours", lines("COFF", "# a comment", "3 1 3", "0 0 0 1 0 0 1", "1 0 0 1 0 0 1", "0 1 0 1 0 0 1", "3 0 1 2")
    yield "normals", lines("STNOFF", "3 2 0", "0 0 0 0 0 1 0 0", "1 0 0 0 0 1 0 0", "0 1 0 0 0 1 0 0", "3 0 1", "2", "1 0")


PLY_ASCII = ["property float x", "property float y", "property float z"]


def ply_header(encoding, *elements):
    return lines("ply", f"format {encoding} 1.0", "comment seed", *elements, "end_header")


def ply():
    vertices = ["element vertex 8", *PLY_ASCII]
    faces = ["element face 6", "property list uchar int vertex_indices"]
    text = [f"{x} {y} {z}" for x, y, z in CUBE] + ["4 " + " ".join(map(str, q)) for q in QUADS]
    yield "ascii", ply_header("ascii", *vertices, *faces) + lines(*text)
    for name, order in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(order + "3f", *p) for p in CUBE) + b"".join(struct.pack(order + "B4i", 4, *q) for q in QUADS)
        yield name, ply_header(f"binary_{name}_endian", *vertices, *faces) + body
    strips = ["element vertex 4", *PLY_ASCII, "element tristrips 1", "property list int int vertex_indices"]
    body = b"".join(struct.pack("<3f", *p) for p in CUBE[:4]) + struct.pack("<9i", 8, 0, 1, 2, 3, -1, 1, 2, 3)
    yield "strips", ply_header("binary_little_endian", *strips) + body
    odd = ["obj_info none", "element other 1", "property list short double values", "property char c", "element vertex 3",
           "property double x", "property short y", "property uint8 red", "property double z", "element face 1",
           "property uchar flags", "property list ushort uint8 vertex_index"]
    body = struct.pack("<h2db", 2, 1, 2, 7)
    body += b"".join(struct.pack("<dhBd", *v) for v in ((0, 0, 1, 0), (1, 0, 2, 0), (0, 1, 3, 1))) + struct.pack("<BH3B", 0, 3, 0, 1, 2)
    yield "types", ply_header("binary_little_endian", *odd) + body


def stl():
    facets = []
    for t in TRIANGLES[:4]:
        facets += ["facet normal 0 0 1", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in (CUBE[i] for i in t)), "endloop", "endfacet"]
    yield "text", lines("solid cube", *facets, "endsolid cube")
    yield "several", lines("solid", *facets[:7], "endsolid", "SOLID b", *facets[7:14], "endsolid b")
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(c for i in t for c in CUBE[i]), 0) for t in TRIANGLES)
    yield "binary", b"solid or not".ljust(80, b" ") + struct.pack("<I", len(TRIANGLES)) + body


def gltf_document(views, accessors, primitives, **more):
    """JSON of one mesh; views are (bytes, more keys), all in buffer 0, which is returned too."""
    data, described = b"", []
    for view, keys in views:
        data += b"\0" * (-len(data) % 4)
        described.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(view), **keys})
        data += view
    document = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data)}], "bufferViews": described,
                "accessors": accessors, "meshes": [{"name": "m", "primitives": primitives}], **more}
    return document, data


def embedded(document, data):
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(document, separators=(",", ":")).encode()


def glb(document, data):
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gltf():
    positions = b"".join(struct.pack("<3f", *p) for p in CUBE)
    indices = b"".join(struct.pack("<3H", *t) for t in TRIANGLES)
    accessors = [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8},
                 {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 36}]
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    nodes = {"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [
        {"mesh": 0, "children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]},
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "scale": [1, -1, 2]}]}
    plain = [(positions, {}), (indices, {})], accessors, [primitive]
    yield "json", embedded(*gltf_document(*plain))
    yield "glb", glb(*gltf_document(*plain))
    yield "nodes", glb(*gltf_document(*plain, **nodes))
    interleaved = b"".join(struct.pack("<3hhI", x * 100, y * 100, z * 100, 0, 7) for x, y, z in CUBE)
    quantized = [{"bufferView": 0, "byteOffset": 0, "componentType": 5122, "normalized": True, "type": "VEC3", "count": 8},
                 {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 8}]
    yield "quantized", glb(*gltf_document(
        [(interleaved, {"byteStride": 12}), (bytes(range(8)), {})], quantized, [{**primitive, "mode": 5}, {**primitive, "mode": 6}],
        extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"]))
    sparse = {"count": 2, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}
    yield "sparse", glb(*gltf_document(
        [(positions[12:36], {}), (b"\1\2", {})], [{"componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse}],
        [{"attributes": {"POSITION": 0}, "material": 0, "targets": []}], materials=[{"alphaMode": "MASK"}]))
    yield "left-out", glb(*gltf_document(
        *plain[:2], [{**primitive, "material": 0}, primitive, {**primitive, "mode": 1}, {"attributes": {}}],
        materials=[{"alphaMode": "BLEND"}], skins=[{"joints": [0]}], **nodes))


def bake():
    """Bytes of any kind: each is some tiny mesh."""
    for i in range(24):
        yield f"{i:02}", hashlib.shake_256(f"tiny mesh {i}".encode()).digest(80 + 10 * i)


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).parent / "seeds"
    for make in (obj, off, ply, stl, gltf, bake):
        target = folder / make.__name__
        target.mkdir(parents=True, exist_ok=True)
        for name, content in make():
            (target / name).write_bytes(content)


if __name__ == "__main__":
    main()
