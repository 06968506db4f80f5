"""Precomputed visibility for shadow rays: bakes sidecars of meshes, and asks them.

    mesh = vcd.prepare(positions, triangles, name="tree")   # (n, 3) float32, (m, 3) integers
    vcd.write("tree.vcd", [vcd.bake(mesh)])
    tree = vcd.open("tree.vcd")[0]
    answers = tree.classify(segments)                        # (n, 8) float32 in, (n,) uint8 out
    dark = tree.occluded(segments)                           # (n,) bool, exact

A segment is all points origin + t * direction with t_min < t < t_max, in the object's own frame and unit. An array of
segments has shape (n, 8), type float32, C order: origin x, y, z, t_min, direction x, y, z, t_max. segments() makes one.
Arrays are used in place, never converted in silence: a wrong type, shape or order raises TypeError or ValueError.

Threads: everything that is open or baked is immutable. Long calls release the GIL, so that threads run side by side.
Do not write to an array while a call reads it.
"""
import numpy as _numpy

from ._native import (Baked, Mesh, Object, PointBundle, QuadBundle, Scene, Sidecar, SidecarStore, SphereBundle, bake,
                      geometry_hash, kernels, open, prepare, sidecar_bytes, verify, version, write)
from .counting import AnswerCounts, Counting
from .records import (Audit, AuditCounts, Contradiction, DepthForecast, Difference, Error, FileError, InvalidFile,
                      Issue, Plan, Record, Unsupported, UsageError, Verification, Visibility)

__version__ = version()
__all__ = ["AnswerCounts", "Audit", "AuditCounts", "Baked", "Contradiction", "Counting", "DepthForecast",
           "Difference", "Error", "FileError", "InvalidFile", "Issue", "Mesh", "Object", "Plan", "PointBundle",
           "QuadBundle", "Record", "Scene", "Sidecar", "SidecarStore", "SphereBundle", "Unsupported", "UsageError",
           "Verification", "Visibility", "bake", "geometry_hash", "kernels", "open", "prepare", "segments",
           "sidecar_bytes", "verify", "version", "write"]


def segments(origin: "_numpy.typing.ArrayLike", direction: "_numpy.typing.ArrayLike",
             t_min: "_numpy.typing.ArrayLike" = 0.0, t_max: "_numpy.typing.ArrayLike" = 1.0
             ) -> "_numpy.typing.NDArray[_numpy.float32]":
    """An array of segments, shape (n, 8), float32, of columns that broadcast against one another.

    origin, direction: (n, 3) or (3,), in the object's frame and unit; t_min, t_max: (n,) or a number, in lengths of
    the direction. For "is q visible from p?" take origin p and direction q - p. Copies.
    """
    n = _numpy.broadcast_shapes(_numpy.shape(origin)[:-1], _numpy.shape(direction)[:-1], _numpy.shape(t_min),
                                _numpy.shape(t_max), (1,))[0]
    result = _numpy.empty((n, 8), _numpy.float32)
    result[:, 0:3], result[:, 3], result[:, 4:7], result[:, 7] = origin, t_min, direction, t_max
    return result
