"""The Python module: bakes from arrays, asks arrays, and refuses what it cannot use in place."""
import ast
import dataclasses
import functools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["VCD_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
sys.path.insert(0, str(PROJECT / "python/examples"))

import numpy as np  # noqa: E402
import vcd  # noqa: E402

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                  [0, 6, 4], [1, 5, 7], [1, 7, 3]])
CLEAR, BLOCKED, UNCLASSIFIED = vcd.Visibility


def ball(n=24):
    """A sphere of radius 1 of small triangles, and its faces."""
    a, b = np.meshgrid(np.arange(n), np.arange(n // 2 + 1), indexing="ij")
    x, y = a * 2 * np.pi / n, b * 2 * np.pi / n
    positions = np.stack([np.cos(x) * np.sin(y), np.sin(x) * np.sin(y), np.cos(y)], axis=-1).astype(np.float32)
    at = lambda i, j: ((a[:, :-1] + i) % n * (n // 2 + 1) + b[:, :-1] + j).ravel()
    corners = [(at(0, 0), at(1, 0), at(1, 1)), (at(0, 0), at(1, 1), at(0, 1))]
    return positions.reshape(-1, 3), np.concatenate([np.stack(c, axis=-1) for c in corners])


def random_segments(count, seed=0):
    random = np.random.default_rng(seed)
    ends = random.uniform(-2, 2, (2, count, 3))
    return vcd.segments(ends[0], ends[1] - ends[0])


def hits_ball(segments):
    """Whether they meet the unit sphere's surface, and whether that is beyond doubt for one of triangles."""
    o, d = segments[:, :3].astype(float), segments[:, 4:7].astype(float)
    t = np.clip(-(o * d).sum(1) / (d * d).sum(1), 0, 1)
    nearest = np.linalg.norm(o + t[:, None] * d, axis=1)
    inside = np.maximum(np.linalg.norm(o, axis=1), np.linalg.norm(o + d, axis=1))
    farthest = inside
    return (nearest < 1) & (farthest > 1), (abs(nearest - 1) > 0.03) & (abs(farthest - 1) > 0.03)


@functools.lru_cache
def baked_ball():
    mesh = vcd.prepare(*ball(), name="ball")
    baked = vcd.bake(mesh, depth=4, audit_lines=20_000)
    return mesh, baked, vcd.sidecar_bytes([baked], provenance={"by": "test"})


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mesh, cls.baked, cls.bytes = baked_ball()
        cls.ball = vcd.open(cls.bytes)[0]

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Baking(Case):
    def test_mesh_is_welded_and_read_only(self):
        mesh = vcd.prepare(np.concatenate([CUBE, CUBE]), np.concatenate([FACES, FACES + 8]), name="twice")
        self.assertEqual(mesh.name, "twice")
        self.assertEqual((mesh.positions.shape, mesh.triangles.shape), ((8, 3), (12, 3)))
        np.testing.assert_array_equal(mesh.positions, np.unique(CUBE, axis=0))
        with self.assertRaises(ValueError):
            mesh.positions[0, 0] = 5
        self.assertLess(mesh.box_min[0], -1)

    def test_views_keep_the_mesh(self):
        positions = vcd.prepare(CUBE, FACES).positions
        vcd.prepare(CUBE * 3, FACES)
        np.testing.assert_array_equal(positions, np.unique(CUBE, axis=0))

    def test_geometry_is_the_same_in_every_type_order_and_stride(self):
        expected = vcd.prepare(CUBE, FACES).geometry_hash
        self.assertEqual(len(expected), 16)
        for integer in (np.uint16, np.int32, np.uint32, np.int64):
            self.assertEqual(vcd.prepare(CUBE, FACES.astype(integer)).geometry_hash, expected)
        wide = np.zeros((16, 5), np.float32)
        wide[::2, 1:4] = CUBE
        self.assertEqual(vcd.prepare(wide[::2, 1:4], FACES[::-1, ::-1]).geometry_hash, expected)
        self.assertEqual(vcd.geometry_hash(CUBE, FACES[::-1, ::-1]), expected)
        self.assertNotEqual(vcd.prepare(CUBE * 2, FACES).geometry_hash, expected)

    def test_records_are_dataclasses(self):
        record = self.baked.record
        self.assertEqual((record.name, record.method, record.depth), ("ball", "hybrid", 4))
        self.assertEqual(record.geometry_hash, self.mesh.geometry_hash)
        self.assertEqual(record.triangle_count, len(self.mesh.triangles))
        self.assertEqual(record.clear_cells + record.blocked_cells + record.unclassified_cells +
                         record.statistical_cells, 15 * 16 ** 4)
        with self.assertRaises(dataclasses.FrozenInstanceError):
            record.depth = 5
        self.assertEqual(self.ball.record, record)

    def test_plan_and_audit(self):
        self.assertIsNone(self.baked.plan)
        self.assertEqual(sum(c.segments for c in self.baked.audit.counts), 20_000)
        self.assertEqual(sum(c.wrong_proven for c in self.baked.audit.counts), 0)
        planned = vcd.bake(self.mesh, budget_bytes=100_000)
        self.assertEqual(planned.plan.depth, planned.record.depth)
        self.assertIsNone(planned.audit)

    def test_equal_bakes_give_equal_bytes(self):
        again = vcd.bake(self.mesh, depth=4, audit_lines=20_000, threads=1, progress=lambda *done: None)
        np.testing.assert_array_equal(vcd.sidecar_bytes([again], provenance={"by": "test"}), self.bytes)

    def test_progress_is_told_in_the_callers_thread(self):
        told = []
        vcd.bake(self.mesh, depth=4, method="proven",
                 progress=lambda done, share: told.append((done, share, threading.get_ident())))
        self.assertTrue(told)
        self.assertEqual({thread for _, _, thread in told}, {threading.get_ident()})
        for done, share, _ in told:
            self.assertIn(done, ("hierarchy", "horizons", "trace", "plan", "divide", "classify", "demote", "clearances", "audit"))
            self.assertTrue(0 <= share <= 1)

    def test_what_progress_raises_ends_the_bake(self):
        class Cancelled(Exception):
            pass

        def cancel(done, share):
            if done == "classify":
                raise Cancelled

        begun = time.monotonic()
        with self.assertRaises(Cancelled):  # alone it would take minutes
            vcd.bake(vcd.prepare(*ball(400)), depth=8, method="proven", progress=cancel)
        self.assertLess(time.monotonic() - begun, 20)

    def test_errors_have_the_librarys_message(self):
        with self.assertRaisesRegex(vcd.InvalidFile, "no triangle with an area"):
            vcd.prepare(CUBE, np.array([[0, 0, 1]]))
        with self.assertRaisesRegex(vcd.UsageError, "not finite"):
            vcd.prepare(np.full((3, 3), np.nan, np.float32), np.array([[0, 1, 2]]))
        with self.assertRaisesRegex(vcd.UsageError, "depth"):
            vcd.bake(self.mesh, depth=9)
        with self.assertRaisesRegex(vcd.FileError, "nowhere"):
            vcd.write(self.folder / "nowhere/a.vcd", [self.baked])
        self.assertTrue(issubclass(vcd.FileError, OSError) and issubclass(vcd.UsageError, ValueError))

    def test_arrays_that_do_not_fit_are_refused(self):
        for positions, triangles, error, message in (
                (CUBE.astype(float), FACES, TypeError, r"positions: .*float32.*\(n, 3\); got float64.*\(8, 3\)"),
                (CUBE.ravel(), FACES, ValueError, r"positions: .*got float32 array of shape \(24,\)"),
                (CUBE, FACES.astype(float), TypeError, "triangles: .*got float64"),
                (CUBE, FACES.ravel(), ValueError, r"triangles: .*\(m, 3\); got int64 array of shape \(36,\)"),
                (CUBE, FACES - 1, ValueError, "row 0 has the index -1"),
                (CUBE[:7], FACES, ValueError, "row 2 has the index 7, and there are 7 positions")):
            with self.subTest(message), self.assertRaisesRegex(error, message):
                vcd.prepare(positions, triangles)
        with self.assertRaisesRegex(ValueError, '"hybrid", "proven", "sampled", "none"; got "fast"'):
            vcd.bake(self.mesh, method="fast")


class Files(Case):
    def test_write_and_open(self):
        path = self.folder / "ball.vcd"
        size = vcd.write(path, [self.baked], provenance={"by": "test"})
        self.assertEqual(path.read_bytes(), self.bytes.tobytes())
        self.assertEqual(size, len(self.bytes))
        sidecar = vcd.open(path, copy=True, check="canonical", look_up="always", kernel="scalar")
        self.assertEqual((len(sidecar), sidecar.kernel, sidecar.provenance), (1, "scalar", {"by": "test"}))
        self.assertEqual(sidecar["ball"].name, "ball")
        self.assertEqual(sidecar[-1].name, "ball")
        self.assertEqual(sidecar.find(self.mesh.geometry_hash).name, "ball")
        self.assertIsNone(sidecar.find(bytes(16)))
        with self.assertRaises(KeyError):
            sidecar["cube"]
        with self.assertRaises(IndexError):
            sidecar[1]
        self.assertEqual([each.name for each in sidecar], ["ball"])

    def test_compressed_files_answer_the_same(self):
        small = vcd.sidecar_bytes([self.baked], compress=True)
        self.assertLess(len(small), len(self.bytes))
        segments = random_segments(1000)
        np.testing.assert_array_equal(vcd.open(small)[0].classify(segments), self.ball.classify(segments))

    def test_an_object_keeps_its_buffer(self):
        one = vcd.open(vcd.sidecar_bytes([self.baked]))[0]
        filler = [np.full(len(self.bytes), 255, np.uint8) for _ in range(8)]
        segments = random_segments(1000)
        np.testing.assert_array_equal(one.classify(segments), self.ball.classify(segments))
        del filler

    def test_bad_files_are_refused(self):
        with self.assertRaisesRegex(vcd.FileError, "missing.vcd"):
            vcd.open(self.folder / "missing.vcd")
        damaged = self.bytes.copy()
        damaged[len(damaged) // 2] ^= 1
        with self.assertRaises(vcd.InvalidFile):
            vcd.open(damaged)
        with self.assertRaisesRegex(ValueError, 'check: one of "checksums", "bounds", "canonical"; got "none"'):
            vcd.open(self.bytes, check="none")
        with self.assertRaisesRegex(ValueError, "aligned to 8"):
            vcd.open(np.zeros(100, np.uint8)[1:])
        with self.assertRaises(vcd.Error):
            vcd.open(self.bytes, kernel="abacus")

    def test_verify(self):
        found = vcd.verify(self.bytes, [self.mesh], lines=20_000)
        self.assertTrue(found.ok, found.issues)
        self.assertEqual(sum(c.segments for c in found.audits[0].counts), 20_000)
        stale = vcd.verify(self.bytes, [vcd.prepare(CUBE, FACES)], lines=100)
        self.assertEqual((stale.ok, [issue.id for issue in stale.issues]), (False, ["stale"]))
        path = self.folder / "ball.vcd"
        path.write_bytes(self.bytes[:-1])
        self.assertFalse(vcd.verify(path, [self.mesh], lines=100).ok)


class Asking(Case):
    def test_answers_are_right(self):
        segments = random_segments(20_000)
        hit, certain = hits_ball(segments)
        self.assertGreater(certain.mean(), 0.8)
        answers = self.ball.classify(segments)
        self.assertEqual((answers.dtype, answers.shape), (np.uint8, (20_000,)))
        self.assertTrue((answers[hit & certain] != CLEAR).all())
        self.assertTrue((answers[~hit & certain] != BLOCKED).all())
        self.assertEqual(set(answers), set(vcd.Visibility))
        dark = self.ball.occluded(segments)
        self.assertEqual((dark.dtype, dark.shape), (np.bool_, (20_000,)))
        np.testing.assert_array_equal(dark[certain], hit[certain])
        np.testing.assert_array_equal(dark[answers != UNCLASSIFIED], answers[answers != UNCLASSIFIED] == BLOCKED)
        for count in (0, 1, 7, 63, 64, 65):
            np.testing.assert_array_equal(self.ball.occluded(segments[:count], start="inside"), dark[:count])

    def test_answers_are_those_of_cpp(self):
        segments = random_segments(10_000)
        vcd.write(self.folder / "ball.vcd", [self.baked])
        segments.tofile(self.folder / "segments")
        subprocess.run([os.environ["VCD_TEST_BIN"] + "/classify_file", "ball.vcd", "0", "segments", "answers"],
                       cwd=self.folder, check=True)
        np.testing.assert_array_equal(np.fromfile(self.folder / "answers", np.uint8), self.ball.classify(segments))

    def test_proven_only(self):
        segments = random_segments(20_000)
        proven = vcd.open(self.bytes, proven_only=True)[0].classify(segments)
        decided = proven != UNCLASSIFIED
        np.testing.assert_array_equal(proven[decided], self.ball.classify(segments)[decided])
        self.assertLess(decided.sum(), (self.ball.classify(segments) != UNCLASSIFIED).sum())

    def test_segments_broadcast(self):
        made = vcd.segments((0, 0, 0), [(1, 0, 0), (0, 1, 0)], t_max=(2, np.inf))
        np.testing.assert_array_equal(made, [[0, 0, 0, 0, 1, 0, 0, 2], [0, 0, 0, 0, 0, 1, 0, np.inf]])
        self.assertEqual(made.dtype, np.float32)
        self.assertEqual(vcd.segments((0, 0, 0), (1, 0, 0)).shape, (1, 8))

    def test_segments_that_do_not_fit_are_refused(self):
        good = random_segments(16)
        misaligned = np.frombuffer(b"\0" + good.tobytes(), np.uint8)[1:].view(np.float32).reshape(16, 8)
        for bad, error, message in ((good.astype(float), TypeError, r"float32.*\(n, 8\).*got float64"),
                                    (good[:, :7], ValueError, r"got float32 array of shape \(16, 7\)"),
                                    (good[0], ValueError, r"got float32 array of shape \(8,\)"),
                                    (good[::2], ValueError, "C-contiguous"),
                                    (np.asfortranarray(good), ValueError, "C-contiguous"),
                                    (misaligned, ValueError, "aligned")):
            for ask in (self.ball.classify, self.ball.occluded):
                with self.subTest(message), self.assertRaisesRegex(error, message):
                    ask(bad)
        with self.assertRaisesRegex(ValueError, 'start: one of "outside", "inside", "self"; got "below"'):
            self.ball.occluded(good, start="below")

    def test_occluded_needs_a_hierarchy(self):
        bare = vcd.open(vcd.sidecar_bytes([vcd.bake(self.mesh, depth=2, hierarchy=False)]))[0]
        self.assertFalse(bare.has_hierarchy)
        with self.assertRaisesRegex(ValueError, "hierarchy"):
            bare.occluded(random_segments(4))
        with self.assertRaisesRegex(ValueError, "hierarchy"):
            vcd.Scene([bare], np.eye(3, 4, dtype=np.float32)[None]).occluded(random_segments(4))

    def test_horizons(self):
        baked = vcd.bake(self.mesh, depth=2, horizons=True)
        self.assertEqual(baked.without_horizons, "")
        tree = vcd.open(vcd.sidecar_bytes([baked]))[0]
        self.assertEqual((tree.has_horizons, self.ball.has_horizons), (True, False))
        positions, triangles = ball()
        middle = positions[triangles].mean(axis=1)
        out = middle / np.linalg.norm(middle, axis=1, keepdims=True)
        side = np.random.default_rng(2).normal(size=out.shape)
        segments = vcd.segments(middle + 1e-3 * out, (out + 0.8 * side).astype(np.float32))
        primitives = np.arange(len(triangles), dtype=np.uint32)
        answers = tree.classify_self(segments, primitives)
        self.assertLessEqual(set(answers), {CLEAR, UNCLASSIFIED})
        self.assertGreater((answers == CLEAR).mean(), 0.5)
        dark = tree.occluded(segments, start="self")
        self.assertEqual(len(set(dark)), 2)
        self.assertFalse(dark[answers == CLEAR].any())
        np.testing.assert_array_equal(tree.occluded_self(segments, primitives), dark)
        wrong = tree.classify_self(segments, np.roll(primitives, len(primitives) // 2))
        self.assertTrue((wrong == UNCLASSIFIED).all())
        self.assertTrue((self.ball.classify_self(segments, primitives) == UNCLASSIFIED).all())
        for k in range(20):
            samples = [np.ascontiguousarray(np.full(16, segments[k, axis])) for axis in (4, 5, 6)]
            bundle = vcd.PointBundle(segments[k, :3], *samples)
            self.assertEqual(set(tree.classify_self(bundle, k)), {answers[k]})
            self.assertEqual(set(tree.occluded_self(bundle, k)), {dark[k]})
        scene = vcd.Scene([tree], np.eye(3, 4, dtype=np.float32)[None])
        here = np.zeros(len(segments), np.uint32)
        np.testing.assert_array_equal(scene.occluded(segments, origins=here, primitives=primitives), dark)
        self.assertEqual(set(scene.occluded(bundle, origin=0, primitive=k)), {dark[k]})
        for bad in (lambda: tree.classify_self(segments, primitives[:3]), lambda: tree.occluded_self(segments, here[:0]),
                    lambda: scene.occluded(segments, primitives=primitives),
                    lambda: scene.occluded(bundle, primitive=0)):
            with self.assertRaisesRegex(ValueError, "primitive"):
                bad()
        bare = vcd.bake(self.mesh, depth=2, hierarchy=False, horizons=True)
        self.assertNotEqual(bare.without_horizons, "")

    def test_bundles(self):
        random = np.random.default_rng(1)
        u, v = random.uniform(0, 1, (2, 100)).astype(np.float32)
        origin, corner, edge_u, edge_v = (-2, 0.5, 0.25), (2, -1.5, -1.5), (0, 3, 0), (0, 0, 3)
        samples = np.array(corner, np.float32) + u[:, None] * np.array(edge_u, np.float32) + v[:, None] * np.array(
            edge_v, np.float32)
        segments = vcd.segments(origin, samples - np.array(origin, np.float32))
        dark, answers = self.ball.occluded(segments), self.ball.classify(segments)
        self.assertEqual(len(set(dark)), 2)
        x, y, z = (np.ascontiguousarray(samples[:, axis]) for axis in range(3))
        d = [np.ascontiguousarray(segments[:, axis]) for axis in (4, 5, 6)]
        for bundle in (vcd.QuadBundle(origin, corner, edge_u, edge_v, u, v),
                       vcd.SphereBundle(origin, (2, 0, 0), 2.5, x, y, z), vcd.PointBundle(origin, *d)):
            with self.subTest(type(bundle)):
                self.assertEqual(len(bundle), 100)
                np.testing.assert_array_equal(self.ball.occluded(bundle, start="outside"), dark)
                if not isinstance(bundle, vcd.PointBundle):
                    found = self.ball.classify(bundle)
                    np.testing.assert_array_equal(found[answers != UNCLASSIFIED], answers[answers != UNCLASSIFIED])
        with self.assertRaisesRegex(ValueError, "v: .*as long as the others"):
            vcd.QuadBundle(origin, corner, edge_u, edge_v, u, v[1:])
        with self.assertRaisesRegex(ValueError, "origin: needs three numbers"):
            vcd.PointBundle((1, 2), *d)

    def test_gil_is_released(self):
        segments = random_segments(1_000_000)
        shares = []
        for _ in range(5):  # once is enough: other work may hold up this thread
            gaps, done = [], threading.Event()

            def ask():
                begun = time.perf_counter()
                self.ball.occluded(segments)
                gaps.append(time.perf_counter() - begun)
                done.set()

            thread = threading.Thread(target=ask)
            longest, last = 0, time.perf_counter()
            thread.start()
            while not done.is_set():
                now = time.perf_counter()
                longest, last = max(longest, now - last), now
            thread.join()
            shares.append(max(longest, time.perf_counter() - last) / gaps[0])
            if shares[-1] < 0.5:
                return
        self.fail(f"this thread stood still for {shares} of the calls")


class Scenes(Case):
    def test_scenes_of_instances(self):
        to_world = np.zeros((2, 3, 4), np.float32)
        to_world[:, range(3), range(3)] = 1
        to_world[0, 0, 3], to_world[1, 0, 3] = -3, 3
        scene = vcd.Scene([self.ball, self.ball], to_world, np.array([1, 2], np.uint32))
        self.assertEqual((len(scene), scene.use(0)), (2, "asked"))
        down = vcd.segments([(-3, 0, 5), (3, 0, 5), (0, 0, 5)], (0, 0, -10))
        np.testing.assert_array_equal(scene.occluded(down), [True, True, False])
        np.testing.assert_array_equal(scene.occluded(down, mask=2), [False, True, False])
        self.assertEqual(scene.classify(down)[2], CLEAR)
        origins = np.array([0, 0xFFFFFFFF, 1], np.uint32)
        np.testing.assert_array_equal(scene.occluded(down, origins=origins), [True, True, False])
        self.assertEqual(scene.classify(down)[0], BLOCKED)
        self.assertEqual(scene.classify(down, origins=origins)[0], UNCLASSIFIED)
        z = np.zeros(3, np.float32)
        bundle = vcd.PointBundle((-3, 0, 5), z + np.array([0, 12, 0], np.float32), z, z - 10)
        np.testing.assert_array_equal(scene.occluded(bundle, origin=1), [True, True, True])
        to_world[0] = 0
        scene.set_transforms(to_world)
        self.assertEqual(scene.use(0), "absent")
        np.testing.assert_array_equal(scene.occluded(down), [False, True, False])

    def test_scenes_keep_their_sidecars(self):
        scene = vcd.Scene([vcd.open(vcd.sidecar_bytes([self.baked]))[0]], np.eye(3, 4, dtype=np.float32)[None])
        filler = [np.full(len(self.bytes), 255, np.uint8) for _ in range(8)]
        segments = random_segments(1000)
        np.testing.assert_array_equal(scene.occluded(segments), self.ball.occluded(segments))
        del filler

    def test_what_does_not_fit_is_refused(self):
        identity = np.eye(3, 4, dtype=np.float32)[None]
        with self.assertRaisesRegex(ValueError, r"to_world: .*got float32 array of shape \(3, 4\)"):
            vcd.Scene([self.ball], identity[0])
        scene = vcd.Scene([self.ball], identity)
        with self.assertRaisesRegex(ValueError, "to_world"):
            scene.set_transforms(np.concatenate([identity, identity]))
        with self.assertRaisesRegex(IndexError, "origins"):
            scene.occluded(random_segments(2), origins=np.array([0, 1], np.uint32))
        with self.assertRaisesRegex(ValueError, "origins"):
            scene.occluded(random_segments(2), origins=np.array([0], np.uint32))
        with self.assertRaises(IndexError):
            scene.use(1)


class Stores(Case):
    def test_objects_are_found_by_their_geometry(self):
        (self.folder / "a/b").mkdir(parents=True)
        vcd.write(self.folder / "a/b/ball.vcd", [self.baked])
        vcd.write(self.folder / "a/cube.vcd", [vcd.bake(vcd.prepare(CUBE, FACES, name="cube"), depth=2)])
        (self.folder / "a/damaged.vcd").write_bytes(b"no sidecar")
        store = vcd.SidecarStore([self.folder], check="canonical")
        self.assertEqual(len(store), 2)
        reason, = store.passed_over
        self.assertIn("damaged.vcd", reason)
        self.assertIsNone(store.find(bytes(16)))
        found = [None] * 8
        threads = [threading.Thread(target=lambda i: found.__setitem__(i, store.find(vcd.geometry_hash(
            *(ball() if i % 2 else (CUBE, FACES))))), args=(i,)) for i in range(len(found))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        del store  # its objects keep it
        self.assertEqual([o.name for o in found], ["cube", "ball"] * 4)
        segments = random_segments(1000)
        np.testing.assert_array_equal(found[1].classify(segments), self.ball.classify(segments))

    def test_what_is_wrong_is_told(self):
        with self.assertRaises(vcd.FileError):
            vcd.SidecarStore([self.folder / "nowhere"])
        with self.assertRaises(ValueError):
            vcd.SidecarStore([self.folder], check="never")
        with self.assertRaises(ValueError):
            vcd.SidecarStore([self.folder]).find(b"short")
        path = self.folder / "ball.vcd"
        vcd.write(path, [self.baked])
        store = vcd.SidecarStore([self.folder])
        path.unlink()
        with self.assertRaises(vcd.FileError):
            store.find(self.mesh.geometry_hash)


class Counts(Case):
    def test_what_an_object_answers(self):
        segments = random_segments(5000)
        answers = self.ball.classify(segments)
        counts = vcd.AnswerCounts()
        counting = vcd.Counting(self.ball, counts)
        np.testing.assert_array_equal(counting.classify(segments), answers)
        self.assertEqual([counts.clear, counts.blocked, counts.unclassified],
                         [int((answers == v).sum()) for v in (CLEAR, BLOCKED, UNCLASSIFIED)])
        self.assertGreater(min(counts.clear, counts.blocked, counts.unclassified), 0)
        self.assertEqual((counts.asked, counts.answered), (5000, 5000 - counts.unclassified))

        asked = []
        dark = counting.occluded(segments, lambda left: asked.append(left) or self.ball.occluded(left))
        np.testing.assert_array_equal(dark, self.ball.occluded(segments))
        np.testing.assert_array_equal(asked[0], segments[answers == UNCLASSIFIED])
        self.assertEqual(counts.asked, 10_000)
        more = vcd.AnswerCounts(clear=1)
        more += counts
        self.assertEqual((more.clear, more.asked), (counts.clear + 1, 10_001))

    def test_what_a_bundle_and_a_scene_answer(self):
        u = np.linspace(0, 1, 100, dtype=np.float32)
        counts = vcd.AnswerCounts()
        vcd.Counting(self.ball, counts).classify(vcd.QuadBundle((0, 0, 3), (-2, -2, -3), (4, 0, 0), (0, 4, 0), u, u))
        self.assertEqual(counts.asked, 100)
        scene = vcd.Scene([self.ball], np.eye(3, 4, dtype=np.float32)[None])
        vcd.Counting(scene, counts).classify(random_segments(50), mask=1)
        self.assertEqual(counts.asked, 150)


class Stub(unittest.TestCase):
    def test_stub_names_what_the_module_has(self):
        """Every name and argument in both; so a name that is added must be typed."""
        from vcd import _native
        stub = ast.parse((BUILD / "python/vcd/_native.pyi").read_text())
        functions, members = set(), {}
        for node in stub.body:
            if isinstance(node, ast.FunctionDef):
                functions.add(node.name)
            elif isinstance(node, ast.ClassDef):
                members[node.name] = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} - {"__init__"}
        public = {name for name in dir(_native) if not name.startswith("_")}
        self.assertEqual(functions | set(members), public)
        for name, typed in members.items():
            own = {n for n in vars(getattr(_native, name)) if not n.startswith("_") or n in ("__len__", "__getitem__")}
            self.assertEqual(own, typed, name)
        for node in stub.body:
            if isinstance(node, ast.FunctionDef):
                arguments = [a.arg for a in node.args.args + node.args.kwonlyargs]
                signature = getattr(_native, node.name).__doc__.split("\n")[0]
                given = [part.split(":")[0].strip() for part in signature.split("(", 1)[1].rsplit(")", 1)[0].split(",")]
                for argument in arguments:
                    self.assertIn(argument, given, signature)
        self.assertTrue((BUILD / "python/vcd/py.typed").is_file())
        self.assertEqual(sorted(vcd.__all__), sorted(n for n in dir(vcd) if not n.startswith("_") and
                                                     n not in ("counting", "records")))


class Examples(Case):
    def test_readme(self):
        blocks = re.findall(r"^```python\n(.*?)^```$", (PROJECT / "README.md").read_text(), re.M | re.S)
        self.assertTrue(blocks)
        positions, triangles = ball(8)
        for block in blocks:
            names = {"positions": positions, "triangles": triangles, "origins": [(0, 0, 5), (3, 0, 5)],
                     "directions": (0, 0, -10)}
            before = os.getcwd()
            os.chdir(self.folder)
            try:
                exec(block, names)
            finally:
                os.chdir(before)
            self.assertEqual(list(names["dark"]), [True, False])

    def test_exporter(self):
        done = subprocess.run([sys.executable, PROJECT / "python/examples/export.py"], cwd=self.folder, check=True,
                              capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(BUILD / "python")})
        self.assertIn("name='gem'", done.stdout)
        self.assertTrue(vcd.open(self.folder / "gem.vcd")["gem"].has_hierarchy)

    def test_classes_are_told_apart(self):
        import draw_classes
        found = set()
        for azimuth, elevation in draw_classes.VIEWS:
            lines = draw_classes.lines_of_view(self.ball.record, azimuth, elevation, 64)
            proven = vcd.open(self.bytes, proven_only=True)[0]
            classes = draw_classes.classes(self.ball, proven, lines).reshape(64, 64)
            self.assertEqual(classes[0, 0], CLEAR)  # beside the object
            self.assertNotEqual(classes[32, 32], CLEAR)
            found |= set(classes.ravel())
        self.assertEqual(found, {0, 1, 2, 3})

    def test_picture(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("needs python3-matplotlib; tools/install_dependencies.sh lab installs it")
        import draw_classes
        self.bytes.tofile(self.folder / "ball.vcd")
        draw_classes.draw(self.folder / "ball.vcd", self.folder / "ball.png", pixels=48)
        self.assertEqual((self.folder / "ball.png").read_bytes()[:4], b"\x89PNG")


if __name__ == "__main__":
    unittest.main()
