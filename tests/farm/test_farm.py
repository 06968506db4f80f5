"""A library over several machines: shards by hand, and by a real Slurm that loses a node; the sidecars are those of a local run.

VCD_FARM_ASSETS: how many assets, of which many are broken; a large library is made of real meshes too."""
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "library")]
import make_library
from library_case import processes_of
from slurm_cluster import SlurmCluster

BIN = pathlib.Path(os.environ["VCD_BIN"])
SETTINGS = ("--depth", "3", "--audit", "9000")
ASSETS = int(os.environ.get("VCD_FARM_ASSETS", "24"))
DATA = os.environ.get("VCD_TEST_DATA") if ASSETS >= 1000 else None
MISSING = SlurmCluster.missing()


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.shared = pathlib.Path(cls.holder.name).resolve()
        cls.assets = make_library.make(cls.shared / "library", ASSETS, DATA)
        (cls.shared / "local").mkdir()
        done = subprocess.run([BIN / "vc-bake", cls.shared / "library", "-o", cls.shared / "local", "--format", "json", *SETTINGS], capture_output=True)
        cls.local = json.loads(done.stdout)["totals"]
        cls.wanted = cls.sidecars(cls.shared / "local")

    @staticmethod
    def sidecars(folder):
        return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.rglob("*") if p.is_file()}

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name).resolve()
        (self.folder / "out").mkdir()
        (self.folder / "slurm").mkdir()
        self.plan = self.folder / "plan"

    def farm(self, *arguments, code=0, **options):
        done = subprocess.run([BIN / "vc-farm", *map(str, arguments)], capture_output=True, text=True, timeout=300 + 2 * ASSETS, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def make_plan(self, shards):
        done = self.farm("plan", self.plan, self.shared / "library", "-o", self.folder / "out", "--shards", shards, "--format", "json", *SETTINGS)
        return json.loads(done.stdout)["shards"]

    def expect_as_local(self):
        self.assertEqual(self.sidecars(self.folder / "out"), self.wanted)
        totals = json.loads((self.plan / "report.json").read_text())["totals"]
        done = totals["baked"] + totals["up_to_date"], totals["failed"] + totals["failed_before"], totals["not_run"]
        self.assertEqual(done, (self.local["baked"], self.local["failed"], 0))


class ByHand(Case):
    def test_shards_are_balanced_run_by_anything_and_merged(self):
        shards = self.make_plan(3)
        self.assertEqual(sum(s["assets"] for s in shards), self.assets)
        self.assertLess(max(s["seconds"] for s in shards), 1.2 * min(s["seconds"] for s in shards))
        self.farm("plan", self.plan, self.shared / "library", code=1)  # there is one already
        for number in (1, 3):
            self.farm("run", self.plan, number, "-j", 1)
        merged = self.farm("merge", self.plan, code=4)
        self.assertIn("assets are of shards that are not done", merged.stderr)
        states = json.loads(self.farm("status", self.plan, "--format", "json").stdout)["shards"]
        self.assertEqual([s["state"] for s in states], ["done", "not begun", "done"])
        shard = subprocess.Popen([BIN / "vc-farm", "run", self.plan, "2"], stderr=subprocess.DEVNULL)
        time.sleep(0.3)
        shard.kill()  # and again: it goes on where it was
        shard.wait()
        self.farm("run", self.plan, 2)
        self.farm("merge", self.plan, code=9)
        self.expect_as_local()
        self.farm("run", self.plan, 4, code=1)
        (self.plan / "plan.json").write_text("{}")
        self.farm("status", self.plan, code=3)

    def test_a_report_counts_for_its_shard_alone(self):
        self.make_plan(2)
        report = lambda number: self.plan / f"shard-{number:04}.report.json"
        states = lambda: [s["state"] for s in json.loads(self.farm("status", self.plan, "--format", "json").stdout)["shards"]]
        self.farm("run", self.plan, 1, "--prune", code=1)
        self.farm("run", self.plan, 1)
        whole = report(1).read_text()
        made = json.loads(whole)
        self.farm("run", self.plan, 2)
        own = json.loads(report(2).read_text())
        for files in (made["files"], own["files"][:-1], own["files"] + made["files"], own["files"] + own["files"][:1]):
            report(2).write_text(json.dumps(own | {"files": files}))
            self.assertEqual(states()[0], "done")
            self.assertNotEqual(states()[1], "done")
        self.farm("merge", self.plan, code=4)
        self.farm("merge", self.plan, "--report", self.plan / "plan", code=1)
        for more in ("--no-such-option", "--dry-run"):  # what is done stays so, but this was no run
            done = subprocess.run([BIN / "vc-farm", "run", self.plan, "1", more], capture_output=True)
            self.assertNotEqual(done.returncode, 0, more)
            self.assertEqual(states()[0], "done")
        self.assertEqual(report(1).read_text(), whole)
        self.assertEqual(len(list(self.plan.glob("shard-*.html"))), 2)
        (self.plan / "plan.json").unlink()
        self.assertIn("holds a plan already", self.farm("plan", self.plan, self.shared / "library", code=1).stderr)

    def test_what_a_shard_started_dies_with_it(self):
        library = self.folder / "library"
        library.mkdir()
        (library / "a.obj").write_bytes(make_library.as_obj(*make_library.shape(1)))
        self.farm("plan", self.plan, library, "-q", "--depth", "8", "--audit", "0")  # longer than this test waits
        shard = subprocess.Popen([BIN / "vc-farm", "run", self.plan, "1"], start_new_session=True)
        events = self.plan / "shard-0001.events.jsonl"
        within = lambda seconds, what: any(what() or time.sleep(0.1) for _ in range(10 * seconds))
        self.assertTrue(within(60, lambda: events.exists() and '"started"' in events.read_text()))
        shard.kill()
        shard.wait()
        self.assertTrue(within(10, lambda: not processes_of(shard.pid)))

    def test_one_that_takes_long_has_a_shard_for_itself(self):
        library = self.folder / "library"
        library.mkdir()
        (library / "c.obj").write_text("v 0 0 0\n" * 500000)
        for name in "abdef":
            (library / f"{name}.obj").write_text("v 0 0 0\n")
        shards = json.loads(self.farm("plan", self.plan, library, "--shards", 2, "--format", "json").stdout)["shards"]
        self.assertEqual(sorted(s["assets"] for s in shards), [1, 5])

    def test_a_shard_that_was_broken_off_is_not_done(self):
        library = self.folder / "library"
        library.mkdir()
        (library / "broken.obj").write_text("f 1 2 3\n" * 100000)  # guessed to be the longest
        for name in ("a.obj", "b.obj"):
            (library / name).write_bytes(make_library.as_obj(*make_library.shape(1)))
        self.farm("plan", self.plan, library, "-q", "--shards", 1, *SETTINGS)
        self.farm("run", self.plan, 1, "-j", 1, "--fail-fast", code=9)
        state = lambda: json.loads(self.farm("status", self.plan, "--format", "json").stdout)["shards"][0]["state"]
        self.assertEqual(state(), "begun")
        self.assertIn("3 assets are of shards that are not done", self.farm("merge", self.plan, code=4).stderr)
        self.farm("run", self.plan, 1)
        self.assertEqual(state(), "done")
        self.assertIn("2 baked, 0 up to date, 1 failed, 0 not run", self.farm("merge", self.plan, code=9).stdout)


class ByASlurmOfScripts(Case):
    """What Slurm is told, and what follows from what it says: sbatch and squeue keep what they are given in files, and squeue says
    what is in the file `queue`."""

    def setUp(self):
        super().setUp()
        programs = self.folder / "programs"
        programs.mkdir()
        for name, more in (("sbatch", ""), ("squeue", f"cat {self.folder}/queue")):
            (programs / name).write_text(f'#!/bin/sh\n[ "$1" = --version ] && exit\necho "$@" >> {self.folder}/{name}\n{more}\n')
            (programs / name).chmod(0o755)
        self.environment = {"PATH": f"{programs}:{os.environ['PATH']}"}
        self.queue([])

    def queue(self, lines):
        (self.folder / "queue").write_text("".join(line + "\n" for line in lines))

    def slurm(self, *arguments, code=0):
        return self.farm("slurm", self.plan, *arguments, code=code, env=self.environment)

    def asked(self, program):
        """The calls since it was asked for last."""
        calls = (self.folder / program).read_text().splitlines()
        (self.folder / program).unlink()
        return calls

    def test_what_sbatch_is_given(self):
        self.make_plan(2)
        self.slurm("--threads", 3, "--bake=--cache=/c d", "--detach", "--sbatch=--partition=night", "--sbatch=--nice")
        [given] = self.asked("sbatch")
        for words in ("--array=1,2 ", "--requeue", "--cpus-per-task=3", "--open-mode=append", "--partition=night --nice"):
            self.assertIn(words, given)
        self.assertIn("'--cache=/c d'", (self.plan / "slurm-0.sh").read_text())

    def test_more_than_slurm_has_in_an_array_are_several(self):
        many = self.folder / "many"
        many.mkdir()
        for i in range(1003):
            (many / f"{i}.obj").write_text("")
        self.farm("plan", self.plan, many, "--shards", 1003, "-q")
        self.slurm("--detach")
        first, second = self.asked("sbatch")
        self.assertIn("--array=1,2,3,", first)
        self.assertIn(",1000 ", first)
        self.assertIn("--array=1,2,3 ", second)
        self.assertIn("$((1000 + SLURM_ARRAY_TASK_ID))", pathlib.Path(second.split()[-1]).read_text())
        names = [next(word.partition("=")[2] for word in call.split() if word.startswith("--job-name=")) for call in (first, second)]
        self.queue([f"{names[0]} {i} Resources" for i in range(1, 1001)] + [f"{names[1]} 2 None", f"another-{names[1]} 3 None"])
        self.slurm("--detach")
        [again] = self.asked("sbatch")
        self.assertIn("--array=1,3 ", again)

    def test_what_is_lost_is_submitted_so_many_times(self):
        self.make_plan(1)
        done = self.slurm("--poll", "0.1", "--tries", "2", code=4)
        self.assertIn("shard 1 was submitted 2 times and is not done", done.stderr)
        self.assertEqual(len(self.asked("sbatch")), 2)
        self.assertEqual(len(self.asked("squeue")), 5)  # it is lost when it is missing twice

    def test_what_is_held_is_told(self):
        self.make_plan(2)
        self.slurm("--detach")
        name = next(word.partition("=")[2] for word in self.asked("sbatch")[0].split() if word.startswith("--job-name="))
        self.queue([f"{name} 1 JobHeldUser", f"{name} 2 launch failed requeued held"])
        follow = subprocess.Popen([BIN / "vc-farm", "slurm", self.plan, "--poll", "0.1"], env=self.environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(follow.stderr.close)
        patience = threading.Timer(60, follow.kill)
        patience.start()
        self.addCleanup(patience.cancel)
        self.assertIn("2 shards are held by Slurm", follow.stderr.readline())
        follow.terminate()
        self.assertEqual(follow.wait(timeout=60), 4)
        self.assertFalse((self.folder / "sbatch").exists())


@unittest.skipIf(MISSING, MISSING)
class BySlurm(Case):
    def test_a_node_is_lost_and_the_sidecars_are_those_of_a_local_run(self):
        with SlurmCluster(self.folder / "slurm") as cluster:
            self.make_plan(9)
            follow = subprocess.Popen([BIN / "vc-farm", "slurm", self.plan, "--poll", "0.5", "--bake=--time-limit=3600"], env=cluster.env,
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            cluster.wait_for("the shards run", lambda: len(list(self.plan.glob("*.events.jsonl"))) >= 6)
            cluster.kill_node(1)
            out, errors = follow.communicate(timeout=250 + 2 * ASSETS)
            self.assertEqual(follow.returncode, 9, out + errors)  # some of the library is broken
            self.assertEqual(cluster.nodes()["node1"], "down*")
        self.expect_as_local()
        self.assertIn("9 shards submitted", errors)

    def test_a_shard_that_vanishes_is_submitted_again(self):
        with SlurmCluster(self.folder / "slurm", nodes=1, settings={"MinJobAge": 2}) as cluster:
            self.make_plan(2)
            self.farm("slurm", self.plan, "--detach", env=cluster.env)
            cluster.run("scancel", "--me")
            done = self.farm("slurm", self.plan, "--poll", "0.5", env=cluster.env, code=9)
            self.assertIn("2 shards submitted", done.stderr)
        self.expect_as_local()

    def test_where_there_is_no_slurm_it_says_so(self):
        self.make_plan(2)
        self.assertIn("sbatch: cannot be run: No such file or directory", self.farm("slurm", self.plan, code=4, env={"PATH": "/nowhere"}).stderr)


if __name__ == "__main__":
    unittest.main()
