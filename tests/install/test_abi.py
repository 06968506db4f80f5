"""The C interface of libvcd.so.0 is the one of packages/libvcd0.abi: needs abidiff (Debian: abigail-tools).

After functions were added, or members at the end of a struct that begins with its size:

    VCD_WRITE_ABI=1 ctest --preset release -R abi
"""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
STORED = PROJECT / "packages" / "libvcd0.abi"
LIBRARY = pathlib.Path(os.environ["VCD_BUILD"]) / "lib" / "libvcd.so.0"
# Types that the headers declare, and nothing else: no handle's inside, no place in a file.
OPTIONS = ("--headers-dir", PROJECT / "runtime/include/vcd/runtime", "--drop-private-types", "--exported-interfaces-only",
           "--no-corpus-path", "--no-comp-dir-path", "--no-show-locs", "--no-architecture", "--no-elf-needed",
           "--type-id-style", "hash")


def description():
    done = subprocess.run(["abidw", *OPTIONS, LIBRARY], check=True, capture_output=True, text=True)
    return re.sub(r" path='[^']*/", " path='", done.stdout)


def difference(old, new):
    """What abidiff says of two descriptions; empty where they are the same to a program."""
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / name for name in ("old.abi", "new.abi")]
        for file, text in zip(files, (old, new)):
            file.write_text(text)
        done = subprocess.run(["abidiff", *files], capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert done.returncode & ~12 == 0, said  # bits: 4, a difference; 8, one that breaks programs; others: it failed
    return said if done.returncode else ""


@unittest.skipUnless(shutil.which("abidiff"), "needs abidiff (Debian: abigail-tools)")
class Abi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.library = description()
        if os.environ.get("VCD_WRITE_ABI"):
            STORED.write_text(cls.library)

    def test_interface_is_the_stored_one(self):
        said = difference(STORED.read_text(), self.library)
        self.assertFalse(said, said + __doc__)

    def test_other_interfaces_are_found(self):
        for what, old, new in (
                ("a function that is gone", "name='vcd_close'", "name='vcd_shut'"),
                ("a struct of another size", "name='vcd_segment' size-in-bits='256'", "name='vcd_segment' size-in-bits='512'"),
                ("a constant of another value", "name='VCD_CHECK_BOUNDS' value='1'", "name='VCD_CHECK_BOUNDS' value='7'")):
            self.assertIn(old, self.library)
            self.assertTrue(difference(self.library.replace(old, new), self.library), what)


if __name__ == "__main__":
    unittest.main()
