"""Installs the build into a temporary prefix and builds outsiders against it, which link the runtime alone."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from assets import write_assets

HERE = pathlib.Path(__file__).resolve().parent
EXPORTER = HERE.parents[1] / "examples" / "export_sidecar.cpp"
GOLDEN = HERE.parent / "golden" / "several.vcd"
FOREIGN = ("embree", "OpenMesh", "draco", "tinygltf", "tbb", "meshopt")


def run(*command, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.prefix = pathlib.Path(cls.folder.name) / "prefix"
        build = pathlib.Path(os.environ["VCD_BUILD"])
        run("cmake", "--install", build, "--prefix", cls.prefix)
        flags = [line.split("=", 1)[1] for line in (build / "CMakeCache.txt").read_text().splitlines()
                 if line.startswith("CMAKE_CXX_FLAGS:")]
        cls.flags = flags[0] if flags else ""  # the libraries may be built with sanitizers

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def assert_links_no_foreigner(self, program):
        libraries = run("ldd", program)
        for name in FOREIGN:
            self.assertNotIn(name, libraries)

    def test_cmake_consumer(self):
        build = pathlib.Path(self.folder.name) / "cmake"
        run("cmake", "-S", HERE / "consumer", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}",
            f"-DCMAKE_CXX_FLAGS={self.flags}", f"-DCMAKE_C_FLAGS={self.flags}")
        run("cmake", "--build", build)
        self.assertRegex(run(build / "consumer", GOLDEN), r"^4 objects, (not )?blocked\n$")
        self.assert_links_no_foreigner(build / "consumer")
        needs = run("nm", "-D", "--undefined-only", build / "consumer")
        self.assertIn("ZSTD_decompress", needs)
        for name in ("ZSTD_compress", "linkat", "fsync"):  # what only vcd::writer calls
            self.assertNotIn(name, needs)
        self.assertRegex(run(build / "writes", build / "empty.vcd"), r"^\d+ bytes\n$")
        self.assertIn("0 objects", run(self.prefix / "bin" / "vc-info", build / "empty.vcd"))

    def test_cmake_exporter(self):
        build = pathlib.Path(self.folder.name) / "exporter"
        run("cmake", "-S", HERE / "exporter", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        run("cmake", "--build", build)
        self.assert_exports(build / "export_sidecar")

    def test_pkg_config_exporter(self):
        program, _ = self.build_with("vcd-baker", "c++", "-std=c++20", EXPORTER)
        self.assert_exports(program)

    def assert_exports(self, program):
        run(program, program.with_suffix(".vcd"))
        self.assertIn("pyramid", run(self.prefix / "bin" / "vc-info", program.with_suffix(".vcd")))
        libraries = run("ldd", program)
        for name in ("OpenMesh", "meshopt"):  # what only readers of mesh files need
            self.assertNotIn(name, libraries)

    def test_headers_of_the_runtime_allow_fast_math(self):
        run("c++", "-std=c++20", "-Ofast", "-march=native", "-fsyntax-only", f"-I{self.prefix}/include", HERE / "consumer" / "main.cpp")

    def build_with(self, package, *compile_source):
        pc = next(self.prefix.rglob(f"{package}.pc"))
        flags = run("pkg-config", "--cflags", "--libs", package, env=dict(os.environ, PKG_CONFIG_PATH=str(pc.parent))).split()
        program = pathlib.Path(self.folder.name) / package
        run(*compile_source, *self.flags.split(), "-o", program, *flags)
        return program, pc.parent.parent

    def test_pkg_config_links_the_shared_library(self):
        program, libraries = self.build_with("vcd", "cc", HERE / "consumer" / "main.c")
        environment = dict(os.environ, LD_LIBRARY_PATH=str(libraries))
        self.assertEqual(run(program, GOLDEN, env=environment), "4 objects, 0\n")
        self.assertIn(f"libvcd.so.0 => {libraries}/libvcd.so.0", run("ldd", program, env=environment))
        self.assert_links_no_foreigner(program)

    def test_pkg_config_links_the_static_libraries(self):
        program, _ = self.build_with("vcd-static", "cc", HERE / "consumer" / "main.c")
        self.assertEqual(run(program, GOLDEN), "4 objects, 0\n")
        self.assert_links_no_foreigner(program)

    def test_the_shared_library_exports_what_is_listed_and_the_headers_declare(self):
        library = next(self.prefix.rglob("libvcd.so.0"))
        exported = {line.split()[-1].split("@")[0] for line in run("nm", "-D", "--defined-only", library).splitlines()
                    if line.split()[-2] != "A"}  # the name of the version
        head, *lines = (HERE.parents[1] / "packages" / "libvcd0.symbols").read_text().splitlines()
        self.assertEqual(head, "libvcd.so.0 libvcd0 #MINVER#")
        listed = {line.split("@")[0].strip() for line in lines}
        self.assertEqual(exported, {name for name in listed if name != "VCD_0"})
        declared = {name for header in ("vcd.h", "version.h") for name in re.findall(
            r"^[a-z].*?\b(vcd_\w+)\((?!\*)", (self.prefix / "include/vcd/runtime" / header).read_text(), re.M)}
        self.assertEqual(exported, declared)
        self.assertIn("[libvcd.so.0]", run("readelf", "-d", library))

    def test_a_debian_package_is_made(self):
        if not shutil.which("dpkg-shlibdeps"):
            self.skipTest("needs dpkg-dev")
        folder = pathlib.Path(self.folder.name) / "packages"
        run("cpack", "-G", "DEB", "--config", pathlib.Path(os.environ["VCD_BUILD"]) / "CPackConfig.cmake", "-B", folder,
            "-D", "CPACK_COMPONENTS_ALL=library")
        package, = folder.glob("*.deb")
        self.assertRegex(package.name, r"^libvcd0_[0-9.]+_\w+\.deb$")
        self.assertIn("libzstd1", run("dpkg-deb", "-f", package, "Depends"))
        self.assertIn("libvcd.so.0 libvcd0", run("dpkg-deb", "-I", package, "symbols"))
        self.assertIn("/libvcd.so.0 ->", run("dpkg-deb", "-c", package))

    def test_cmake_package_bakes(self):
        assets = pathlib.Path(self.folder.name) / "assets"
        assets.mkdir()
        write_assets(assets)
        run("cmake", "-S", HERE / "baked", "-B", assets / "build", "-G", "Ninja", f"-DVCD_PACKAGE={self.prefix}", f"-DASSETS={assets}")
        self.assertIn(f"{self.prefix}/bin/vc-bake", run("ninja", "-C", assets / "build", "-t", "commands", "sidecars"))

    def test_completions_are_there_and_man_pages_where_help2man_is(self):
        files = ["bash-completion/completions/{}", "zsh/site-functions/_{}"] + ["man/man1/{}.1"] * bool(shutil.which("help2man"))
        for program in ("vc-bake", "vc-farm", "vc-info", "vc-verify"):
            for file in files:
                self.assertGreater((self.prefix / "share" / file.format(program)).stat().st_size, 0)

    def test_programs_and_headers_are_there(self):
        for program in ("vc-bake", "vc-verify", "vc-info", "vc-bench"):
            self.assertIn("vcd 1.", run(self.prefix / "bin" / program, "--version"))
        headers = {str(p.relative_to(self.prefix / "include")) for p in (self.prefix / "include").rglob("*.h")}
        self.assertIn("vcd/runtime/vcd.h", headers)
        self.assertIn("vcd/runtime/embree.h", headers)
        self.assertEqual([h for h in headers if h.startswith("vcd/baker")], ["vcd/baker/bake_sidecar.h"])


if __name__ == "__main__":
    unittest.main()
