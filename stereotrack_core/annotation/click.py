"""Clicks and predictions of landmarks in a camera's image, and how far the annotation is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from math import isfinite, sqrt
from typing import NamedTuple, TypeAlias

import numpy as np

from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.detections import Detection, Detections
from stereotrack_core.recording.landmarks import LANDMARKS

UNCERTAIN = "uncertain"  # flag of a click that its author doubts
ACCEPTED = "accepted"  # origin of a click that was a prediction before
DETECTED = "detector"  # origin of a click that was a detector's keypoint before
_BY_HAND, _CLICKED = "hand", "clicked"  # the same origin in projects and in files
_FILED = (ACCEPTED, DETECTED, "merged")
GUESSED_FACTOR = 3.0  # on the standard deviation of clicks guessed behind something
_DOUBTED_FACTOR = 2.0  # factor on the standard deviation of clicks that their author doubts
FARTHEST = 2.0**31  # pixels: far beyond every image, and below what drawing cannot deal with
LAST_FRAME = 10**8  # arrays are made with a row for each frame up to the last one
USUAL_SIGMA = 3.0  # pixels per axis of a seen landmark where nobody has measured better
Sigmas: TypeAlias = Mapping[str, float] | float
"""Standard deviation of clicks on seen landmarks, pixels per axis: by landmark, or of all."""


class Visibility(IntEnum):
    """How a landmark is seen; the numbers are those of the clicks file."""

    OUTSIDE = 0
    GUESSED = 1
    SEEN = 2


class ClickKey(NamedTuple):
    """Identifies a click."""

    frame: int
    camera: str
    landmark: str


@dataclass(frozen=True, slots=True)
class Click:
    """A landmark in one camera's image at one frame, as a person says it is."""

    frame: int  # frame of the recording, from 0
    camera: str  # name of the camera in the calibration
    landmark: str
    position: tuple[float, float] | None  # raw-image pixels; None outside the image
    visibility: Visibility = Visibility.SEEN  # seen, guessed behind something, or outside
    flag: str = ""  # empty, or a word such as :data:`UNCERTAIN`
    sigma: float | None = None  # standard deviation, pixels per axis; None: the landmark's usual
    origin: str = _BY_HAND
    """``hand``, ``accepted``, ``detector``, ``imported`` or ``merged`` (mean of two)."""
    who: str = ""  # annotator; empty until the project stamps it
    at: str = ""  # time of the last change, ISO 8601, UTC; empty until the project stamps it
    deleted: bool = False  # a person took it away. The position is the last one that it had.

    def __post_init__(self) -> None:
        if not 0 <= self.frame <= LAST_FRAME:
            raise ValueError(f"frame {self.frame} is not between 0 and {LAST_FRAME}")
        if (self.position is None) != (self.visibility == Visibility.OUTSIDE):
            raise ValueError("a landmark has a position unless it is outside the image")
        if self.position is not None and not max(map(abs, self.position)) <= FARTHEST:
            raise ValueError(f"{self.position} is not a position in an image")
        if self.sigma is not None and not (isfinite(self.sigma) and self.sigma > 0):
            raise ValueError(f"sigma is {self.sigma} px, but must be positive")

    @property
    def key(self) -> ClickKey:
        """Frame, camera and landmark."""
        return ClickKey(self.frame, self.camera, self.landmark)

    @property
    def source(self) -> str:
        """Its origin as files state it: ``clicked`` if it was placed by hand."""
        return _CLICKED if self.origin == _BY_HAND else self.origin

    @property
    def accepted(self) -> bool:
        """Whether the program placed it, and a person only agreed."""
        return self.origin in (ACCEPTED, DETECTED)

    def says_the_same(self, other: Click) -> bool:
        """Whether the other states the same, whoever did it, when, and how."""
        if (self.key, self.deleted) != (other.key, other.deleted):
            return False
        stated = ("position", "visibility", "flag", "sigma")
        return self.deleted or all(getattr(self, name) == getattr(other, name) for name in stated)


