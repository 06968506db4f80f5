"""A daemon in a small machine of its own: own processes, own host name. Killing it is a power loss: nothing survives.

Needs root and util-linux's unshare and setpriv.
"""
import os
import pathlib
import signal
import subprocess

# The first process of the namespace, so that the kernel kills all others with it; it reaps what daemons orphan.
# /proc must show the namespace's processes, as daemons look for their children there; others' /proc stays as it is.
FIRST = 'hostname "$0" && mount --make-private /proc && mount -t proc proc /proc || exit 1; "$@"; exit $?'
ISOLATED = ("setpriv", "--pdeathsig", "KILL", "unshare", "--pid", "--mount", "--uts", "--propagation", "unchanged",
            "--fork", "--kill-child", "sh", "-c", FIRST)
PROGRAMS = ("setpriv", "unshare", "sh", "hostname", "mount")


def refusal():
    """Why this machine cannot isolate a daemon, or None."""
    if os.geteuid() != 0:
        return "not root"
    done = subprocess.run([*ISOLATED, "trial", "true"], capture_output=True, text=True)
    return None if done.returncode == 0 else f"no namespaces of its own for a daemon: {done.stderr.strip()}"


class Daemon:
    """Dies with the thread that started it, whatever ends that. Not for several threads at once."""

    def __init__(self, host, arguments, output, environment):
        """host: the name of its machine. output: the file to which it writes what it says, appended over restarts."""
        self.command = [*ISOLATED, host, *map(str, arguments)]
        self.output, self.environment = pathlib.Path(output), environment
        self.process = None

    def start(self):
        with open(self.output, "ab") as output:
            self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                            env=self.environment, start_new_session=True)

    def kill(self):
        """Kills it and all that it started, at once; on return they are gone."""
        if self.process is None:
            return
        try:
            # The first process ends last: when unshare has waited for it, none is left.
            firsts = self._children_of(self.process.pid)
            for first in firsts:
                os.kill(first, signal.SIGKILL)
            if not firsts:
                self.process.kill()
        finally:
            self.process.wait()
            self.process = None

    def stop(self, seconds=30):
        """Asks it to end, and waits until it has saved what it wants to. subprocess.TimeoutExpired when it does not."""
        os.kill(self._pid(), signal.SIGTERM)
        self.process.wait(seconds)
        self.process = None

    def freeze(self):
        """The daemon alone stops where it is and answers nobody, until it is killed; what it started goes on."""
        os.kill(self._pid(), signal.SIGSTOP)

    def failed(self):
        """Whether it ended though nobody killed it."""
        return self.process is not None and self.process.poll() is not None

    def last_words(self, lines=12):
        text = self.output.read_text(errors="replace") if self.output.exists() else ""
        return f"{self.output.name}:\n" + "\n".join("  " + line for line in text.splitlines()[-lines:])

    def _pid(self):
        name = pathlib.Path(self.command[len(ISOLATED) + 1]).name
        (first,) = self._children_of(self.process.pid)
        (pid,) = [p for p in self._children_of(first) if pathlib.Path(f"/proc/{p}/comm").read_text().strip() == name]
        return pid

    @staticmethod
    def _children_of(pid):
        try:
            return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
        except (FileNotFoundError, ProcessLookupError):
            return []
