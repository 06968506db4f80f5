"""Holds libvcd_embree3.so to Embree: a program that knows nothing of vcd must get the same answers with it."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["VCD_BUILD"])
BIN, TEST_BIN = pathlib.Path(os.environ["VCD_BIN"]), pathlib.Path(os.environ["VCD_TEST_BIN"])
LIBRARY = BUILD / "lib" / "libvcd_embree3.so"
QUERIES = ("1", "4", "8", "16", "1M", "1Mp", "NM", "threads")
REPORT = re.compile(r"libvcd_embree3: (?P<meshes>\d+) meshes: (?P<with_sidecar>\d+) with a sidecar, (?P<exported>\d+) exported\n"
                    r"libvcd_embree3: (?P<asked>\d+) shadow rays: (?P<clear>\d+) clear, (?P<blocked>\d+) blocked; clear of "
                    r"sidecars, the rest traced by Embree: (?P<rest>\d+); traced by Embree: (?P<unclassified>\d+) unclassified, "
                    r"(?P<held_back>\d+) blocked unless a filter or mask says no, "
                    r"(?P<not_looked_up>\d+) since look-ups cost more, (?P<other>\d+) in scenes without sidecars or by rtcOccludedNp\n")


def run(scene, query, program="shadow_program", preload=True, **variables):
    env = {**os.environ, "VCD_LOOK_UP": "always", **{name: str(value) for name, value in variables.items()}}
    if preload:
        env["LD_PRELOAD"] = str(LIBRARY)
    done = subprocess.run([TEST_BIN / program, scene, query], env=env, capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        raise AssertionError(f"{scene} {query}: exit code {done.returncode}\n{done.stderr}")
    found = REPORT.fullmatch(done.stderr)
    return done.stdout, {name: int(n) for name, n in found.groupdict().items()} if found else done.stderr


class Preload(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.meshes, cls.sidecars = cls.folder / "meshes", cls.folder / "sidecars"
        for scene in ("mesh", "two"):
            run(scene, "1", VCD_EXPORT=cls.meshes)
        subprocess.run([BIN / "vc-bake", cls.meshes, "-o", cls.sidecars, "-m", "proven", "-d", "3", "--audit", "0", "--quiet"],
                       check=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def compare(self, scene, query, **variables):
        """The report of a run with sidecars, whose answers are Embree's."""
        expected, _ = run(scene, query, preload=False)
        answers, report = run(scene, query, VCD_SIDECARS=self.sidecars, **variables)
        self.assertEqual(answers, expected, f"{scene} {query}")
        self.assertIsInstance(report, dict, report)
        self.assertEqual(report["asked"], sum(report[n] for n in ("clear", "blocked", "rest", "unclassified", "held_back", "not_looked_up", "other")))
        return report

    def test_every_query_gets_embrees_answers(self):
        for query in QUERIES:
            for scene in ("mesh", "instances", "far"):
                with self.subTest(scene=scene, query=query):
                    report = self.compare(scene, query)
                    self.assertGreater(report["clear"], 200)
                    self.assertGreater(report["blocked"], 200 if scene != "far" else 20)

    def test_scenes_that_are_answered(self):
        for scene in ("quads", "two", "disabled", "detached", "again", "two-devices"):
            with self.subTest(scene=scene):
                report = self.compare(scene, "1")
                self.assertGreater(report["clear"], 200)
                self.assertGreater(report["blocked"], 50)

    def test_what_may_let_rays_pass_is_asked(self):
        for scene in ("filter", "context-filter"):
            for query in ("1", "8", "1M"):
                with self.subTest(scene=scene, query=query):
                    report = self.compare(scene, query)
                    self.assertGreater(report["held_back"], 100)
                    self.assertEqual(report["blocked"], 0)
        for scene in ("mask", "instance-mask"):
            for query in ("1", "16", "NM"):
                with self.subTest(scene=scene, query=query):
                    report = self.compare(scene, query)
                    self.assertGreater(report["held_back"], 20)
                    self.assertGreater(report["blocked"], 20)

    def test_what_changes_is_left_to_embree(self):
        # `most`: one ray is asked before the change.
        for scene, most in (("motion", 0), ("moved", 1), ("inner-changed", 1), ("mask-at-once", 1), ("inner-at-once", 1)):
            with self.subTest(scene=scene):
                report = self.compare(scene, "1")
                self.assertLessEqual(report["clear"] + report["blocked"] + report["rest"], most)

    def test_what_has_no_sidecar_is_traced_by_embree(self):
        for query in QUERIES:
            with self.subTest(query=query):
                report = self.compare("user", query)
                self.assertEqual(report["clear"], 0)
                self.assertGreater(report["rest"], 200)
                self.assertGreater(report["blocked"], 100)

    def test_buffers_that_embree_refuses_are_not_read(self):
        self.assertEqual(self.compare("refused", "1")["other"], 4096)

    def test_what_lies_beside_positions_is_not_read(self):
        self.assertEqual(self.compare("attributes", "1")["meshes"], 1)

    def test_a_lack_of_memory_is_told_and_harms_nothing(self):
        expected, _ = run("no-memory", "1", preload=False)
        answers, text = run("no-memory", "1", VCD_SIDECARS=self.sidecars)
        self.assertEqual(answers, expected)
        self.assertIn("bad_alloc", text)

    def test_hierarchies_decide_the_rest_if_wanted(self):
        for scene in ("mesh", "instances"):
            for query in ("1", "16", "1M"):
                with self.subTest(scene=scene, query=query):
                    report = self.compare(scene, query, VCD_ANSWERS="exact")
                    self.assertEqual(report["unclassified"], 0)

    def test_what_pays_is_measured(self):
        for scene in ("mesh", "user", "instances"):
            for query in QUERIES:
                with self.subTest(scene=scene, query=query):
                    report = self.compare(scene, query, VCD_LOOK_UP="measured")
                    self.assertGreater(report["clear"] + report["rest"], 100)
                    self.assertGreater(report["not_looked_up"], 500)

    def test_none_answers_nothing(self):
        self.assertEqual(self.compare("mesh", "1", VCD_ANSWERS="none")["other"], 4096)

    def test_a_word_that_is_none_is_an_error(self):
        with self.assertRaisesRegex(AssertionError, "VCD_ANSWERS is"):
            run("mesh", "1", VCD_SIDECARS=self.sidecars, VCD_ANSWERS="some")

    def test_linked_before_embree(self):
        expected, _ = run("instances", "1", preload=False)
        answers, report = run("instances", "1", program="shadow_program_linked", preload=False, VCD_SIDECARS=self.sidecars)
        self.assertEqual(answers, expected)
        self.assertGreater(report["blocked"], 200)

    def test_exports_what_has_no_sidecar(self):
        exported = self.folder / "exported"
        _, report = run("two", "1", VCD_SIDECARS=self.sidecars, VCD_EXPORT=exported)
        self.assertEqual((report["meshes"], report["with_sidecar"], report["exported"]), (2, 2, 0))
        _, report = run("moved", "1", VCD_SIDECARS=self.sidecars, VCD_EXPORT=exported)
        self.assertEqual((report["meshes"], report["with_sidecar"], report["exported"]), (2, 1, 1))
        self.assertEqual([file.suffix for file in exported.iterdir()], [".ply"])

    def test_threads_that_export_the_same_mesh_do_not_meet(self):
        exported = self.folder / "at-once"
        _, report = run("at-once", "1", VCD_EXPORT=exported)
        self.assertIsInstance(report, dict, report)
        self.assertEqual([file.suffix for file in exported.iterdir()], [".ply"] * 21)

    def test_a_folder_that_is_missing_is_told_and_harms_nothing(self):
        expected, _ = run("mesh", "1", preload=False)
        answers, text = run("mesh", "1", VCD_SIDECARS=self.folder / "missing")
        self.assertEqual(answers, expected)
        self.assertIn("missing", text)


if __name__ == "__main__":
    unittest.main()
