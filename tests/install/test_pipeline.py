"""vcd_bake() of the CMake package, and the examples: what is baked, what is baked again, and what is not."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

from assets import TETRAHEDRON, write_assets, write_bin

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[1]
EXAMPLES = SOURCE / "spec" / "examples"
BIN = pathlib.Path(os.environ["VCD_BIN"])
BUILD = pathlib.Path(os.environ["VCD_BUILD"])
ENVIRONMENT = dict(os.environ, PATH=f"{BIN}:{os.environ['PATH']}")


def run(*command, code=0, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env=ENVIRONMENT, timeout=300, **options)
    assert done.returncode == code, f"{command}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout + done.stderr


HAS_DEPFILE = "--depfile" in run(BIN / "vc-bake", "--help")
HAS_REPORTS = "--sarif" in run(BIN / "vc-verify", "--help")


class Case(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        write_assets(self.folder)

    def assert_rebaked(self, build, sidecars, expected):
        """Those of the sidecars that `build` writes are the expected ones. Returns what it printed."""
        time.sleep(0.02)  # a file that is written now is newer than what was
        before = [path.stat().st_ino for path in sidecars]  # a baked sidecar is a new file
        out = build()
        after = [path.stat().st_ino for path in sidecars]
        self.assertEqual([path.name for path, a, b in zip(sidecars, before, after) if a != b], expected, out)
        return out

    def assert_bakes_what_changes(self, build, one, two):
        build()
        for sidecar in (one, two):
            run(BIN / "vc-verify", "-q", sidecar)
        self.assert_rebaked(build, [one, two], [])
        content = two.read_bytes()
        write_bin(self.folder, height=2.0)
        self.assert_rebaked(build, [one, two], [two.name])
        self.assertNotEqual(two.read_bytes(), content)
        (self.folder / "one.obj").write_text(TETRAHEDRON.replace("0 0 1", "0 0 3"))
        self.assert_rebaked(build, [one, two], [one.name])
        self.assert_rebaked(build, [one, two], [])


class CMake(Case):
    def configure(self, *settings, code=0, generator="Ninja"):
        return run("cmake", "-S", HERE / "baked", "-B", self.folder / "build", "-G", generator, f"-DASSETS={self.folder}",
                   f"-DVCD_PROGRAMS={BUILD}/vcd-programs.cmake", *settings, code=code)

    def build(self, *arguments):
        return run("cmake", "--build", self.folder / "build", *arguments)

    @unittest.skipUnless(HAS_DEPFILE, "vc-bake has no --depfile")
    def test_ninja(self):
        self.configure()
        one, two = (self.folder / "build" / name for name in ("one.obj.vcd", "two.gltf.vcd"))
        self.assertEqual((self.folder / "build" / "list.txt").read_text(), f"{one};{two}")
        self.assert_bakes_what_changes(self.build, one, two)
        self.assertIn("no work to do", self.build())
        self.assertIn('"depth": 2', run(BIN / "vc-info", "--format", "json", two))
        self.build("--target", "beside")
        self.assertIn('"depth": 1', run(BIN / "vc-info", "--format", "json", self.folder / "one.obj.vcd"))

    @unittest.skipUnless(HAS_DEPFILE and shutil.which("make"), "vc-bake has no --depfile, or make is missing")
    def test_make(self):
        self.configure(generator="Unix Makefiles")
        self.assert_bakes_what_changes(self.build, self.folder / "build" / "one.obj.vcd", self.folder / "build" / "two.gltf.vcd")

    # What shells, Make, Ninja and CMake's lists read as something else.
    NAMES = ("a b", "fifty%", "it's", "a&b", "x$y", "n#1", "b[1]", "open[", "p(1)", "star*", "semi;colon", "pipe|", "col:on",
             "${X}", "$(x)", "@X@", "lt<", 'dq"', "grün", "all %'&$#;[x]")

    def odd_project(self, folder, names):
        """Configures a project with .obj and .gltf of these names, which bakes them below out/."""
        folder.mkdir()
        write_assets(folder)
        for name in names:
            (folder / f"{name}.obj").write_text(TETRAHEDRON)
        (folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(odd LANGUAGES NONE)\n"
            f"include({BUILD}/vcd-programs.cmake)\ninclude({SOURCE}/cmake/vcd_bake.cmake)\n"
            "vcd_bake(sidecars one.obj two.gltf " + " ".join(f"[==[{name}.obj]==]" for name in names) +
            " ALL OUTPUT_DIRECTORY out OPTIONS --depth 1 --audit 0 --method proven)\n")

    def assert_odd_names_are_baked_when_they_change(self, generator):
        project, build = self.folder / "project", self.folder / "build"
        self.odd_project(project, self.NAMES)
        make = lambda: run("cmake", "--build", build)
        run("cmake", "-S", project, "-B", build, "-G", generator)
        make()
        sidecars = [build / "out" / f"{name}.obj.vcd" for name in self.NAMES] + [build / "out" / "two.gltf.vcd"]
        self.assertNotIn("Baking", self.assert_rebaked(make, sidecars, []))
        for name in self.NAMES:
            (project / f"{name}.obj").write_text(TETRAHEDRON.replace("0 0 1", "0 0 3"))
            self.assertEqual(self.assert_rebaked(make, sidecars, [f"{name}.obj.vcd"]).count("Baking"), 1)
        self.assertNotIn("Baking", self.assert_rebaked(make, sidecars, []))
        text = (project / "CMakeLists.txt").read_text()
        (project / "CMakeLists.txt").write_text(text.replace("--depth 1", "--depth 2"))
        self.assert_rebaked(make, sidecars, [path.name for path in sidecars])
        self.assertNotIn("Baking", self.assert_rebaked(make, sidecars, []))

    def test_odd_names_with_ninja(self):
        self.assert_odd_names_are_baked_when_they_change("Ninja")

    @unittest.skipUnless(shutil.which("make"), "make is missing")
    def test_odd_names_with_make(self):
        self.assert_odd_names_are_baked_when_they_change("Unix Makefiles")

    def test_files_that_a_mesh_names_and_folders_may_have_odd_names(self):
        for generator in ("Ninja", "Unix Makefiles") if shutil.which("make") else ("Ninja",):
            for number, name in enumerate(("it's", "a&b", "50% $x #1")):
                folder = name.replace("#", "").replace("$", "")  # folders of these confuse CMake itself
                work = self.folder / f"{generator} {number} {folder}"
                work.mkdir()
                project, build = work / "project", work / "build"
                self.odd_project(project, [])
                text = (project / "two.gltf").read_text()
                (project / "two.gltf").write_text(text.replace("two.bin", f"{name}.bin".replace("%", "%25").replace("#", "%23")))
                (project / "two.bin").rename(project / f"{name}.bin")
                run("cmake", "-S", project, "-B", build, "-G", generator)
                make = lambda: run("cmake", "--build", build)
                make()
                sidecars = [build / "out" / "one.obj.vcd", build / "out" / "two.gltf.vcd"]
                self.assertNotIn("Baking", self.assert_rebaked(make, sidecars, []))
                write_bin(project, height=2.0)
                (project / "two.bin").rename(project / f"{name}.bin")
                self.assert_rebaked(make, sidecars, ["two.gltf.vcd"])
                self.assertNotIn("Baking", self.assert_rebaked(make, sidecars, []))

    def test_a_mesh_that_the_build_makes(self):
        for generator in ("Ninja", "Unix Makefiles") if shutil.which("make") else ("Ninja",):
            for number, name in enumerate(("made", "it's", "x$y")):
                project, build = self.folder / f"{generator}-{number}", self.folder / f"build-{generator}-{number}"
                self.odd_project(project, [])
                with open(project / "CMakeLists.txt", "a") as lists:
                    lists.write(f"add_custom_command(OUTPUT [=[{name}.obj]=] DEPENDS one.obj VERBATIM\n"
                                f"  COMMAND ${{CMAKE_COMMAND}} -E copy ${{CMAKE_CURRENT_SOURCE_DIR}}/one.obj [=[{name}.obj]=])\n"
                                f"vcd_bake(made [=[${{CMAKE_CURRENT_BINARY_DIR}}/{name}.obj]=] ALL OPTIONS --depth 1)\n"
                                .replace(f"[=[${{CMAKE_CURRENT_BINARY_DIR}}/{name}.obj]=]", '"${CMAKE_CURRENT_BINARY_DIR}/' + name.replace("$", "\\$") + '.obj"'))
                make = lambda: run("cmake", "--build", build)
                for _ in range(2):  # not there when it is configured, and there
                    run("cmake", "-S", project, "-B", build, "-G", generator)
                    make()
                    self.assertNotIn("Baking", make())
                sidecar = build / f"{name}.obj.vcd"
                (project / "one.obj").write_text(TETRAHEDRON.replace("0 0 1", "0 0 3"))
                self.assert_rebaked(make, [sidecar], [sidecar.name])
                self.assertNotIn("Baking", self.assert_rebaked(make, [sidecar], []))

    def test_refusals(self):
        for wrong, message in (("vcd_bake(wrong)", "vcd_bake(wrong): no mesh"),
                               ("vcd_bake(wrong a/x.obj b/x.obj)", "vcd_bake(wrong): two meshes would be baked into"),
                               (r"vcd_bake(wrong [[a\x.obj]])", r"a\x.obj: a name must not hold a line end or a backslash"),
                               ("vcd_bake(wrong [[a#x.obj]])", "a#x.obj: is not there, and the build cannot make it, since no rule")):
            self.assertIn(message, " ".join(self.configure(f"-DWRONG={wrong}", code=1).split()))
        self.assertIn("vcd_bake(sidecars): vc-bake is not installed",
                      " ".join(self.configure("-DWRONG=", "-DVCD_PROGRAMS=/dev/null", code=1).split()))


class Examples(Case):
    @unittest.skipUnless(HAS_DEPFILE and shutil.which("make"), "vc-bake has no --depfile, or make is missing")
    def test_makefile(self):
        shutil.copy(EXAMPLES / "Makefile", self.folder)
        self.assert_bakes_what_changes(lambda: run("make", "-C", self.folder, "BAKE_OPTIONS=--depth 2 --method sampled --samples 16 --audit 1000"),
                                       self.folder / "one.obj.vcd", self.folder / "two.gltf.vcd")
        run("make", "-C", self.folder, "clean")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["Makefile", "one.obj", "two.bin", "two.gltf"])

    @unittest.skipUnless(HAS_DEPFILE, "vc-bake has no --depfile")
    def test_ninja_file(self):
        shutil.copy(EXAMPLES / "build.ninja", self.folder)
        self.assert_bakes_what_changes(lambda: run("ninja", "-C", self.folder), self.folder / "one.obj.vcd", self.folder / "two.gltf.vcd")

    def test_yaml(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not installed")
        hooks = yaml.safe_load((SOURCE / ".pre-commit-hooks.yaml").read_text())
        wanted = yaml.safe_load((EXAMPLES / "pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
        self.assertLessEqual({hook["id"] for hook in wanted}, {hook["id"] for hook in hooks})
        for hook in hooks:  # pre-commit appends the files to the entry
            good = SOURCE / "tests" / "golden" / "example.vcd"
            bad = sorted((SOURCE / "tests" / "golden" / "invalid").glob("*.vcd"))[0]
            self.assertRegex(good.name, hook["files"])
            run(*hook["entry"].split(), good)
            run(*hook["entry"].split(), bad, code=3)
        if not HAS_REPORTS:
            self.skipTest("vc-verify writes no reports")
        for name, jobs in (("github-actions.yml", lambda y: y["jobs"].values()), ("gitlab-ci.yml", lambda y: [y["sidecars"]])):
            self.assert_options_exist(jobs(yaml.safe_load((EXAMPLES / name).read_text())))

    def assert_options_exist(self, jobs):
        """Every option that a job gives a program of ours stands in the program's help."""
        for job in jobs:
            for script in [step["run"] for step in job.get("steps", []) if "run" in step] + job.get("script", []):
                for line in script.splitlines():
                    program, *words = line.split() or [""]
                    if program.startswith("vc-"):
                        text = run(BIN / program, "--help")
                        for word in words:
                            if word.startswith("-"):
                                self.assertRegex(text, rf"[\s,]{word}\b", line)


if __name__ == "__main__":
    unittest.main()
