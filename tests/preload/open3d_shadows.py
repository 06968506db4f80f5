"""Asks Open3D's RaycastingScene for shadow rays of a mesh (OBJ of triangles); knows nothing of vcd."""
import hashlib
import sys
import time

import numpy
import open3d

RAYS = 4_000_000


def read(path):
    lines = [line.split() for line in open(path)]
    positions = [[float(x) for x in line[1:4]] for line in lines if line and line[0] == "v"]
    triangles = [[int(x.split("/")[0]) - 1 for x in line[1:4]] for line in lines if line and line[0] == "f"]
    return numpy.array(positions, numpy.float32), numpy.array(triangles, numpy.uint32)


def main():
    positions, triangles = read(sys.argv[1])
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(open3d.core.Tensor(positions), open3d.core.Tensor(triangles))
    low, high = positions.min(0), positions.max(0)
    random = numpy.random.default_rng(1)
    around = random.normal(size=(RAYS, 3))
    around *= 1.2 * (high - low).max() / numpy.linalg.norm(around, axis=1)[:, None]
    origins = (low + high) / 2 + around
    targets = (low + high) / 2 + (random.random((RAYS, 3)) - 0.5) * (high - low) * 1.2
    rays = open3d.core.Tensor(numpy.concatenate([origins, targets - origins], 1).astype(numpy.float32))
    scene.test_occlusions(rays[:1000])  # builds
    begin = time.perf_counter()
    blocked = scene.test_occlusions(rays, 0, 2).numpy()
    seconds = time.perf_counter() - begin
    print(f"{blocked.sum()} of {RAYS} blocked, answers {hashlib.sha1(blocked.tobytes()).hexdigest()[:12]}, "
          f"{seconds / RAYS * 1e9:.1f} ns a ray")


if __name__ == "__main__":
    main()
