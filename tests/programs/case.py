"""What the tests of programs share: running one, a small mesh, a soup."""
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["VCD_BIN"])
GOLDEN = pathlib.Path(__file__).resolve().parents[1] / "golden"

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SMALL = ("--depth", "3", "--method", "sampled", "--samples", "16", "--audit", "9000")


class Case(unittest.TestCase):
    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.holder.name)
        self.addCleanup(self.holder.cleanup)

    def run_program(self, program, *arguments, code=0, **options):
        if not (BIN / program).exists():
            self.skipTest(f"{program} is not built here")
        done = subprocess.run([BIN / program, *map(str, arguments)], capture_output=True, text=True, timeout=600,
                              errors="surrogateescape", **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def mesh(self, name="tetrahedron.obj", text=TETRAHEDRON):
        path = self.folder / name
        path.write_text(text)
        return path

    def baked(self, *options, name="tetrahedron.obj", text=TETRAHEDRON):
        mesh = self.mesh(name, text)
        depth = () if "--depth" in options else ("--depth", "3")
        audit = () if "--audit" in options else ("--audit", "9000")
        self.run_program("vc-bake", mesh, "-q", "--method", "sampled", "--samples", "16", *depth, *audit, *options)
        return mesh, mesh.with_name(mesh.name + ".vcd")

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())


def soup(triangles, seed=1):
    rng = random.Random(seed)
    lines = []
    for _ in range(triangles):
        base = [rng.uniform(0, 4) for _ in range(3)]
        lines += ["v " + " ".join(f"{x + rng.uniform(0, 0.4):.6f}" for x in base) for _ in range(3)]
    return "\n".join(lines + [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(triangles)]) + "\n"
