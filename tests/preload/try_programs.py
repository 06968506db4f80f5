#!/usr/bin/env python3
"""Runs programs that nobody here wrote with libvcd_embree3.so and without it: same pictures? what time?

    tests/preload/try_programs.py BUILD MESH.obj [UP]

BUILD is a build folder (preset release), UP the axis of the mesh that points up (default 1). The mesh must be of
triangles. It is exported by the library, and baked with proofs. Needs Debian's embree-tools and python3-open3d.
"""
import filecmp
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROGRAMS = (("pathtracer", "--spp", "8", "--size", "512", "512"), ("viewer", "--shader", "ao", "--size", "768", "768"))
MODES = {"alone": None, "proven": {}, "proven always": {"VCD_LOOK_UP": "always"},
         "exact always": {"VCD_ANSWERS": "exact", "VCD_LOOK_UP": "always"}}
REPEATS = 2  # the fastest counts


def write_scene(mesh, up, path):
    """The mesh on a ground of two triangles, below a point light, a sun and a sky."""
    corners = [[float(x) for x in line.split()[1:4]] for line in open(mesh) if line.startswith("v ")]
    low, high = [[of(c[a] for c in corners) for a in range(3)] for of in (min, max)]
    size = max(h - l for l, h in zip(low, high))
    axis = [[float(a == b) for b in range(3)] for a in range(3)]
    x, up = axis[(up + 1) % 3], axis[up]
    y = [x[(a + 1) % 3] * up[(a + 2) % 3] - x[(a + 2) % 3] * up[(a + 1) % 3] for a in range(3)]

    def at(a, b, c):
        return [size * (a * x[i] + b * y[i] + c * up[i]) for i in range(3)]

    def text(*vectors):
        return " ".join(f"{v:.6g}" for vector in vectors for v in vector)

    middle = [(l + h) / 2 for l, h in zip(low, high)]
    ground = [m if not u else l - size / 1000 for m, l, u in zip(middle, low, up)]
    plus = lambda a, b: [i + j for i, j in zip(a, b)]
    path.write_text(f"""-i mesh.obj
--triangle-plane {text(plus(ground, at(-3, -3, 0)), at(6, 0, 0), at(0, 6, 0))} 1 1
--pointlight {text(plus(middle, at(1.5, 1, 2)))} {text([8 * size * size] * 3)}
--directionallight {text(at(-0.5, 1, -2))} 1 1 1
--ambientlight 0.3 0.3 0.3
-vp {text(plus(middle, at(0.7, 1.9, 0.9)))} -vi {text(middle)} -vu {text(up)} -fov 45
""")


def run(command, preload, **variables):
    """Seconds of processor time, and what was said."""
    env = {**os.environ, **variables}
    if preload:
        env["LD_PRELOAD"] = " ".join(map(str, preload))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([str(word) for word in command], env=env, capture_output=True, text=True, check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return seconds, done.stdout.strip() + "\n" + done.stderr.strip().split("\n")[-1]


def main():
    build, mesh, up = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), int((*sys.argv, 1)[3])
    library = build / "lib/libvcd_embree3.so"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "mesh.obj").symlink_to(mesh)
        write_scene(mesh, up, folder / "scene.ecs")
        scene = ("-c", folder / "scene.ecs", "-o")
        run((*PROGRAMS[0], *scene, folder / "export.ppm"), [library], VCD_EXPORT=str(folder / "meshes"))
        subprocess.run([build / "bin/vc-bake", folder / "meshes", "-o", folder / "sidecars", "-m", "proven", "--quiet"], check=True)
        sidecars = {"VCD_SIDECARS": str(folder / "sidecars")}
        for program in PROGRAMS:
            for mode, variables in MODES.items():
                picture = folder / (mode.replace(" ", "-") + ".ppm")
                preload = [] if variables is None else [library]
                runs = [run((*program, *scene, picture), preload, **sidecars, **(variables or {})) for _ in range(REPEATS)]
                same = "same picture" if filecmp.cmp(folder / "alone.ppm", picture, shallow=False) else "another picture"
                print(f"{program[0]} {mode}: {min(runs)[0]:.2f} s, {same}\n  {runs[0][1]}".rstrip(), flush=True)
        for mode, variables in MODES.items():
            preload = [build / "tests/libgive_mask.so", "libembree3.so.3" if variables is None else library]
            _, said = run(("/usr/bin/python3", HERE / "open3d_shadows.py", mesh), preload, **sidecars, **(variables or {}))
            print(f"Open3D {mode}: {said}", flush=True)


if __name__ == "__main__":
    main()
