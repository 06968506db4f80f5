"""A real Slurm cluster on this machine's loopback, for tests: munged, slurmctld and some slurmd, without accounting.

    with SlurmCluster(folder) as cluster:
        job = cluster.run("sbatch", "--parsable", "--array=1-12", "--wrap=hostname").stdout.strip()
        cluster.kill_node(1)
        cluster.wait_for("node1 down", lambda: cluster.nodes()["node1"] == "down*")

It leaves a Slurm or munge of the system alone: keys, sockets, ports and state are its own. Needs root.
"""
import os
import pathlib
import random
import shutil
import socket
import subprocess
import time

import daemon

PROGRAMS = ("munged", "munge", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo", "scontrol",
            *daemon.PROGRAMS)
CLIENT_VARIABLES = ("SLURM", "SBATCH_", "SQUEUE_", "SINFO_", "SCANCEL_", "SALLOC_")

# What a test wants of a cluster: no cgroups, no accounting, and a lost node that is noticed soon.
SETTINGS = {
    "ClusterName": "test",
    "SlurmUser": "root",
    "SlurmdUser": "root",
    "AuthType": "auth/munge",
    "CredType": "cred/munge",
    "ProctrackType": "proctrack/linuxproc",
    "TaskPlugin": "task/none",
    "JobAcctGatherType": "jobacct_gather/none",
    "AccountingStorageType": "accounting_storage/none",
    "MpiDefault": "none",
    "MailProg": "/bin/true",
    "SelectType": "select/cons_tres",
    "SelectTypeParameters": "CR_CPU",
    "SchedulerParameters": "batch_sched_delay=0,sched_min_interval=0,sched_interval=1,bf_interval=1",
    "SlurmdParameters": "config_overrides",  # nodes are smaller than the machine
    "SlurmdTimeout": 4,
    "MessageTimeout": 3,
    "TCPTimeout": 2,
    "KillWait": 2,
    "ReturnToService": 2,
    "JobRequeue": 1,
}


