"""vc-info --page and --picture: what is in them, and the page in headless Chromium.

The browser comes with `tools/install_dependencies.sh lab`, which CI installs anyway, for the report of vc-bench."""
import base64
import functools
import json
import math
import os
import pathlib
import random
import re
import struct
import subprocess
import sys
import unittest
import zlib

from case import GOLDEN, Case

PROJECT = pathlib.Path(__file__).resolve().parents[2]
TEST_BIN = pathlib.Path(os.environ["VCD_TEST_BIN"])
sys.path[:0] = [str(PROJECT / "spec" / "reader"), str(PROJECT / "tests" / "report")]
import vcd_reader

try:
    import page_browser
except ImportError:
    page_browser = None
BROWSER = page_browser is not None and page_browser.available() and "VCD_SANITIZED" not in os.environ
WHY_BROWSER = "needs chromium, chromium-driver, python3-selenium; tools/install_dependencies.sh lab installs them"
DIRECTIONS = 48


def sphere(rings=10, around=18, hole=False):
    """A closed mesh as OBJ; with a hole: without the cap at one pole."""
    points = [(0, 1, 0)] + [(math.sin(math.pi * r / rings) * math.cos(math.tau * k / around), math.cos(math.pi * r / rings),
                             math.sin(math.pi * r / rings) * math.sin(math.tau * k / around))
                            for r in range(1, rings) for k in range(around)] + [(0, -1, 0)]
    faces = []
    for k in range(around):
        n = (k + 1) % around
        if not hole:
            faces.append((1, 2 + n, 2 + k))
        for r in range(rings - 2):
            a, b = 2 + r * around, 2 + (r + 1) * around
            faces += [(a + k, a + n, b + n), (a + k, b + n, b + k)]
        faces.append((len(points), 2 + (rings - 2) * around + k, 2 + (rings - 2) * around + n))
    return "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces)


def data_of(page):
    """What the page holds: its JSON, and a function from [first byte, bytes] to bytes."""
    text = page.read_text()
    found = lambda name: re.search(f'id="{name}">(.*?)</script>', text, re.S)[1]
    arrays = zlib.decompress(base64.b64decode(found("arrays"), validate=True))
    return json.loads(found("data")), lambda place: arrays[place[0]:place[0] + place[1]]


def line_through(point, direction):
    """A segment that holds the whole way of a line through a box that is about 1 wide."""
    start = [p - 10 * d for p, d in zip(point, direction)]
    return struct.pack("<8f", *start, 0, *[20 * d for d in direction], 1)


class PageCase(Case):
    baked = {}  # sidecars' bytes, for all tests

    def bake(self, *options, text=None, name="sphere.obj", method="proven"):
        mesh, key = self.mesh(name, text or sphere()), (options, text, name, method)
        sidecar = mesh.with_name(name + ".vcd")
        if key not in self.baked:
            self.run_program("vc-bake", mesh, "-q", "--depth", "3", "--method", method, "--audit", "9000", *options)
            self.baked[key] = sidecar.read_bytes()
        sidecar.write_bytes(self.baked[key])
        return mesh, sidecar

    def page(self, sidecar, *options, name="page.html"):
        self.run_program("vc-info", sidecar, "--page", self.folder / name, "-q", *options)
        return self.folder / name

    def classify(self, sidecar, segments):
        (self.folder / "segments").write_bytes(segments)
        subprocess.run([TEST_BIN / "classify_file", sidecar, "0", self.folder / "segments", self.folder / "answers"], check=True)
        return (self.folder / "answers").read_bytes()


