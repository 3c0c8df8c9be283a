"""Stretches of frames that are not tracked, or in which a view gives nothing, with the reason."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

_NUMBER = re.compile(r"\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Gap:
    """A stretch of frames, half-open, that are not tracked for one reason."""

    first: int
    end: int
    reason: str


@dataclass(frozen=True)
class Blindness:
    """A stretch of frames, half-open, in which a view gives nothing, for one reason."""

    view: str
    first: int
    end: int
    reason: str


def gaps_of(reasons: Sequence[tuple[int, str]]) -> tuple[Gap, ...]:
    """Join successive frames whose reasons differ in their numbers at most.

    The numbers of a stretch are told from the smallest to the largest.
    """
    gaps: list[tuple[Gap, list[str]]] = []
    for frame, reason in reasons:
        if gaps and gaps[-1][0].end == frame and _kind(gaps[-1][0].reason) == _kind(reason):
            gap, told = gaps[-1]
            gaps[-1] = (replace(gap, end=frame + 1), [*told, reason])
        else:
            gaps.append((Gap(frame, frame + 1, reason), [reason]))
    return tuple(replace(gap, reason=_joined(told)) for gap, told in gaps)


def _kind(reason: str) -> str:
    return _NUMBER.sub("#", reason)


def _joined(reasons: Sequence[str]) -> str:
    """One sentence for sentences that differ in their numbers only."""
    numbers = zip(*(_NUMBER.findall(reason) for reason in reasons), strict=True)
    spans = []
    for told in numbers:
        low, high = min(told, key=float), max(told, key=float)
        spans.append(low if low == high else f"{low} to {high}")
    spoken = iter(spans)
    return _NUMBER.sub(lambda _: next(spoken), reasons[0])


@dataclass
class ViewProblems:
    """Collects frame by frame what the views lack."""

    _told: dict[str, list[tuple[int, str]]] = field(default_factory=dict)

    def note(self, frame: int, problems: Mapping[str, str]) -> None:
        """Keep the sentences of one frame, by view."""
        for view, sentence in problems.items():
            reason = sentence.removeprefix(f"View {view} provides no depth: ")
            reason = reason.removeprefix(f"View {view}, frame {frame}: ").rstrip(".")
            self._told.setdefault(view, []).append((frame, reason))

    def stretches(self) -> tuple[Blindness, ...]:
        """All stretches, in the order of the views that lacked something first."""
        return tuple(
            Blindness(view, gap.first, gap.end, gap.reason)
            for view, told in self._told.items()
            for gap in gaps_of(told)
        )
