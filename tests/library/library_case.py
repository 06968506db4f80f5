"""What the tests of libraries share: a folder of meshes, vc-bake on it, and what came of it."""
import hashlib
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import make_library

BIN = pathlib.Path(os.environ["VCD_BIN"])
FAST = ("--depth", "2", "--audit", "9000")


def processes_of(session):
    """Those that live in a session, zombies too."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(stat.read_text(errors="replace").rpartition(")")[2].split()[3]) == session:
                found.append(int(stat.parent.name))
        except OSError:
            pass
    return found


class Case(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name).resolve()
        self.library = self.folder / "library"
        self.library.mkdir()

    def bake(self, *arguments, code=0, settings=FAST, **options):
        done = subprocess.run([BIN / "vc-bake", *map(str, arguments), *settings], capture_output=True, text=True, errors="surrogateescape", timeout=600, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def report(self, *arguments, code=0, settings=FAST):
        return json.loads(self.bake(*arguments, "--format", "json", code=code, settings=settings).stdout)

    def fates(self, *arguments, code=0):
        return {pathlib.Path(f["input"]).name: f["fate"] for f in self.report(*arguments, code=code)["files"]}

    def mesh(self, name="a.obj", seed=1):
        path = self.library / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(make_library.WRITERS[path.suffix](*make_library.shape(seed)))
        return path

    def gltf(self, name="a", seed=1):
        text, data = make_library.gltf_parts(*make_library.shape(seed), uri=f"{name}.bin")
        (self.library / f"{name}.gltf").write_bytes(text)
        (self.library / f"{name}.bin").write_bytes(data)
        return self.library / f"{name}.gltf"

    def files(self, folder=None):
        folder = folder or self.library
        return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())

    def bytes(self, folder):
        return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in self.files(folder)}
