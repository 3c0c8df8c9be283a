"""Failures: stretches in which limbs fail, and their probable causes."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, TypeAlias

from stereotrack_core.body.limbs import LIMBS

Cause: TypeAlias = Literal[
    "crossing", "torso", "fast", "hidden", "hole", "neighbour", "calibration", "initialisation",
    "unclear",
]  # fmt: skip
Found: TypeAlias = Literal["truth", "signs"]
Measure: TypeAlias = Literal["error", "chance"]

CAUSE_WORDS: MappingProxyType[Cause, str] = MappingProxyType(
    {
        "crossing": "arms crossing",
        "torso": "arm close to the torso",
        "fast": "arm moving too fast",
        "hidden": "occluded in the views",
        "hole": "hole in the cloud of a view",
        "neighbour": "points of another object nearby",
        "calibration": "a view inconsistent with the others",
        "initialisation": "wrong initialisation",
        "unclear": "no clear cause",
    }
)
"""Every cause, as a person reads it."""

FOUND_WORDS: MappingProxyType[Found, str] = MappingProxyType(
    {"truth": "by error", "signs": "by failure probability"}
)


@dataclass(frozen=True)
class Evidence:
    """One thing that speaks for a cause."""

    cause: Cause
    strength: float  # from 0, nothing, to 1, as much as it can
    value: float  # the measurement, in `unit`
    unit: str
    words: str  # the same as a sentence with its number


@dataclass(frozen=True)
class Verdict:
    """The probable cause of a failure."""

    cause: Cause
    confidence: float  # strength of its evidence over that of all causes and of not knowing
    evidence: tuple[Evidence, ...] = ()  # for all causes, the strongest first

    @property
    def words(self) -> str:
        """The cause in words, with what speaks most for it."""
        reason = next((e.words for e in self.evidence if e.cause == self.cause), "")
        return f"{CAUSE_WORDS[self.cause]}: {reason}" if reason else CAUSE_WORDS[self.cause]


UNCLEAR = Verdict("unclear", 0.0)


@dataclass(frozen=True)
class FailureSegment:
    """A stretch of frames in which limbs fail."""

    first: int
    last: int  # `first` and `last`: frames, both included
    limbs: tuple[str, ...]  # names in ``LIMBS``, in their order
    found: Found  # whether it was found by errors against a reference or without one
    measure: Measure  # of `peak`: degrees, or the probability that the limb is lost
    peak: float
    peak_frame: int
    peak_limb: str
    verdict: Verdict = field(default=UNCLEAR)

    @property
    def frames(self) -> range:
        """Frame numbers from the first to the last one."""
        return range(self.first, self.last + 1)

    @property
    def peak_words(self) -> str:
        """``62°`` or ``93 %``."""
        return f"{self.peak:.0f}°" if self.measure == "error" else f"{100.0 * self.peak:.0f} %"

    def overlaps(self, other: FailureSegment) -> bool:
        """Whether both share a frame and a limb."""
        together = self.first <= other.last and other.first <= self.last
        return together and not set(self.limbs).isdisjoint(other.limbs)


def limbs_words(limbs: tuple[str, ...]) -> str:
    """``left arm, right forearm``: both halves of an arm are an arm."""
    words = []
    for limb in sorted(limbs, key=LIMBS.index):
        side, _, part = limb.partition("_")
        if part == "upper_arm" and f"{side}_forearm" in limbs:
            words.append(f"{side} arm")
        elif not (part == "forearm" and f"{side}_upper_arm" in limbs):
            words.append(limb.replace("_", " "))
    return ", ".join(words)