class Page(PageCase):
    def test_loads_nothing_and_keeps_the_licence(self):
        text = self.page(self.bake()[1]).read_text()
        self.assertNotIn("{{", re.sub(r"<script.*?</script>", "", text, flags=re.S))
        self.assertEqual(re.findall(r'<(?:link|img|iframe)\b|(?:src|href)="', re.sub(r"<script.*?</script>", "", text, flags=re.S)), [])
        self.assertNotRegex(text, "<script[^>]*src")
        self.assertIn("Copyright © 2010-2019 three.js authors", text)
        self.assertIn("The above copyright notice and this permission notice shall be included", text)
        cache = (pathlib.Path(os.environ["VCD_BUILD"]) / "CMakeCache.txt").read_text()
        for name in ("VCD_THREE_JS", "VCD_ORBIT_CONTROLS_JS"):
            self.assertIn(pathlib.Path(re.search(f"^{name}:.*=(.*)$", cache, re.M)[1]).read_text(), text)

    def test_is_the_same_each_time(self):
        _, sidecar = self.bake("--horizons")
        self.assertEqual(self.page(sidecar).read_bytes(), self.page(sidecar, name="again.html").read_bytes())

    def test_holds_what_vc_info_prints_and_the_tree(self):
        _, sidecar = self.bake()
        data, array = data_of(self.page(sidecar))
        printed = self.run_program("vc-info", sidecar).stdout
        described = json.loads(self.run_program("vc-info", sidecar, "--format", "json").stdout)["files"][0]
        for line in data["objects"][0]["facts"].splitlines():
            self.assertTrue(line.startswith("  surface") or line in printed, line)
        self.assertEqual(data["provenance"], described["provenance"])
        self.assertEqual((data["file"], data["bytes"]), ("sphere.obj.vcd", sidecar.stat().st_size))
        file = vcd_reader.VcdFile(sidecar.read_bytes())
        self.assertEqual(array(data["objects"][0]["tree"]["place"]), file.contents[file.objects[0].tree_section])

    def test_colours_are_what_look_ups_answer(self):
        _, sidecar = self.bake()
        data, array = data_of(self.page(sidecar))
        o = data["objects"][0]
        positions = [p for p in struct.iter_unpack("<3f", array(o["positions"]))]
        triangles = [t for t in struct.iter_unpack("<3I", array(o["indices"]))]
        answered, whys = array(o["answered"]), [array(w) for w in o["why"]]
        self.assertEqual(len(triangles), o["drawn"])
        self.assertGreater(o["drawn"], 4 * o["triangles"])  # cut finer
        self.assertEqual({len(answered), len(array(o["proven"])), *map(len, whys)}, {o["drawn"]})
        self.assertEqual(array(o["proven"]), answered)
        some = random.Random(1).sample(range(o["drawn"]), 60)
        golden = math.pi * (3 - math.sqrt(5))
        segments = b""
        for t in some:
            middle = [sum(positions[corner][a] for corner in triangles[t]) / 3 for a in range(3)]
            for i in range(DIRECTIONS):
                y = (i + 0.5) / DIRECTIONS
                r = math.sqrt(1 - y * y)
                segments += line_through(middle, (r * math.cos(i * golden), y, r * math.sin(i * golden)))
        answers = self.classify(sidecar, segments)
        for k, t in enumerate(some):
            share = sum(a != 2 for a in answers[k * DIRECTIONS:(k + 1) * DIRECTIONS]) / DIRECTIONS
            self.assertAlmostEqual(answered[t] / 255, share, delta=2.1 / DIRECTIONS)  # of lines at the edge of a cell
        self.assertGreater(max(answered) - min(answered), 40)
        for t in range(o["drawn"]):
            self.assertAlmostEqual(sum(w[t] for w in whys), 255 if answered[t] < 255 else 0, delta=3)

    def test_boundary_is_a_reason_where_there_is_one(self):
        share = lambda text: sum((lambda d: d[1](d[0]["objects"][0]["why"][2]))(data_of(self.page(self.bake(text=text)[1]))))
        self.assertEqual(share(sphere()), 0)
        self.assertGreater(share(sphere(hole=True)), 0)

    def test_horizons_of_a_convex_mesh_are_open(self):
        data, array = data_of(self.page(self.bake("--horizons")[1]))
        horizons = array(data["objects"][0]["horizons"])
        self.assertEqual(len(horizons), data["objects"][0]["drawn"])
        self.assertGreater(sum(h == 254 for h in horizons), 0.9 * len(horizons))
        self.assertIsNone(data_of(self.page(self.bake()[1]))[0]["objects"][0]["horizons"])

    def test_mesh_file_stands_in_for_the_hierarchy(self):
        whole = data_of(self.page(self.bake()[1]))
        mesh, sidecar = self.bake("--no-hierarchy")
        said = self.run_program("vc-info", sidecar, "--page", self.folder / "b.html", code=1).stderr
        self.assertIn("sphere.obj.vcd: object 0 ", said)
        self.assertIn("--mesh", said)
        self.assertFalse((self.folder / "b.html").exists())
        bare = data_of(self.page(sidecar, "--mesh", mesh))
        self.assertEqual(bare[0]["objects"][0]["mesh_source"], "the mesh file")
        self.assertEqual(bare[1](bare[0]["objects"][0]["answered"]), whole[1](whole[0]["objects"][0]["answered"]))
        other = self.mesh("other.obj")
        said = self.run_program("vc-info", sidecar, "--page", self.folder / "b.html", "--mesh", other, code=1).stderr
        self.assertIn("other.obj: has no mesh of the geometry of", said)
        self.assertIn("gone.obj", self.run_program("vc-info", sidecar, "--page", self.folder / "b.html", "--mesh", "gone.obj", code=2).stderr)

    def test_names_are_text(self):
        _, sidecar = self.bake(name="a<b>&{{css}}.obj")
        text = self.page(sidecar).read_text()
        self.assertIn("<title>a&lt;b>&amp;{{css}}.obj.vcd</title>", text)
        self.assertNotIn("<", re.search('id="data">(.*?)</script>', text, re.S)[1])
        self.assertEqual(data_of(self.folder / "page.html")[0]["objects"][0]["name"], "a<b>&{{css}}")

    def test_beside_many_sidecars(self):
        (one, first), (two, second) = self.bake(), self.bake(name="two.obj")
        said = self.run_program("vc-info", "--pages", first, second, self.folder / "gone.vcd", code=9)
        self.assertEqual(len(said.stdout.splitlines()), 2)
        self.assertIn("gone.vcd", said.stderr)
        for sidecar in (first, second):
            self.assertEqual(data_of(sidecar.with_name(sidecar.name + ".html"))[0]["file"], sidecar.name)

    def test_refuses(self):
        mesh, sidecar = self.bake()
        for arguments, says in (((sidecar, sidecar, "--page", "p.html"), "one sidecar"), ((mesh, "--picture", "p.png"), "sphere.obj: is no sidecar"),
                                ((sidecar, "--page", sidecar), "named like a mesh or a sidecar"), ((sidecar, "--mesh", mesh), "--page")):
            self.assertIn(says, self.run_program("vc-info", *arguments, code=1).stderr)
        self.assertIn("no/p.png", self.run_program("vc-info", sidecar, "--picture", self.folder / "no/p.png", code=2).stderr)
        self.assertIn("has no objects", self.run_program("vc-info", GOLDEN / "none.vcd", "--page", self.folder / "p.html", code=1).stderr)
        self.assertIn("has no objects", self.run_program("vc-info", GOLDEN / "none.vcd", "--picture", self.folder / "p.png", code=1).stderr)


