"""A library over several machines: shards by hand, and by a real Slurm that loses a node; the sidecars are those of a local run.

VCD_FARM_ASSETS: how many assets, of which many are broken; a large library is made of real meshes too."""
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "library")]
import make_library
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


    def test_what_sbatch_is_given(self):
        self.make_plan(2)
        programs = self.folder / "programs"
        programs.mkdir()
        for name in ("sbatch", "squeue"):
            (programs / name).write_text(f'#!/bin/sh\n[ "$1" = --version ] || echo "$@" >> {self.folder}/{name}\n')
            (programs / name).chmod(0o755)
        self.farm("slurm", self.plan, "--threads", 3, "--bake=--cache=/c d", "--detach", "--sbatch=--partition=night", "--sbatch=--nice",
                  env={"PATH": f"{programs}:{os.environ['PATH']}"})
        given = (self.folder / "sbatch").read_text()
        for words in ("--array=1,2 ", "--requeue", "--cpus-per-task=3", "--open-mode=append", "--partition=night --nice"):
            self.assertIn(words, given)
        self.assertIn("'--cache=/c d'", (self.plan / "slurm-0.sh").read_text())


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
