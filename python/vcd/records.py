"""What vcd tells in words and numbers: records, reports and errors."""
from __future__ import annotations

import dataclasses
import enum
from typing import List, Optional, Tuple

Vector = Tuple[float, float, float]


class Visibility(enum.IntEnum):
    """The answer to a segment, as classify() gives it."""
    CLEAR = 0  # a promise: no triangle of the object meets the segment
    BLOCKED = 1  # a promise: some triangle of the object meets the segment
    UNCLASSIFIED = 2  # no promise: occluded() decides, or the renderer


class Error(Exception):
    """What went wrong. The message names the file, the place and the reason."""


class UsageError(Error, ValueError):
    """The caller asked for something that makes no sense."""


class FileError(Error, OSError):
    """A file could not be opened, read, written or renamed."""


class InvalidFile(Error, ValueError):
    """The bytes break their format, or a mesh has no triangle with an area."""


class Unsupported(Error):
    """Valid, but this version does not handle it."""


class Difference(Error):
    """An audit found a wrong proof: a fault of vcd. The message holds segments that show it."""


@dataclasses.dataclass(frozen=True)
class Record:
    """What a sidecar says of one object: ObjectRecord in spec/vcd-format.md."""
    name: str
    source_index: int  # of the mesh in its source file
    method: str  # "none", "sampled", "proven", "hybrid"
    depth: int  # 1 to 8
    samples: int  # a cell; 0 for proven
    seed: int
    box_min: Vector  # the padded box, in the object's frame
    box_max: Vector
    geometry_hash: bytes  # 16 bytes
    triangle_count: int  # of the welded mesh
    vertex_count: int
    clear_cells: int  # of the deepest level
    blocked_cells: int
    unclassified_cells: int
    statistical_cells: int
    audit_lines: Tuple[int, int]  # asked after the bake: undirected, and aimed at the mesh
    audit_wrong: Tuple[int, int]  # of them answered wrongly
    audit_bound_95: float  # one-sided 95 % bound of the rate of wrong undirected lines; 0: not audited
    guard_band: float  # of the proofs, grid units
    shift: Vector  # x of the object + shift[0] is x of the source
    parts_left_out: bool  # of the source mesh
    look_up_from_outside: bool  # whether look-ups save time before the hierarchy
    look_up_from_inside: bool


@dataclasses.dataclass(frozen=True)
class DepthForecast:
    """What a bake of one depth would cost and be worth."""
    depth: int
    bytes: int  # of the tree
    seconds: float  # of the bake
    resolved: float  # share of all cells that are clear or blocked
    resolved_shadow: float  # share of segments that look like shadow rays
    gain: float  # time of tracing these one by one, divided by that of looking up and tracing the rest


@dataclasses.dataclass(frozen=True)
class Plan:
    """Why a depth was picked."""
    depth: int  # 0: a sidecar would not pay
    reason: str
    forecasts: List[DepthForecast]
    seconds: float  # that it took


@dataclasses.dataclass(frozen=True)
class AuditCounts:
    """Fresh lines of one kind, asked of a tree and judged in exact arithmetic."""
    kind: str  # "uniform", "chords", "inside", "edges", "vertices"
    segments: int
    clear: int  # answers
    blocked: int
    wrong_clear: int  # of these answers
    wrong_blocked: int
    wrong_proven: int  # of the wrong ones, those that were given as proven


@dataclasses.dataclass(frozen=True)
class Contradiction:
    """A wrong answer."""
    kind: str
    segment: Tuple[float, float, float, float, float, float, float, float]
    promised: Visibility
    proven: bool


@dataclasses.dataclass(frozen=True)
class Audit:
    """What an audit found."""
    counts: List[AuditCounts]
    contradictions: List[Contradiction]  # the first of them


@dataclasses.dataclass(frozen=True)
class Issue:
    """What verify() found."""
    id: str  # as vc-verify prints it: "stale", "wrong-answer-rate"
    severity: str  # "error", "warning"
    text: str


@dataclasses.dataclass(frozen=True)
class Verification:
    """A sidecar held against meshes."""
    ok: bool  # no error
    issues: List[Issue]
    audits: List[Optional[Audit]]  # of the objects, in their order; None: not asked
