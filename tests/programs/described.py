"""What a program's --help names: the measure of its man page and completions."""
import functools
import os
import pathlib
import re
import subprocess

BIN = pathlib.Path(os.environ["VCD_BIN"])
SHARE = pathlib.Path(os.environ["VCD_BUILD"]) / "share"
PROGRAMS = sorted(p.name for p in BIN.glob("vc-*"))


def run(*command, **options):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=60, **options)


@functools.cache
def help_of(program, command=""):
    done = run(BIN / program, *([command] if command else []), "--help")
    assert done.returncode == 0, done.stderr
    return done.stdout


def section(text, title):
    match = re.search(rf"^{title}:\n((?:  .*\n)*)", text, re.M)
    return match.group(1) if match else ""


def commands_of(program):
    """Of the program itself, "", and of its subcommands."""
    return ["", *re.findall(r"^  (\S+)", section(help_of(program), "Subcommands"), re.M)]


def options_of(program, command=""):
    """Names of each option -> its type's text in the help, empty for a flag."""
    found = re.findall(r"^  (-\S+)(?: ((?! )\S+))?", help_of(program, command), re.M)
    return {tuple(names.split(",")): value for names, value in found}


def option_names(program, command=""):
    return {name for names in options_of(program, command) for name in names}


def names_after(program, command):
    """What may follow the subcommand: vc-bench takes its own options there too."""
    return option_names(program, command) | option_names(program)


def choices(value):
    """raw|ship -> {raw, ship}; what begins with a capital stands for something else."""
    words = value.split("|") if "|" in value else []
    return {word for word in words if not word[0].isupper()}