class Picture(PageCase):
    def test_is_a_png_of_all_objects(self):
        height = {}
        for name in ("example", "several"):
            picture = self.folder / f"{name}.png"
            self.run_program("vc-info", GOLDEN / f"{name}.vcd", "--picture", picture)
            data = picture.read_bytes()
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
            width, height[name] = struct.unpack(">II", data[16:24])
            self.assertEqual(width, 1616)
        self.assertEqual((height["example"] - 88) * len(vcd_reader.VcdFile((GOLDEN / "several.vcd").read_bytes()).objects), height["several"] - 88)

    def test_shares_are_those_of_the_python_script(self):
        built = pathlib.Path(os.environ["VCD_BUILD"]) / "python"
        sys.path[:0] = [str(built), str(PROJECT / "python" / "examples")]
        try:
            import draw_classes
            import numpy
            import vcd
        except ImportError as why:
            self.skipTest(f"the Python module is not built for this interpreter: {why}")
        _, sidecar = self.bake(method="hybrid")
        views = data_of(self.page(sidecar))[0]["objects"][0]["views"]
        self.assertEqual([(v["azimuth"], v["elevation"]) for v in views], list(draw_classes.VIEWS))
        self.assertEqual(data_of(self.folder / "page.html")[0]["class_colours"], draw_classes.COLOURS.tolist())
        trusting, proven = vcd.open(str(sidecar))[0], vcd.open(str(sidecar), proven_only=True)[0]
        for view in views:
            lines = draw_classes.lines_of_view(trusting.record, view["azimuth"], view["elevation"], 224)
            found = draw_classes.classes(trusting, proven, lines)
            shares = numpy.bincount(found, minlength=4) / len(found)
            for ours, theirs in zip(view["shares"], shares):
                self.assertAlmostEqual(ours, theirs, delta=0.002)


