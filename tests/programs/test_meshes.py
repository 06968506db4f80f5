"""The same mesh files are taken in the same way by vc-bake, vc-verify, vc-render and vc-bench, with the same notes."""
import base64
import json
import struct
import unittest

from case import Case

FACES = (0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3)
BOX = [(float(x), float(y), float(z)) for x in (0, 1) for y in (0, 1) for z in (0, 2)]
LINE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)]
DRAW = ("--size", "24x16", "--pixel-samples", "1", "--light-samples", "4")
BAKE = ("--depth", "2", "--audit", "9000")


def moved(points, x=0, y=0, z=0):
    return [(a + x, b + y, c + z) for a, b, c in points]


def obj(points, far=(0, 0, 0)):
    """A box in OBJ, its coordinates in decimals."""
    lines = ["v " + " ".join(f"{c + f:.3f}" for c, f in zip(p, far)) for p in points]
    return "\n".join(lines + ["f " + " ".join(str(i + 1) for i in FACES[k:k + 3]) for k in range(0, 36, 3)]) + "\n"


class Gltf:
    """A .gltf that holds its bytes; add() makes a mesh of primitives, each (points, indices, alpha mode)."""

    def __init__(self):
        self.data = b""
        self.document = {"asset": {"version": "2.0"}, "buffers": [{}], "bufferViews": [], "accessors": [], "meshes": [],
                         "materials": [{"alphaMode": mode} for mode in ("OPAQUE", "MASK")]}

    def accessor(self, data, **kind):
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        self.document["accessors"].append({"bufferView": len(self.document["bufferViews"]) - 1, **kind})
        return len(self.document["accessors"]) - 1

    def add(self, name, *primitives):
        made = []
        for points, indices, mode in primitives:
            position = self.accessor(b"".join(struct.pack("<3f", *p) for p in points), componentType=5126, count=len(points), type="VEC3")
            index = self.accessor(struct.pack(f"<{len(indices)}I", *indices), componentType=5125, count=len(indices), type="SCALAR")
            made.append({"attributes": {"POSITION": position}, "indices": index, "material": int(mode == "MASK")})
        self.document["meshes"].append({"name": name, "primitives": made})
        return self

    def text(self, nodes=None, roots=None):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.document["buffers"] = [{"uri": uri, "byteLength": len(self.data)}]
        if nodes is not None:
            self.document["nodes"] = nodes
            self.document["scenes"] = [{"nodes": roots if roots is not None else list(range(len(nodes)))}]
        return json.dumps(self.document)


class Programs(Case):
    def bake(self, mesh, *options, code=0):
        return self.run_program("vc-bake", mesh, *BAKE, *options, code=code)

    def draw(self, *arguments, code=0):
        return self.run_program("vc-render", *arguments, *DRAW, cwd=self.folder, code=code)

    def figures(self, *arguments):
        return json.loads(self.draw(*arguments, "--format", "json").stdout)

    def verify(self, mesh, *options):
        return self.run_program("vc-verify", f"{mesh}.vcd", "--against", mesh, "--lines", "90", *options)

    def measure(self, mesh, *options):
        return self.run_program("vc-bench", "segments", f"{mesh}.vcd", mesh, "--points", "2", "--repetitions", "1", *options)

    def objects(self, sidecar):
        return json.loads(self.run_program("vc-info", sidecar, "--format", "json").stdout)["files"][0]["objects"]

    def notes(self, done):
        return [line for line in done.stderr.splitlines() if line.startswith("note: ")]


