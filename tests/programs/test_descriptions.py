"""Man pages and completions, held against what --help says."""
import pathlib
import re
import shutil
import tempfile
import unittest

from described import BIN, PROGRAMS, SHARE, choices, commands_of, help_of, names_after, option_names, options_of, run
from shells import FISH, ZSH, Zsh, bash_answers, fish_answers

MAN = SHARE / "man" / "man1"
MESHES = {"a.glb", "b.gltf", "c.drc", "d.obj", "e.ply", "f.stl", "g.off", "H.OBJ"}
FILES = sorted(MESHES | {"i.vcd", "d.txt"})


def plain(troff):
    """Troff -> what is read."""
    text = re.sub(r"\\f[BIR]", "", troff)
    for escape, character in ((r"\-", "-"), (r"\(aq", "'"), (r"\(rs", "\\"), (r"\(ga", "`"), (r"\(ha", "^"), (r"\(ti", "~"), (r"\&", "")):
        text = text.replace(escape, character)
    return text


class Help(unittest.TestCase):
    def test_choices_stand_in_the_type_name_alone(self):
        for program in PROGRAMS:
            for command in commands_of(program):
                with self.subTest(program=program, command=command):
                    self.assertNotIn(":{", help_of(program, command), "a check lists its words: description(\"\") and type_name")


class ManPages(unittest.TestCase):
    def page(self, program):
        return (MAN / f"{program}.1").read_text()

    def test_name_every_option_of_the_help_and_no_other(self):
        for program in PROGRAMS:
            for command in commands_of(program):
                with self.subTest(program=program, command=command):
                    part, _, of_commands = plain(self.page(program)).partition("\n.SH COMMANDS\n")
                    if command:
                        part = re.search(rf'^\.SS "{command}"\n(.*?)(?=^\.S)', of_commands, re.M | re.S).group(1)
                    heads = re.findall(r"^\.TP\n(-.*)$", part, re.M)
                    self.assertEqual({n for head in heads for n in re.findall(r"(?:^|, )(--?[\w-]+)", head)},
                                     option_names(program, command))

    def test_say_what_the_help_says(self):
        for program in PROGRAMS:
            page = " ".join(plain(self.page(program)).split())
            for command in commands_of(program):
                # "  --name TYPE in [LOW - HIGH] ...", a gap or a line end, and the description, in lines.
                texts = re.findall(r"^  -\S+(?: (?! )\S+(?: in \[\S+ - \S+\])?(?: \.\.\.)?(?: REQUIRED)?(?: Excludes: \S+)?)?\s+(\S.*?)(?=\n  \S|\n\n|\Z)",
                                   help_of(program, command), re.M | re.S)
                self.assertEqual(len(texts), len(options_of(program, command)))
                for text in texts:
                    self.assertIn(" ".join(text.split()), page, f"{program} {command}")
            self.assertIn(" ".join(help_of(program).partition("Exit codes:")[2].split()), page)

    def test_synopsis_has_what_is_required(self):
        self.assertIn("vc-scene [OPTIONS] -o PATH sierpinski|hairball|forest\n", plain(self.page("vc-scene")))
        self.assertIn("vc-bench [OPTIONS]\n.br\nvc-bench report [OPTIONS] DIR\n", plain(self.page("vc-bench")))

    def test_show_choices(self):
        for program in PROGRAMS:
            for names, value in options_of(program).items():
                if choices(value):
                    self.assertRegex(plain(self.page(program)), re.escape(f"{names[-1]} {value}") + r"(\n|\[)")

    def test_pass_the_checkers_that_are_there(self):
        checkers = {"mandoc": ["mandoc", "-Tlint", "-Wwarning"], "groff": ["groff", "-man", "-Tutf8", "-ww", "-z"],
                    "man": ["man", "--warnings", "-l", "-P", "true"]}
        there = [command for name, command in checkers.items() if shutil.which(name)]
        if not there:
            self.skipTest("neither mandoc nor groff nor man is installed")
        for command in there:
            done = run(*command, *(MAN / f"{program}.1" for program in PROGRAMS))
            complaints = [line for line in (done.stdout + done.stderr).splitlines() if command[0] != "man" or re.search(r":\d+: warning", line)]
            # A date would change from build to build.
            self.assertEqual([line for line in complaints if "missing date" not in line], [], command[0])

    def test_are_those_of_the_programs(self):
        for program in PROGRAMS:
            self.assertEqual(run(BIN / program, "--print-man").stdout, self.page(program))

    def test_can_be_refused(self):
        done = run(BIN / "vc-info", "--print-completion", "tcsh")
        self.assertEqual(done.returncode, 1)
        self.assertIn("--print-completion: one shell: bash, zsh or fish", done.stderr)
        with open("/dev/full", "w") as full:
            done = run("sh", "-c", f"{BIN}/vc-info --print-man > /dev/full")
        self.assertEqual((done.returncode, done.stderr), (2, "error: cannot write to standard output\n"))