@unittest.skipUnless(BROWSER, WHY_BROWSER)
class InBrowser(PageCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = page_browser.Browser("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
        cls.addClassCleanup(cls.browser.close)

    def open(self, page, width=900, height=500):
        self.browser.requests(), self.browser.complaints()
        self.browser.open(page, width, height)
        self.browser.driver.execute_async_script("const done = arguments[0], wait = () => window.page ? done() : setTimeout(wait, 10); wait()")

    def complaints(self):
        return [c["message"] for c in self.browser.complaints() if "GPU stall due to ReadPixels" not in c["message"]]

    def mouse(self, kind, x, y, buttons=0):
        self.browser.command("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left" if kind != "mouseMoved" else "none", buttons=int(buttons), clickCount=1)

    def touch(self, kind, *points):
        self.browser.command("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])

    def drawn(self):
        """Share of the canvas that is not background, and a sum of its colours."""
        return self.browser.ask("""const {renderer, scene, camera} = page.view, gl = renderer.getContext();
            renderer.render(scene, camera);
            const w = gl.drawingBufferWidth, h = gl.drawingBufferHeight, pixels = new Uint8Array(4 * w * h);
            gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
            let drawn = 0, sum = 0;
            for (let i = 0; i < pixels.length; i += 4) drawn += pixels[i + 3] === 255, sum += pixels[i] - pixels[i + 2];
            return [drawn / (w * h), sum];""")

    def reading(self):
        return self.browser.ask("return new Promise(done => requestAnimationFrame(() => setTimeout(() => "
                                "done(document.getElementById('reading').textContent), 30)))")

    def check_pictures(self, page):
        """They have the shares that stand below them."""
        views = data_of(page)[0]["objects"][0]["views"]
        counted = self.browser.ask("""return [...document.querySelectorAll('#views img')].map(image => {
            const canvas = document.createElement('canvas'), n = canvas.width = canvas.height = image.naturalWidth;
            const context = canvas.getContext('2d');
            context.drawImage(image, 0, 0);
            const bytes = context.getImageData(0, 0, n, n).data, counts = [0, 0, 0, 0];
            for (let i = 0; i < bytes.length; i += 4) ++counts[data.class_colours.findIndex(c => c.every((x, k) => x === bytes[i + k]))];
            return counts.map(c => c / (n * n)); })""")
        self.assertEqual(len(counted), 8)
        for view, shares in zip(views, counted):
            for told, share in zip(view["shares"], shares):
                self.assertAlmostEqual(told, share, delta=1e-9)

    def test_draws_tells_and_loads_nothing(self):
        page = self.page(self.bake("--horizons", method="hybrid")[1])
        self.open(page)
        self.check_pictures(page)
        self.assertEqual([u for u in self.browser.requests() if not u.startswith(("data:", "blob:"))], [page.as_uri()])
        share, colours = self.drawn()
        self.assertTrue(0.1 < share < 0.6, share)
        for mode in ("why", "horizons"):
            self.browser.ask("document.querySelector(arguments[0]).click()", f"[data-mode={mode}]")
            other = self.drawn()[1]
            self.assertNotEqual(colours, other)
            colours = other
        self.assertIn("Point at the object", self.reading())
        x, y, width = self.browser.ask("const b = document.getElementById('view').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2, b.width]")
        self.mouse("mouseMoved", x, y)
        told = self.reading()
        self.assertRegex(told, "(Blocked, proven|Unclassified)")
        self.assertRegex(told, r"Cell: . (min|max) \(\d, \d\) to . (min|max) \(\d, \d\), of 8 × 8 squares")
        self.assertRegex(told, r"meets 2 triangles.*Lines through this place: \d")
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, kind == "mousePressed")
        self.mouse("mouseMoved", x - 0.49 * width, y)
        self.assertRegex(self.reading(), "Lines through this place")  # kept
        self.browser.ask("document.querySelector('#reading button').click()")
        self.mouse("mouseMoved", x - 0.48 * width, y)
        self.assertIn("misses the box", self.reading())
        before = self.browser.ask("return page.view.camera.position.toArray()")
        for kind, at in (("mousePressed", x), ("mouseMoved", x + 80), ("mouseReleased", x + 80)):
            self.mouse(kind, at, y, 1)
        self.assertNotEqual(self.browser.ask("return page.view.camera.position.toArray()"), before)
        self.assertEqual(self.browser.ask("document.getElementById('up').click(); return page.view.camera.up.toArray()"), [0, 0, 1])
        self.assertGreater(self.drawn()[0], 0.1)
        self.assertEqual(self.complaints(), [])

    def test_on_a_phone(self):
        self.open(self.page(self.bake()[1]), 390, 844)
        self.browser.command("Emulation.setTouchEmulationEnabled", enabled=True)
        self.assertEqual(self.browser.ask("return document.documentElement.scrollWidth"), 390)
        eye = functools.partial(self.browser.ask, "const c = page.view.camera.position; return [c.length(), c.x / c.length()]")
        distance, side = eye()
        self.touch("touchStart", (200, 300)), self.touch("touchMove", (260, 300)), self.touch("touchEnd")
        turned = eye()
        self.assertGreater(abs(turned[1] - side), 0.05)
        self.assertAlmostEqual(turned[0], distance, delta=1e-3)
        self.touch("touchStart", (180, 300), (220, 300)), self.touch("touchMove", (100, 300), (300, 300)), self.touch("touchEnd")
        self.assertLess(eye()[0], 0.8 * distance)
        self.touch("touchStart", (195, 260)), self.touch("touchEnd")
        self.assertIn("Lines through this place", self.reading())
        self.assertEqual(self.complaints(), [])

    def test_objects_are_chosen(self):
        page = self.folder / "several.html"
        self.run_program("vc-info", GOLDEN / "methods.vcd", "--page", page, "-q")
        self.open(page)
        for i, o in enumerate(data_of(page)[0]["objects"]):
            self.browser.ask("const c = document.getElementById('object'); c.value = arguments[0]; c.dispatchEvent(new Event('change'))", i)
            self.assertIn(o["facts"].splitlines()[0].split(None, 1)[1], self.browser.ask("return document.getElementById('facts').textContent"))
            self.assertGreater(self.drawn()[0], 0.05)
        self.assertEqual(self.complaints(), [])

    def test_looks_up_as_the_runtime_does(self):
        self.open(self.page(self.bake()[1]))
        for depth in range(1, 9):
            path = GOLDEN / f"depth{depth}.vcd"
            file = vcd_reader.VcdFile(path.read_bytes(), checksums=False)
            record, rng = file.objects[0], random.Random(depth)
            extent = [b - a for a, b in zip(record.box_min, record.box_max)]
            lines = []
            while len(lines) < 1000:
                a, b = ([lo + e * rng.random() for lo, e in zip(record.box_min, extent)] for _ in range(2))
                d = [4 * (y - x) for x, y in zip(a, b)]
                if len(lines) % 5 == 0:
                    d[rng.randrange(3)] = 0
                longest = max(abs(x) / e for x, e in zip(d, extent))
                lines.append([x - y * 1.5 / longest for x, y in zip(a, d)] + [y * 3 / longest for y in d])
            answers = self.classify(path, b"".join(struct.pack("<8f", *l[:3], 0, *l[3:], 1) for l in lines))
            pools, top = file.tree(0).pools, min(record.levels - 2, 3)
            tables, at = [[0, top]], -(-(15 * 16 ** top + 1) * 4 // 64) * 64
            for pool in pools[:-1]:
                tables.append([at, pool.bits])
                at += 4 * 16 ** pool.bits * len(pool.blocks)
            o = {"box_min": record.box_min, "box_max": record.box_max, "depth": record.depth,
                 "tree": {"tables": tables, "bricks": at}}
            classes = self.browser.ask("""const [object, tree, lines] = arguments, bytes = Uint8Array.from(atob(tree), c => c.charCodeAt(0));
                return lines.map(l => { const at = locate(object, l.slice(0, 3), l.slice(3)); return at ? classOf(object, bytes, at) : 0; });""",
                o, base64.b64encode(file.contents[record.tree_section]).decode(), lines)
            self.assertEqual(bytes(c if c < 3 else 1 for c in classes), answers, depth)
            self.assertGreater(len(set(answers)), 1)


if __name__ == "__main__":
    unittest.main()