class Meshes(Programs):
    def test_a_mesh_without_area_is_left_out_by_all_with_the_same_note(self):
        mesh = self.mesh("a.gltf", Gltf().add("box", (BOX, FACES, "OPAQUE")).add("line", (LINE, (0, 1, 2), "OPAQUE")).text([{"mesh": 0}]))
        baked = self.notes(self.bake(mesh))
        self.assertEqual(len(baked), 1)
        self.assertRegex(baked[0], r'note: .*a\.gltf: mesh 1 "line": no triangle with an area .*; left out')
        for done in (self.draw(mesh), self.verify(mesh), self.measure(mesh), self.bake(mesh, "--plan"),
                     self.run_program("vc-bench", "bake-rate", mesh, "--cells", "2", "--depth", "3", "--repetitions", "1")):
            self.assertEqual(self.notes(done), baked)
        for done in (self.draw(mesh, "-q"), self.verify(mesh, "-q"), self.measure(mesh, "-q")):
            self.assertEqual(done.stderr, "")
        self.assertEqual(json.loads(self.verify(mesh, "--format", "json").stdout)["files"][0]["notes"], [n[6:] for n in baked])

    def test_a_file_of_nothing_but_such_meshes_is_refused_by_all(self):
        mesh = self.mesh("a.gltf", Gltf().add("one", (LINE, (0, 1, 2), "OPAQUE")).add("two", (LINE, (0, 2, 1), "OPAQUE")).text())
        for done in (self.bake(mesh, code=3), self.draw(mesh, code=3), self.bake(mesh, "--plan", code=3)):
            self.assertIn('a.gltf: mesh 1 "two": no triangle with an area', done.stderr)

    def test_a_placed_mesh_without_area_leaves_the_others_where_they_stand(self):
        gltf = Gltf().add("line", (LINE, (0, 1, 2), "OPAQUE")).add("box", (BOX, FACES, "OPAQUE"))
        mesh = self.mesh("a.gltf", gltf.text([{"mesh": 0}, {"mesh": 1}, {"mesh": 1, "translation": [3, 0, 0]}]))
        report = self.figures(mesh, "--shadows", "bvh")
        self.assertEqual((report["instances"], report["triangles"]), (2, 12))

    def test_parts_that_were_baked_as_opaque_are_drawn_too(self):
        mixed = Gltf().add("tree", (BOX, FACES, "OPAQUE"), (moved(BOX, 2), FACES, "MASK")).text()
        masked = Gltf().add("leaf", (BOX, FACES, "MASK")).text()
        for text, triangles in ((mixed, 24), (masked, 12)):
            mesh = self.mesh("a.gltf", text)
            self.bake(mesh, "--all-as-opaque")
            for shadows in ("vcd", "bvh", "both"):
                self.assertEqual(self.figures(mesh, "--shadows", shadows)["triangles"], triangles)
            self.verify(mesh)
            self.measure(mesh)
            (self.folder / "a.gltf.vcd").rename(self.folder / "elsewhere.vcd")
            self.assertEqual(self.figures(mesh, "--sidecar", self.folder / "elsewhere.vcd")["triangles"], triangles)
            self.assertEqual(self.figures(mesh, "--all-as-opaque", "--shadows", "bvh")["triangles"], triangles)
        self.draw(mesh, code=3)  # nothing says that its leaf is opaque

    def test_each_mesh_is_read_as_its_own_sidecar_says(self):
        mixed = Gltf().add("tree", (BOX, FACES, "OPAQUE"), (moved(BOX, 2), FACES, "MASK")).text()
        whole, trunk = self.mesh("whole.gltf", mixed), self.mesh("trunk.gltf", mixed)
        self.bake(whole, "--all-as-opaque")
        self.bake(trunk)
        self.assertEqual(self.figures(whole, trunk)["triangles"], 36)
        # Names do not decide: the geometry does.
        for name in ("whole", "trunk"):
            (self.folder / f"{name}.gltf.vcd").rename(self.folder / f"{name}.vcd")
            (self.folder / f"{name}.gltf").rename(self.folder / f"{name}-renamed.gltf")
        sidecars = ("--sidecar", self.folder / "trunk.vcd", "--sidecar", self.folder / "whole.vcd")
        self.assertEqual(self.figures(self.folder / "whole-renamed.gltf", *sidecars)["triangles"], 12)
        self.assertEqual(self.figures(self.folder / "whole-renamed.gltf", *sidecars[2:])["triangles"], 24)
        done = self.draw(self.folder / "trunk-renamed.gltf", *sidecars[:2], "--all-as-opaque")
        self.assertIn("read without the parts that are not opaque, as its sidecar was baked", done.stderr)

    def test_what_is_left_out_or_shifted_is_in_every_record(self):
        mixed = Gltf().add("tree", (BOX, FACES, "OPAQUE"), (moved(BOX, 2), FACES, "MASK")).add("stone", (BOX, FACES, "OPAQUE"))
        mesh, cache = self.mesh("a.gltf", mixed.text()), self.folder / "cache"
        expected = [(True, [1, 2, 0.5]), (False, [1, 2, 0.5])]
        wanted = ("--shift", "1,2,0.5", "--cache", cache)
        for more in ((), (), ("--update", "--embed-geometry")):  # baked, out of the cache, baked
            self.bake(mesh, *wanted, *more)
            self.assertEqual([(o["parts_left_out"], o["shift"]) for o in self.objects(f"{mesh}.vcd")], expected)
        # The same geometry without either, out of the same cache.
        plain = self.mesh("b.gltf", Gltf().add("tree", (moved(BOX, -1, -2, -0.5), FACES, "OPAQUE")).text())
        report = json.loads(self.bake(plain, "--cache", cache, "--format", "json").stdout)
        self.assertEqual(report["totals"]["objects_reused"], 1)
        self.assertEqual([(o["parts_left_out"], o["shift"]) for o in self.objects(f"{plain}.vcd")], [(False, [0, 0, 0])])
        self.run_program("vc-info", f"{mesh}.vcd", "--repack", self.folder / "c.vcd")
        self.assertEqual(self.objects(self.folder / "c.vcd"), self.objects(f"{mesh}.vcd"))
        self.assertIn("shift     (1, 2, 0.5)", self.run_program("vc-info", f"{mesh}.vcd").stdout)

    def test_what_was_left_out_is_told_by_its_mesh(self):
        mixed = Gltf().add("stone", (BOX, FACES, "OPAQUE")).add("tree", (BOX, FACES, "OPAQUE"), (moved(BOX, 2), FACES, "MASK"))
        self.bake(self.mesh("a.gltf", mixed.text()))
        sidecar = json.loads(self.run_program("vc-info", self.folder / "a.gltf.vcd", "--format", "json").stdout)["files"][0]
        self.assertEqual(sidecar["provenance"]["left-out"], "1 not-opaque=1 deforming=0\n")
        self.assertIn('"left-out": "1 not-opaque=1', self.run_program("vc-info", self.folder / "a.gltf.vcd").stdout)

    def test_a_shifted_mesh_is_read_shifted_by_all(self):
        far = (5654321.12, 412345.67, 100)
        mesh = self.mesh("far.obj", obj(BOX, far))
        self.assertIn("--shift", self.bake(mesh, code=5).stderr)
        self.bake(mesh, "--shift", "5654321.12,412345.67,100")
        self.verify(mesh)
        self.measure(mesh)
        done = self.draw(mesh, "--shadows", "both", "--views", "difference")
        self.assertEqual(done.stderr, "")
        for sidecar in ("far.obj.vcd", "renamed.vcd"):
            (self.folder / "far.obj.vcd").rename(self.folder / sidecar)
            self.run_program("vc-verify", self.folder / sidecar, "--against-library", self.folder, "--lines", "90")
        self.draw(mesh, code=5)
        self.draw(mesh, "--shift", "5654321.12,412345.67,100")
        self.draw(mesh, "--allow-rounding")

    def test_a_subdivided_mesh_is_subdivided_by_all(self):
        mesh = self.mesh("box.obj", obj(BOX))
        self.bake(mesh, "--subdivide", "2")
        self.assertIn("192 triangles", self.run_program("vc-info", f"{mesh}.vcd").stdout)
        self.verify(mesh)
        self.run_program("vc-verify", self.folder, "--against-library", self.folder, "--lines", "90")
        self.assertEqual(self.draw(mesh, "--shadows", "both", "--views", "difference").stderr, "")
        self.assertIn("read with --subdivide 2, as its sidecar was baked", self.draw(mesh, "--subdivide", "1").stderr)
        made = self.run_program("vc-bake", mesh, *BAKE, "--subdivide", "2", "--update", "-v")
        self.assertNotIn("triangles", made.stdout)
        for other in ((), ("--subdivide", "1")):
            stale = self.run_program("vc-bake", mesh, *BAKE, *other, "--update", "--dry-run")
            self.assertIn("made with other settings", stale.stdout)
        # What vc-scene writes has the same geometry.
        self.run_program("vc-scene", mesh, "--subdivide", "2", "--up", "z", "-q", "-o", self.folder / "box.glb")
        self.run_program("vc-verify", f"{mesh}.vcd", "--against", self.folder / "box.glb", "--lines", "90")
        self.draw(self.folder / "box.glb", "--sidecar", f"{mesh}.vcd")
        (self.folder / "library.json").write_text(json.dumps(
            {"vcd_manifest": 1, "assets": [{"input": "box.obj", "settings": {"subdivide": 2}}]}))
        done = self.run_program("vc-bake", "--manifest", self.folder / "library.json", *BAKE, "--update", "--dry-run")
        self.assertIn("nothing to do", done.stdout)
        mesh.write_text(obj(BOX) + "f 1 2 7\n")
        self.assertIn("box.obj: mesh 0 \"box\" cannot be subdivided: more than two triangles share the edge from (0, 0, 0)",
                      self.bake(mesh, "--subdivide", "1", code=5).stderr)
        self.bake(mesh, "--subdivide", "7", code=1)
        two = self.mesh("two.gltf", Gltf().add("a", (BOX, FACES, "OPAQUE")).add("b", (BOX, FACES, "OPAQUE")).text())
        self.assertIn("holds 2 meshes", self.run_program("vc-scene", two, "-o", self.folder / "two.glb", code=1).stderr)
        self.run_program("vc-scene", "box", "-o", self.folder / "two.glb", code=1)

    def test_a_library_is_verified_with_what_each_sidecar_says(self):
        lib = self.folder / "lib"
        lib.mkdir()
        far = (5654321.12, 412345.67, 100)
        for name, width, options in (("shifted.obj", 4, ("--shift", "5654321.12,412345.67,100")),
                                     ("other.obj", 2, ("--shift", "5654000,412000,0")), ("rounded.obj", 3, ("--allow-rounding",))):
            (lib / name).write_text(obj([(x * width, y, z) for x, y, z in BOX], far))
            self.bake(lib / name, *options)
        (lib / "plain.obj").write_text(obj(BOX))
        self.bake(lib / "plain.obj")
        check = ("vc-verify", lib, "--against-library", lib, "--lines", "90", "--format", "json")
        report = json.loads(self.run_program(*check).stdout)
        self.assertEqual([report["totals"][k] for k in ("ok", "missing", "stale", "orphaned", "unusable")], [4, 0, 0, 0, 0])
        (lib / "shifted.obj").write_text(obj(moved(BOX, 0, 0, 1)[:4] + BOX[4:], far))
        report = json.loads(self.run_program(*check, code=9).stdout)
        self.assertEqual([report["totals"][k] for k in ("ok", "missing", "stale", "orphaned")], [3, 1, 1, 0])

    def test_files_outside_are_allowed_by_the_same_option(self):
        (self.folder / "asset").mkdir()
        gltf = Gltf().add("box", (BOX, FACES, "OPAQUE"))
        gltf.text()
        (self.folder / "data.bin").write_bytes(gltf.data)
        gltf.document["buffers"][0]["uri"] = "../data.bin"
        mesh = self.folder / "asset" / "a.gltf"
        mesh.write_text(json.dumps(gltf.document))
        self.bake(mesh, "--allow-outside-files")
        rate = ("vc-bench", "bake-rate", mesh, "--cells", "2", "--depth", "3", "--repetitions", "1")
        for program in (lambda *o, code: self.draw(mesh, *o, code=code), lambda *o, code: self.run_program(*rate, *o, code=code)):
            self.assertIn("data.bin", program(code=5).stderr)
            program("--allow-outside-files", code=0)

    def test_nodes_that_are_not_quite_right_are_drawn_with_a_note(self):
        near = [1, 0, 0, 1e-17, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 0.99999994]
        exact = near[:3] + [0] + near[4:15] + [1]
        box = Gltf().add("box", (BOX, FACES, "OPAQUE"))
        for nodes, roots, note in (([{"mesh": 0, "matrix": near}], None, None),
                                   ([{"mesh": 0, "matrix": exact, "scale": [1, 1, 1]}], None, "both a matrix and a scale"),
                                   ([{"mesh": 0, "rotation": [0, 0, 0, 0]}], None, "no direction"),
                                   ([{"mesh": 0}, {"children": [0]}, {"children": [0]}], [1, 2], "is a child of node 1 and again of node 2"),
                                   ([{"children": [1]}, {"mesh": 0}], [0, 1], "is a root of scene 0 and a child of node 0")):
            done = self.draw(self.mesh("a.gltf", box.text(nodes, roots)), "--shadows", "bvh")
            self.assertEqual([note in line for line in self.notes(done)], [True] if note else [])