class SlurmCluster:
    """Nodes are node1, node2, ... with `cpus` each, idle on entry; all are in the one partition.

    On exit, or when the thread that entered it ends in whatever way, all daemons and jobs are killed. The folder must
    be there, without an earlier cluster's files, and is left to the caller, with the daemons' words in *.out.
    Errors of daemons and of commands are RuntimeError and show their words.
    """

    def __init__(self, folder, nodes=3, cpus=2, settings=None):
        """settings: lines of slurm.conf by name, over those of SETTINGS."""
        self.folder = pathlib.Path(folder).resolve()
        self.socket = self.folder / "munge.socket"
        self.configuration = self.folder / "slurm.conf"
        self.env = {name: value for name, value in os.environ.items() if not name.startswith(CLIENT_VARIABLES)}
        self.env["SLURM_CONF"] = str(self.configuration)
        self._node_names = [f"node{n}" for n in range(1, nodes + 1)]
        self._cpus, self._settings = cpus, settings or {}
        # --force: the folder may be closed to other users.
        munged = ("munged", "--foreground", "--force", "--origin", "127.0.0.1", "--socket", self.socket,
                  "--key-file", self.folder / "munge.key", "--seed-file", self.folder / "munged.seed",
                  "--pid-file", self.folder / "munged.pid")
        commands = {"munged": munged, "slurmctld": ("slurmctld", "-D")}
        commands |= {node: ("slurmd", "-D") for node in self._node_names}
        self.daemons = {host: daemon.Daemon(host, command, self.folder / f"{host}.out", self.env)
                        for host, command in commands.items()}

    @staticmethod
    def missing():
        """Why there can be no cluster here, or None."""
        programs = [program for program in PROGRAMS if not shutil.which(program)]
        if programs:
            return f"needs {', '.join(programs)}; tools/install_dependencies.sh test installs slurm-wlm and munge"
        return daemon.refusal()

    def __enter__(self):
        self._write_files()
        try:
            self.daemons["munged"].start()
            self.wait_for("munged answers", lambda: self._answers("munge", "-n", "-S", self.socket))
            self.daemons["slurmctld"].start()
            for node in self._node_names:
                self.daemons[node].start()
            self.wait_for("slurmctld answers", lambda: self._answers("scontrol", "ping"))
            self.wait_for("all nodes are idle", lambda: set(self.nodes().values()) == {"idle"})
        except BaseException:
            self._stop()
            raise
        return self

    def __exit__(self, *_):
        self._stop()

    def run(self, *command, check=True, timeout=60, **options):
        """Runs a program as a user of the cluster; its output is text. RuntimeError when it fails, unless not check."""
        options = {"env": self.env, "cwd": self.folder, **options}
        done = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=timeout, **options)
        if check and done.returncode != 0:
            raise RuntimeError(f"{command[0]} ended with {done.returncode}: {done.stderr.strip()}")
        return done

    def nodes(self):
        """States by node as sinfo names them: idle, allocated, mixed, down, ...; with a * when it does not respond."""
        return dict(line.split() for line in self.run("sinfo", "-N", "-h", "-o", "%N %T").stdout.splitlines())

    def tasks(self, job):
        """(state, node, reason) by task of an array job, as long as slurmctld remembers them."""
        lines = self.run("squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%K|%T|%N|%r").stdout.splitlines()
        return {int(task): tuple(rest) for task, *rest in (line.split("|") for line in lines)}

    def kill_node(self, number):
        """A power loss: its slurmd and its jobs are gone at once. slurmctld finds out by itself."""
        self._node(number).kill()

    def restart_node(self, number):
        """Boots a killed node. It is idle again when slurmctld has heard of it."""
        self._node(number).start()

    def cut_node(self, number):
        """A node that hangs or is cut off: slurmctld loses it and runs its tasks elsewhere, but here they go on too."""
        self._node(number).freeze()

    def stop_controller(self):
        """slurmctld saves its state and ends: sbatch and squeue fail now, jobs go on."""
        self.daemons["slurmctld"].stop()

    def restart_controller(self):
        """slurmctld goes on from its state."""
        self.daemons["slurmctld"].start()
        self.wait_for("slurmctld answers", lambda: self._answers("scontrol", "ping"))

    def wait_for(self, what, condition, seconds=40):
        """Returns what condition() returns when that is true; RuntimeError when it is not in time or a daemon ended."""
        end = time.monotonic() + seconds
        while True:
            failed = [d for d in self.daemons.values() if d.failed()]
            if failed:
                raise RuntimeError(f"ended by itself: {failed[0].last_words()}")
            if result := condition():
                return result
            if time.monotonic() > end:
                words = "\n".join(d.last_words() for d in self.daemons.values())
                raise RuntimeError(f"waited {seconds} s in vain: {what}\n{words}")
            time.sleep(0.1)

    def _node(self, number):
        return self.daemons[self._node_names[number - 1]]

    def _answers(self, *command):
        return self.run(*command, check=False).returncode == 0

    def _stop(self):
        for each in reversed(self.daemons.values()):
            each.kill()

    def _write_files(self):
        with open(os.open(self.folder / "munge.key", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as key:
            key.write(os.urandom(128))
        for host in ("slurmctld", *self._node_names):
            (self.folder / f"{host}.state").mkdir()
        # Nothing uses cgroups, but slurmd looks for a hierarchy at its start unless it is told which version to expect.
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        controller_port, *node_ports = free_ports(1 + len(self._node_names))
        settings = {
            **SETTINGS,
            "SlurmctldHost": "localhost(127.0.0.1)",
            "SlurmctldPort": controller_port,
            # A requeued task starts when its old credential is surely out of date.
            "AuthInfo": f"socket={self.socket},cred_expire=5",
            "StateSaveLocation": self.folder / "slurmctld.state",
            "SlurmctldPidFile": self.folder / "slurmctld.pid",
            "SlurmdSpoolDir": self.folder / "%n.state",
            "SlurmdPidFile": self.folder / "%n.pid",
            **self._settings,
        }
        lines = [f"{name}={value}" for name, value in settings.items()]
        lines += [f"NodeName={node} NodeHostname={node} NodeAddr=127.0.0.1 Port={port} CPUs={self._cpus}"
                  for node, port in zip(self._node_names, node_ports)]
        lines.append("PartitionName=all Nodes=ALL Default=YES")
        self.configuration.write_text("\n".join(lines) + "\n")


def free_ports(count):
    """Ports of the loopback that nobody listens on, below those that the system gives to outgoing connections."""
    first_outgoing = int(pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    ports = []
    for port in random.sample(range(first_outgoing // 2, first_outgoing), k=first_outgoing // 2):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) != 0:
                ports.append(port)
        if len(ports) == count:
            return ports
    raise RuntimeError(f"fewer than {count} free ports on 127.0.0.1")
