"""What vc-bake and its kin read and write: links, folders that cannot be written, files that a mesh names, lists, names."""
import os
import pathlib
import subprocess
import time
import unittest

from library_case import BIN, Case


class Outputs(Case):
    def link(self, name, target):
        path = self.library / name
        path.symlink_to(target)
        return path

    def test_no_output_goes_through_a_link(self):
        mesh = self.mesh()
        victim = self.folder / "victim"
        victim.write_text("precious")
        for target in (victim, "nowhere"):
            link = self.link("a.obj.vcd", target)
            self.assertIn("a.obj.vcd: is a link to ", self.bake(mesh, code=2).stderr)
            self.assertTrue(link.is_symlink())
            link.unlink()
        for option, name in (("--events", "events"), ("--depfile", "depfile"), ("--report", "report.json")):
            link = self.link(name, victim)
            done = self.bake(mesh, option, str(link).removesuffix(".json"), code=2 if option == "--events" else 9)
            self.assertIn("is a link", done.stderr)
            link.unlink()
        self.assertEqual(victim.read_text(), "precious")
        self.assertEqual(self.files(), ["a.obj", "a.obj.vcd"])

    def test_a_link_to_a_sidecar_stays_and_the_sidecar_is_replaced(self):
        mesh = self.mesh()
        (self.folder / "store").mkdir()
        store = self.folder / "store" / "one.vcd"
        self.bake(mesh, "-o", store)
        link = self.link("a.obj.vcd", store)
        before = store.read_bytes()
        self.bake(mesh, "--seed", 7)
        self.assertTrue(link.is_symlink())
        self.assertNotEqual(store.read_bytes(), before)

    def test_a_cache_entry_that_is_a_link_is_not_written_through(self):
        mesh, cache = self.mesh(), self.folder / "cache"
        self.bake(mesh, "--cache", cache)
        entry, = (p for p in cache.rglob("*.vcd"))
        victim = self.folder / "victim"
        victim.write_text("precious")
        entry.unlink()
        entry.symlink_to(victim)
        self.assertIn("not kept in the cache", self.bake(mesh, "--cache", cache).stderr)
        self.assertEqual(victim.read_text(), "precious")

    def test_what_cannot_be_written_is_found_before_the_bake(self):
        mesh = self.mesh("a.obj", 3)
        long_name = self.mesh("n" * 249 + ".obj", 3)
        blocked = self.folder / "file"
        blocked.write_text("")
        for arguments, reason in (((long_name,), "File name too long"), ((mesh, "-o", "/proc/nowhere"), "/proc"),
                                  ((mesh, "-o", blocked / "below"), "file is not a folder")):
            events = self.folder / "events"
            done = self.bake(*arguments, "--events", events, code=2, settings=("--depth", "8", "--method", "proven", "--time-limit", "20"))
            self.assertIn(reason, done.stderr)
            self.assertNotIn("baking", events.read_text())

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_a_folder_without_permission_is_found_before_the_bake(self):
        mesh = self.mesh()
        self.library.chmod(0o555)
        self.addCleanup(self.library.chmod, 0o755)
        self.assertIn("Permission denied", self.bake(mesh, code=2, settings=("--depth", "8")).stderr)


class NamedFiles(Case):
    def test_a_buffer_outside_the_folder_is_read_only_if_allowed(self):
        mesh = self.gltf("a")
        inner = self.library / "inner"
        inner.mkdir()
        moved = inner / "a.gltf"
        moved.write_text((self.library / "a.gltf").read_text().replace("a.bin", "../a.bin"))
        done = self.bake(moved, code=5)
        self.assertIn('the uri "../a.bin" leads out of the file\'s folder', done.stderr)
        self.bake(moved, "--allow-outside-files")
        sidecar = f"{moved}.vcd"
        for allowed, code in ((), 2), (("--allow-outside-files",), 0):
            done = subprocess.run([BIN / "vc-verify", sidecar, "--against", moved, *allowed, "--lines", "9000"], capture_output=True, text=True)
            self.assertEqual(done.returncode != 0, bool(code), done.stdout + done.stderr)


class Inputs(Case):
    def test_lists_with_a_byte_order_mark_and_folders_with_brackets(self):
        self.mesh("lib [v2]/a.obj")
        listed = self.folder / "list"
        listed.write_bytes(b"\xef\xbb\xbf" + str(self.library / "lib [v2]" / "a.obj").encode() + b"\r\n")
        self.bake(f"@{listed}")
        self.bake(self.library / "lib [v2]" / "*.obj")
        listed.write_bytes("a.obj".encode("utf-16"))
        self.assertIn("UTF-16", self.bake(f"@{listed}", code=1).stderr)
        self.assertIn("-: meshes are not read from standard input", self.bake("-", code=1).stderr)


if __name__ == "__main__":
    unittest.main()
