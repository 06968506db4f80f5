"""Compiles the C++ of README.md against the public headers."""
import pathlib
import re
import subprocess
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
# What the text leaves to the reader's program.
PRESUPPOSED = """
int fail(std::string_view message);
bool bvh_occluded(const vcd::Segment& segment);
int renders(float ox, float oy, float oz, float dx, float dy, float dz) {
"""


def blocks():
    return re.findall(r"^```cpp\n(.*?)^```$", (PROJECT / "README.md").read_text(), re.M | re.S)


def compiles(block):
    lines = block.splitlines()
    includes = [line for line in lines if line.startswith("#include")]
    body = [line for line in lines if not line.startswith("#include")]
    program = "\n".join(["#include <string_view>", *includes, PRESUPPOSED, *body, "(void)dark;", "return 0;", "}"])
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "readme.cpp"
        file.write_text(program)
        return subprocess.run(["c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
                               f"-I{PROJECT / 'format' / 'include'}", f"-I{PROJECT / 'runtime' / 'include'}", file],
                              capture_output=True, text=True)


class Readme(unittest.TestCase):
    def test_code_compiles(self):
        self.assertTrue(blocks())
        for block in blocks():
            self.assertEqual(compiles(block).stderr, "")

    def test_what_does_not_compile_is_found(self):
        wrong = blocks()[0].replace("Sidecar::open", "Sidecar::open_it")
        self.assertIn("open_it", compiles(wrong).stderr)


if __name__ == "__main__":
    unittest.main()
