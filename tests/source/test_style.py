"""Holds C and C++ files to .clang-format, with the version of clang-format that formatted them."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
VERSION = "14."  # others break lines elsewhere
FOLDERS = ("baker", "examples", "format", "preload", "python", "recorder", "runtime", "tests", "tools", "writer")


def complaints(files):
    done = subprocess.run(["clang-format", "--dry-run", "--Werror", f"--style=file:{PROJECT / '.clang-format'}", *files],
                          capture_output=True, text=True)
    return done.stderr


class Style(unittest.TestCase):
    def setUp(self):
        version = shutil.which("clang-format") and subprocess.check_output(["clang-format", "--version"], text=True)
        if not version or f" {VERSION}" not in version:
            self.skipTest(f"needs clang-format {VERSION}x; tools/install_dependencies.sh test installs it")

    def test_files_are_formatted(self):
        files = [file for folder in FOLDERS for suffix in ("h", "c", "cpp")
                 for file in (PROJECT / folder).rglob(f"*.{suffix}")]
        self.assertGreater(len(files), 300)
        self.assertEqual(complaints(files), "")

    def test_what_is_not_formatted_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.cpp"
            file.write_text("int  a;\n")
            self.assertIn("a.cpp:1", complaints([file]))


if __name__ == "__main__":
    unittest.main()
