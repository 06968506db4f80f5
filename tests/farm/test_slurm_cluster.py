"""The cluster for tests of a farm: it does what a cluster does, loses what it is told to lose, and leaves nothing."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

from slurm_cluster import SlurmCluster

MISSING = SlurmCluster.missing()
SAYS_WHERE = 'echo "$SLURM_ARRAY_TASK_ID $SLURMD_NODENAME" >> '
WAITS = f"{SAYS_WHERE} started; until [ -e go ]; do sleep 0.1; done; {SAYS_WHERE} ended"


def processes(**environment):
    """Those that were started with these variables, whoever their parents are."""
    wanted = {f"{name}={value}".encode() for name, value in environment.items()}
    found = []
    for each in pathlib.Path("/proc").glob("[0-9]*/environ"):
        try:
            if wanted <= set(each.read_bytes().split(b"\0")):
                found.append(int(each.parent.name))
        except OSError:
            pass  # it has ended, or is closed even to root
    return found


class Case(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)  # fails when something still writes there
        self.folder = pathlib.Path(holder.name).resolve()
        self.addCleanup(lambda: self.assertEqual(self.processes(), [], "left behind"))

    def processes(self, **environment):
        return processes(SLURM_CONF=self.folder / "slurm.conf", **environment)

    def places(self, name):
        """(task, node) by line of a file that tasks write."""
        file = self.folder / name
        lines = file.read_text().splitlines() if file.exists() else []
        return sorted((int(task), node) for task, node in map(str.split, lines))


@unittest.skipIf(MISSING, MISSING)
class Cluster(Case):
    def cluster(self, **options):
        return SlurmCluster(self.folder, **options)

    def submit(self, cluster, tasks, script, *options):
        return cluster.run("sbatch", "--parsable", f"--array=1-{tasks}", *options, "--wrap", script).stdout.strip()

    def wait_for_state(self, cluster, job, state, tasks):
        def count():
            return sum(now == state for now, *_ in cluster.tasks(job).values())
        cluster.wait_for(f"{tasks} tasks are {state}", lambda: count() == tasks)

    def test_three_nodes_are_idle_and_share_an_array(self):
        with self.cluster() as cluster:
            self.assertEqual(cluster.nodes(), {"node1": "idle", "node2": "idle", "node3": "idle"})
            self.wait_for_state(cluster, self.submit(cluster, 12, f"{SAYS_WHERE} ran; sleep 0.5"), "COMPLETED", 12)
        ran = self.places("ran")
        self.assertEqual([task for task, _ in ran], [*range(1, 13)])
        self.assertEqual({node for _, node in ran}, {"node1", "node2", "node3"})

    def test_tasks_of_a_lost_node_run_again_on_others(self):
        with self.cluster() as cluster:
            job = self.submit(cluster, 6, WAITS, "--requeue")
            cluster.wait_for("all tasks run", lambda: len(self.places("started")) == 6)
            started = self.places("started")
            on = {node: [task for task, where in started if where == node] for node in cluster.nodes()}
            self.assertEqual([len(tasks) for tasks in on.values()], [2, 2, 2])
            self.assertNotEqual(self.processes(SLURMD_NODENAME="node1"), [])
            cluster.kill_node(1)
            self.assertEqual(self.processes(SLURMD_NODENAME="node1"), [])
            cluster.cut_node(2)
            lost = {"node1": "down*", "node2": "down*", "node3": "allocated"}
            cluster.wait_for("both are lost", lambda: cluster.nodes() == lost)
            self.wait_for_state(cluster, job, "PENDING", 4)
            (self.folder / "go").touch()
            self.wait_for_state(cluster, job, "COMPLETED", 6)
            ended = self.places("ended")
            self.assertEqual([task for task, node in ended if node == "node3"], [*range(1, 7)])
            self.assertEqual([task for task, node in ended if node == "node2"], on["node2"])  # ran twice
            self.assertEqual([task for task, node in ended if node == "node1"], [])
            cluster.kill_node(2)
            for node in (1, 2):
                cluster.restart_node(node)
            cluster.wait_for("both are back", lambda: set(cluster.nodes().values()) == {"idle"})

    def test_the_controller_goes_on_from_its_state(self):
        with self.cluster(nodes=1) as cluster:
            job = self.submit(cluster, 3, WAITS)
            cluster.wait_for("two tasks run", lambda: len(self.places("started")) == 2)
            cluster.stop_controller()
            self.assertIn("Unable to contact slurm controller", cluster.run("squeue", check=False).stderr)
            (self.folder / "go").touch()
            cluster.restart_controller()
            self.wait_for_state(cluster, job, "COMPLETED", 3)

    def test_nothing_is_left_after_an_exception_while_jobs_run(self):
        refusal = "(?s)^sbatch ended with 1: .*Invalid partition name"
        with self.assertRaisesRegex(RuntimeError, refusal), self.cluster(nodes=1) as cluster:
            self.submit(cluster, 2, "sleep 1000")
            cluster.wait_for("jobs run", lambda: len(self.processes(SLURMD_NODENAME="node1")) >= 2)
            self.submit(cluster, 1, "true", "--partition=nowhere")

    def test_nothing_is_left_when_the_test_is_killed(self):
        script = ("import sys, time; from slurm_cluster import SlurmCluster\n"
                  "with SlurmCluster(sys.argv[1], nodes=1) as cluster:\n"
                  "  cluster.run('sbatch', '--wrap', 'sleep 1000')\n"
                  "  print('up', flush=True); time.sleep(1000)")
        with subprocess.Popen([sys.executable, "-c", script, self.folder], stdout=subprocess.PIPE, text=True,
                              cwd=pathlib.Path(__file__).parent) as test:
            try:
                self.assertEqual(test.stdout.readline(), "up\n")
                self.assertGreaterEqual(len(self.processes()), 3)
            finally:
                test.kill()
        end = time.monotonic() + 10
        while self.processes() and time.monotonic() < end:
            time.sleep(0.05)

    def test_a_daemon_that_does_not_come_up_is_named_with_its_words(self):
        with self.assertRaisesRegex(RuntimeError, r"(?s)ended by itself: (slurmctld|node1)\.out.*select/nonsense"):
            with self.cluster(nodes=1, settings={"SelectType": "select/nonsense"}):
                pass


class Missing(unittest.TestCase):
    def test_programs_that_are_not_installed_are_named(self):
        with mock.patch.dict(os.environ, PATH=""):
            self.assertRegex(SlurmCluster.missing(), "needs munged,.* slurmd,.*install_dependencies.sh")


if __name__ == "__main__":
    if MISSING:
        print("skipped:", MISSING, file=sys.stderr)
    unittest.main()