def origin_of_source(source: str) -> str:
    """Origin of a click of which a file states this source; imported if it is another word."""
    if source == _CLICKED:
        return _BY_HAND
    return source if source in _FILED else "imported"


def sigma_of(click: Click, default: Sigmas = USUAL_SIGMA) -> float:
    """Standard deviation of a click, pixels per axis; guessed and doubted ones count less."""
    if click.sigma is not None:
        return click.sigma
    usual = default if isinstance(default, float | int) else default.get(click.landmark)
    sigma = USUAL_SIGMA if usual is None else float(usual)
    if click.visibility == Visibility.GUESSED:
        sigma *= GUESSED_FACTOR
    return _DOUBTED_FACTOR * sigma if click.flag == UNCERTAIN else sigma


def measurements(
    clicks: Iterable[Click], names: Collection[str], default_sigma: Sigmas = USUAL_SIGMA
) -> tuple[Click, ...]:
    """Clicks of these landmarks with a position, not deleted, each with its sigma in pixels.

    What was accepted of a landmark in N images of a frame is off in all of them alike and tells
    only once, so sigma is larger by the root of N.
    """
    placed = (one for one in clicks if not one.deleted and one.position is not None)
    found = [one for one in placed if one.landmark in names]
    accepted = Counter((one.frame, one.landmark) for one in found if one.accepted)
    alike = (accepted[c.frame, c.landmark] if c.accepted else 1 for c in found)
    pairs = zip(found, alike, strict=True)
    return tuple(replace(c, sigma=sqrt(n) * sigma_of(c, default_sigma)) for c, n in pairs)


def click_detections(
    clicks: Iterable[Click], cameras: Cameras, default_sigma: Sigmas = USUAL_SIGMA, source: str = ""
) -> Detections:
    """Clicks of the nine landmarks as measurements of the tracker, from a `source` file."""
    ordered = sorted(measurements(clicks, LANDMARKS, default_sigma), key=lambda one: one.key)
    rows = ((float(c.frame), c.landmark, np.array(c.position), sigma_of(c)) for c in ordered)
    made = (Detection(*row, camera=cameras[c.camera]) for row, c in zip(rows, ordered, strict=True))
    return Detections(made, source)


@dataclass(frozen=True, slots=True)
class Prediction:
    """A landmark placed by the program."""

    frame: int
    camera: str
    landmark: str
    source: str  # what it comes from: ``run accurate``, ``following``, ``triangulated`` ...
    position: tuple[float, float]  # raw-image pixels
    sigma: float | None = None  # standard deviation in pixels per axis, where the source knows it
    visibility: Visibility = Visibility.SEEN  # as in the nearest clicked frames

    @property
    def key(self) -> ClickKey:
        """Frame, camera and landmark."""
        return ClickKey(self.frame, self.camera, self.landmark)


class Seen(NamedTuple):
    """A landmark at a frame, in all cameras together."""

    frame: int
    landmark: str
    positions: int  # cameras in which it has a position
    doubted: bool  # whether the author of a click doubts it


@dataclass(frozen=True)
class Progress:
    """Keyframes counted."""

    keyframes: int  # frames that shall be annotated
    done: int  # those of them that are
    flagged: int  # keyframes that somebody wants to look at again
    clicks: int  # all clicks, on whichever frame

    @property
    def share(self) -> float:
        """Part of the keyframes that is done, 0 to 1; 0 without keyframes."""
        return self.done / self.keyframes if self.keyframes else 0.0

    def words(self) -> str:
        """``214 of 300 keyframes, 3 flagged``."""
        if not self.keyframes:
            return f"{self.clicks} click{'' if self.clicks == 1 else 's'}, no keyframes set"
        flagged = f", {self.flagged} flagged" if self.flagged else ""
        return f"{self.done} of {self.keyframes} keyframes done{flagged}"
