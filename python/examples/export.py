"""An exporter as a modelling program would have it: its mesh's arrays in, a sidecar beside the asset out."""
import numpy
import vcd


def export_sidecar(path, name, positions, triangles, tell=print):
    mesh = vcd.prepare(numpy.ascontiguousarray(positions, numpy.float32), numpy.asarray(triangles), name=name)
    baked = vcd.bake(mesh, audit_lines=50_000, progress=lambda done, share: tell(f"{done} {share:.0%}"))
    vcd.write(path, [baked], provenance={"exporter": "export.py"})
    return baked.record


if __name__ == "__main__":  # an octahedron
    corners = [(2, 0, 0), (-2, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    print(export_sidecar("gem.vcd", "gem", corners, [(x, y, z) for x in (0, 1) for y in (2, 3) for z in (4, 5)]))
