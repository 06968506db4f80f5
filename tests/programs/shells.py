"""Asks bash, zsh and fish what they would complete with the scripts of the build."""
import os
import pty
import re
import select
import shlex
import subprocess
import time

from described import BIN, SHARE

BASH = SHARE / "bash-completion" / "completions"
ZSH = SHARE / "zsh" / "site-functions"
FISH = SHARE / "fish" / "vendor_completions.d"


def bash_answers(program, lines, folder="."):
    """The set offered for the last word of each line; --option=VALUE as bash splits it, in three words, and @FILE in two."""
    script = [f"source {shlex.quote(str(BASH / program))} || exit 1"]
    for line in lines:
        words = re.sub(r"(--\S+)=(\S*)", r"\1 = \2", line).replace(" @", " @ ").split(" ")
        if line.endswith(("=", "@")):
            words = words[:-1]  # the cursor is on the "=" or "@"
        quoted = " ".join(shlex.quote(w) for w in words)
        script.append(f"COMP_WORDS=({quoted}) COMP_CWORD={len(words) - 1}; _{program.replace('-', '_')}; "
                      "printf '%s\\n' \"${COMPREPLY[@]}\"; printf '\\f'")
    done = subprocess.run(["bash", "--norc", "-c", "\n".join(script)], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and not done.stderr, done.stderr
    answers = done.stdout.split("\f")[:-1]
    assert len(answers) == len(lines), done.stdout
    return [set(part.split()) for part in answers]


def fish_answers(program, lines, folder="."):
    script = [f"source {shlex.quote(str(FISH / program))}.fish; or exit 1"]
    script += [f"complete -C {shlex.quote(line)}; echo \\f" for line in lines]
    environment = dict(os.environ, PATH=f"{BIN}:{os.environ['PATH']}", HOME=str(folder), LC_ALL="C.UTF-8")
    done = subprocess.run(["fish", "--no-config", "-c", "\n".join(script)], cwd=folder, env=environment, capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == 0 and not done.stderr, done.stderr
    answers = done.stdout.split("\f")[:-1]
    assert len(answers) == len(lines), done.stdout
    return [{row.split("\t")[0] for row in part.split("\n") if row} for part in answers]


class Zsh:
    """An interactive zsh on a terminal: what a line becomes when tab is pressed at its end."""
    SETUP = ("PS1=; fpath=({folder} $fpath); autoload -Uz compinit; compinit -u -D; "
             "report() {{ print -r -- \"<<$BUFFER>>\"; BUFFER= }}; zle -N report; bindkey '^X' report; "
             "bindkey '^I' complete-word; print READ''Y\n")

    def __init__(self, folder):
        self.process, self.terminal = pty.fork()
        if self.process == 0:
            os.chdir(folder)
            os.environ.update(PATH=f"{BIN}:{os.environ['PATH']}", TERM="dumb", COLUMNS="200", HOME=str(folder))
            os.execvp("zsh", ["zsh", "-f", "-i"])
        os.write(self.terminal, self.SETUP.format(folder=shlex.quote(str(ZSH))).encode())
        self.read_until(r"READY\r?\n")

    def read_until(self, pattern):
        text, end = "", time.monotonic() + 30
        while not (match := re.search(pattern, text, re.S)):
            ready, _, _ = select.select([self.terminal], [], [], max(0, end - time.monotonic()))
            assert ready, f"zsh is silent after: {text}"
            text += os.read(self.terminal, 65536).decode(errors="replace")
        return match

    def completed(self, line):
        os.write(self.terminal, line.encode() + b"\t\x18")
        return self.read_until(r"<<([^\r\n]*)>>").group(1)

    def close(self):
        os.close(self.terminal)
        os.waitpid(self.process, 0)
