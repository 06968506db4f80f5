"""Counts what look-ups answer, for who wants to know."""
from __future__ import annotations

import dataclasses
from typing import Any, Callable, Union

import numpy
from numpy.typing import NDArray

from ._native import Object, QuadBundle, Scene, SphereBundle
from .records import Visibility


@dataclasses.dataclass
class AnswerCounts:
    """What look-ups answered. One for each thread; add them up with +=."""
    clear: int = 0
    blocked: int = 0
    unclassified: int = 0  # left to a hierarchy, the object's or the renderer's

    @property
    def asked(self) -> int:
        return self.clear + self.blocked + self.unclassified

    @property
    def answered(self) -> int:
        return self.clear + self.blocked

    def add(self, answers: NDArray[numpy.uint8]) -> None:
        """Adds answers of classify(): (n,) uint8 of Visibility."""
        counts = numpy.bincount(answers, minlength=len(Visibility))
        self.clear += int(counts[Visibility.CLEAR])
        self.blocked += int(counts[Visibility.BLOCKED])
        self.unclassified += int(counts[Visibility.UNCLASSIFIED])

    def __iadd__(self, more: AnswerCounts) -> AnswerCounts:
        self.clear += more.clear
        self.blocked += more.blocked
        self.unclassified += more.unclassified
        return self


class Counting:
    """Asks an Object or a Scene, and counts: counts = AnswerCounts(); tree = Counting(tree, counts).

    Who asks the object itself pays nothing. The answers are the same. One thread at a time, as the counts are its own.
    """

    def __init__(self, asked: Union[Object, Scene], counts: AnswerCounts) -> None:
        self._asked, self._counts = asked, counts

    def classify(self, segments: Union[NDArray[numpy.float32], QuadBundle, SphereBundle],
                 **more: Any) -> NDArray[numpy.uint8]:
        """As classify() of what is asked, with its arguments: (n, 8) float32 or a bundle in, (n,) uint8 out."""
        answers = self._asked.classify(segments, **more)
        self._counts.add(answers)
        return answers

    def occluded(self, segments: NDArray[numpy.float32],
                 fallback: Callable[[NDArray[numpy.float32]], NDArray[numpy.bool_]],
                 **more: Any) -> NDArray[numpy.bool_]:
        """Whether each segment is blocked: (n, 8) float32 in, (n,) bool out.

        fallback: is asked for what is unclassified, (k, 8) float32 in, (k,) bool out: the renderer's own, or the
        object's occluded(). more: further arguments of classify().
        """
        answers = self.classify(segments, **more)
        blocked, left = answers == Visibility.BLOCKED, answers == Visibility.UNCLASSIFIED
        if left.any():
            blocked[left] = fallback(segments[left])
        return blocked