class FarAway(Programs):
    """Pictures in which 32-bit floats leave nothing to see, or not what is there."""

    def test_where_all_stands_does_not_matter(self):
        gltf = Gltf().add("box", (BOX, FACES, "OPAQUE")).add("tall", (moved(BOX, z=1), FACES, "OPAQUE"))
        nodes = lambda x: [{"mesh": 0, "translation": [x, 0.5, 0]}, {"mesh": 1, "translation": [x + 2, 0, 0.25]}]
        pictures = []
        for x in (0, 4e6):
            done = self.draw(self.mesh("a.gltf", gltf.text(nodes(x))), "--shadows", "bvh", "-o", "p")
            self.assertEqual(done.stderr, "")
            pictures.append((self.folder / "p-bvh.png").read_bytes())
        self.assertEqual(*pictures)

    def test_coordinates_far_from_the_origin_are_noted_with_the_shift_that_helps(self):
        mesh = self.mesh("far.obj", obj(BOX, (4e6, 5.2e6, 100)))
        done = self.draw(mesh, "--shadows", "bvh", "--allow-rounding")
        self.assertRegex(done.stderr, r"far\.obj: mesh 0 .* units from the origin of its frame, where 32-bit floats are 0\.5 apart: .*--shift 4000000,5200000,101")
        self.assertNotIn("seen in the picture", done.stderr)  # it fills the picture as it would at the origin
        self.assertEqual(self.draw(mesh, "--shadows", "bvh", "--shift", "4000000,5200000,101").stderr, "")

    def test_a_picture_of_nothing_says_why(self):
        near, away = self.mesh("near.obj", obj(BOX)), self.mesh("away.obj", obj(BOX, (0, 1e5, 0)))
        done = self.draw(near, away, "--shadows", "bvh")
        self.assertIn("nothing of it is seen in the picture: its meshes stand far apart", done.stderr)

    def test_sizes_that_cannot_be_traced_are_refused_or_left_out(self):
        near = self.mesh("near.obj", obj(BOX))
        for size in (1e-30, 1e-14, 1e13, 1e25):
            text = "\n".join("v " + " ".join(f"{c * size:.9g}" for c in p) for p in BOX) + "\n" + obj(BOX)[obj(BOX).index("f "):]
            mesh = self.mesh("odd.obj", text)
            self.assertIn("cannot be drawn", self.draw(mesh, "--shadows", "bvh", code=5).stderr)
            report = self.draw(near, mesh, "--shadows", "bvh", "--format", "json")
            self.assertIn("cannot be drawn", report.stderr)
            self.assertEqual(json.loads(report.stdout)["triangles"], 12)


if __name__ == "__main__":
    unittest.main()