class Completions(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        for name in FILES:
            (self.folder / name).touch()
        (self.folder / "k").mkdir()

    def assert_all_options(self, answers):
        """answers(program, lines) -> a set for each line."""
        for program in PROGRAMS:
            commands = commands_of(program)
            lines = [f"{program} {command} -".replace("  ", " ") for command in commands]
            long_lines = [line + "-" for line in lines]
            for command, short, long in zip(commands, answers(program, lines), answers(program, long_lines)):
                with self.subTest(program=program, command=command):
                    expected = names_after(program, command)
                    self.assertEqual(short | long, expected)
                    self.assertEqual({name for name in long if name.startswith("--")}, {n for n in expected if n.startswith("--")})

    def assert_all_choices(self, answers):
        for program in PROGRAMS:
            options = {names[-1]: choices(value) for names, value in options_of(program).items() if choices(value)}
            self.assertIn("--format", options)
            for name, offered in zip(options, answers(program, [f"{program} {name} " for name in options])):
                self.assertEqual(offered, options[name] | (offered if "MESH" in options_of(program).get((name,), "") else set()),
                                 f"{program} {name}")

    def assert_files(self, answers):
        meshes, sidecars = MESHES | {"k"}, {"i.vcd", "k"}
        scenes = meshes | {"sierpinski", "hairball", "forest"}
        for line, expected in (("vc-bake ", meshes), ("vc-bake --plan d.obj ", meshes), ("vc-bake -o i.vcd ", meshes),
                               ("vc-bake -o ", set(FILES) | {"k"}), ("vc-info ", sidecars), ("vc-verify ", sidecars),
                               ("vc-verify --against ", meshes), ("vc-info --repack=", set(FILES) | {"k"}),
                               ("vc-render ", scenes), ("vc-render --sidecar ", sidecars), ("vc-bake -j ", set()),
                               ("vc-bench -o ", {"k"}), ("vc-bench bake-rate ", meshes), ("vc-bench --size 9x9 -o k report ", {"k"}),
                               ("vc-scene ", {"sierpinski", "hairball", "forest"})):
            (offered,) = answers(line.split()[0], [line])
            self.assertEqual({name.rstrip("/").replace("--repack=", "") for name in offered}, expected, line)

    def bash(self, program, lines):
        return bash_answers(program, lines, self.folder)

    def test_bash_offers_every_option(self):
        self.assert_all_options(self.bash)

    def test_bash_offers_choices(self):
        self.assert_all_choices(self.bash)
        self.assertEqual(self.bash("vc-bake", ["vc-bake --emb", "vc-bake --storage s", "vc-bake --storage=s", "vc-bake --storage="]),
                         [{"--embed-geometry"}, {"ship"}, {"ship"}, {"raw", "ship"}])
        self.assertEqual(self.bash("vc-render", ["vc-render --views shaded,f"]), [{"shaded,fallback"}])

    def test_bash_offers_files_that_fit(self):
        self.assert_files(self.bash)
        self.assertEqual(self.bash("vc-bench", ["vc-bench segments ", "vc-bench segments i.vcd "]),
                         [{"i.vcd", "k"}, MESHES | {"k"}])

    def test_bash_offers_lists_of_files(self):
        self.assertEqual(self.bash("vc-bake", ["vc-bake @d", "vc-bake @", "vc-bake @d.txt a"]),
                         [{"@d.obj", "@d.txt"}, {"@" + name for name in (*FILES, "k")}, {"a.glb"}])

    def test_bash_offers_subcommands(self):
        self.assertEqual(self.bash("vc-bench", ["vc-bench ", "vc-bench --quick -j 2 seg"]),
                         [set(commands_of("vc-bench")) - {""}, {"segments"}])

    def test_zsh_and_fish_name_every_option(self):  # whether or not they are installed
        for program in PROGRAMS:
            zsh, fish = (ZSH / f"_{program}").read_text(), (FISH / f"{program}.fish").read_text()
            for command in commands_of(program):
                for name in option_names(program, command):
                    self.assertRegex(zsh, rf"\){name}[+=]?\[|\*{name}[+=]?\[", program)
                    self.assertRegex(fish, rf" -l {name[2:]} " if name.startswith("--") else rf" -s {name[1:]} ", program)

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish(self):
        def answers(program, lines):
            return fish_answers(program, lines, self.folder)
        self.assert_all_options(answers)
        self.assert_all_choices(answers)
        self.assert_files(answers)
        self.assertEqual(answers("vc-bench", ["vc-bench --size 9x9 "]), [set(commands_of("vc-bench")) - {""}])
        self.assertEqual(answers("vc-render", ["vc-render --views shaded,f"]), [{"shaded,fallback"}])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh(self):
        for program in PROGRAMS:
            self.assertEqual(run("zsh", "-n", ZSH / f"_{program}").stderr, "")
        zsh = Zsh(self.folder)
        self.addCleanup(zsh.close)
        for line, completed in (("vc-bake --emb", "vc-bake --embed-geometry "), ("vc-bake --storage=s", "vc-bake --storage=ship "),
                                ("vc-bake --storage s", "vc-bake --storage ship "), ("vc-bake d", "vc-bake d.obj "),
                                ("vc-bake -o d.t", "vc-bake -o d.txt "), ("vc-info i", "vc-info i.vcd "),
                                ("vc-bake d.obj H", "vc-bake d.obj H.OBJ "), ("vc-render --views shaded,f", "vc-render --views shaded,fallback,"),
                                ("vc-bench --quick seg", "vc-bench --quick segments "), ("vc-bench segments --obj", "vc-bench segments --object="),
                                ("vc-bench segments i.vcd d", "vc-bench segments i.vcd d.obj "), ("vc-scene f", "vc-scene forest "),
                                ("vc-bench segments --qui", "vc-bench segments --qui"), ("vc-render sier", "vc-render sierpinski "),
                                ("vc-render e", "vc-render e.ply ")):
            self.assertEqual(zsh.completed(line).rstrip(), completed.rstrip(), line)


if __name__ == "__main__":
    unittest.main()
