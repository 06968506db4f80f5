"""Small assets, one of which names another file."""
import json
import struct

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def write_bin(folder, height=1.0):
    """Three triangles of a tent."""
    a, b, c, top = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, height)
    corners = [a, b, top, b, c, top, c, a, top]
    (folder / "two.bin").write_bytes(b"".join(struct.pack("<3f", *corner) for corner in corners))


def write_assets(folder):
    (folder / "one.obj").write_text(TETRAHEDRON)
    write_bin(folder)
    (folder / "two.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "two.bin", "byteLength": 108}],
        "bufferViews": [{"buffer": 0, "byteLength": 108}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 9]}],
        "meshes": [{"name": "tent", "primitives": [{"attributes": {"POSITION": 0}}]}]}))
