"""--help lists every option, and help2man makes a sound man page of it."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

BIN = pathlib.Path(os.environ["VCD_BIN"])
TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
PROGRAMS = ("vc-bake", "vc-farm", "vc-info", "vc-verify")


def output(*command, **options):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=True, **options).stdout


def named_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text))


class Help(unittest.TestCase):
    def test_lists_every_option(self):
        for program in PROGRAMS:
            source = (TOOLS / f"{program.replace('-', '_')}.cpp").read_text()
            defined = named_in(" ".join(re.findall(r'add_(?:option|flag)\(\s*"([^"]+)"', source)))
            with self.subTest(program):
                self.assertGreater(len(defined), 1)
                self.assertEqual(defined - named_in(output(BIN / program, "--help-all")), set())
                self.assertIn("Exit codes:", output(BIN / program, "--help"))

    def test_choices_stand_in_the_type_name_alone(self):
        for program in PROGRAMS:
            self.assertNotIn(":{", output(BIN / program, "--help-all"), "a check lists its words: description(\"\") and type_name")


class ManPage(unittest.TestCase):
    @unittest.skipUnless(shutil.which("help2man"), "no help2man")
    def test_is_sound_and_names_what_the_help_names(self):
        for program in PROGRAMS:
            with self.subTest(program):
                page = output("help2man", "--no-info", "--help-option=--help-all", "--name=x", BIN / program)
                for section in ("NAME", "SYNOPSIS", "DESCRIPTION"):
                    self.assertIn(f"\n.SH {section}\n", page)
                self.assertIn("Exit codes", page)
                self.assertEqual(named_in(output(BIN / program, "--help-all")) - named_in(re.sub(r"\\f.", "", page).replace("\\-", "-")), set())
                if shutil.which("groff"):
                    warnings = subprocess.run(["groff", "-man", "-Tascii", "-ww", "-z"], input=page, capture_output=True, text=True, check=True).stderr
                    self.assertEqual(warnings, "")


if __name__ == "__main__":
    unittest.main()
