"""A detector's file and what a person says about it, and what came of reading it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, camera_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import (
    COCO_17,
    LANDMARK_OF,
    LAYOUTS,
    keypoint_name,
    layout_of,
)
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS

_KNOWN = frozenset(LANDMARKS) | frozenset(LANDMARK_OF) | {n for ns in LAYOUTS.values() for n in ns}


@dataclass(frozen=True)
class KeypointSource:
    """A file or folder of a detector."""

    path: Path
    recording: Recording
    camera: str | None = None
    """Camera or view that it is of, where it does not say so itself."""
    layout: str | None = None
    """Name in ``LAYOUTS`` of the points' order, where neither names nor number tell it."""
    names: Mapping[str, str] = field(default_factory=dict)
    """Keypoints here by the names in the file."""
    detector: str = ""
    """Name of the detector; that of the file where it is empty."""

    @property
    def name(self) -> str:
        """What the rows call their source."""
        return self.detector or self.path.stem

    @property
    def labels(self) -> LabelSource:
        """The same for readers of labels."""
        return LabelSource(self.path, self.recording, (), self.camera)

    def camera_of(self, picture: str, where: str) -> str:
        """The camera that a picture, video or folder of that name is of; InputError for none."""
        return camera_of(picture, self.recording, self.camera, where=where)

    def points_of(self, count: int, where: str) -> Sequence[str]:
        """Names of so many points in a file that names none.

        Raises InputError where they cannot be told.
        """
        if self.layout is not None:
            names = LAYOUTS[self.layout]
            return (*names, *(f"point_{i}" for i in range(len(names), count)))
        found = layout_of(count)
        if found is None:
            raise InputError(
                f"a person has {count} points, which is none of the usual layouts",
                where=where,
                remedy=f"State the layout with --layout: {', '.join(LAYOUTS)}.",
            )
        return found


@dataclass(frozen=True, eq=False)
class FoundKeypoints:
    """Keypoints of a file, and what of it is not among them."""

    keypoints: Keypoints
    left_out: Mapping[str, int] = field(default_factory=dict)
    """Rows by the reason for which they are left out, in words."""

    def summary(self) -> str:
        """What was left out, in a line; ``nothing`` where all is there."""
        told = [f"{count} {why}" for why, count in self.left_out.items()]
        return "; ".join(told) or "nothing"


def found_in(
    source: KeypointSource, rows: Iterable[Row], frames: int | None = None
) -> FoundKeypoints:
    """Take the rows of a file whose names, frames and places make sense, and count the others.

    Raises InputError where a stated name is unknown, or nothing is left.

    Parameters
    ----------
    rows : iterable of Row
        With the file's own names of keypoints.
    frames : int, optional
        Number of frames of the recording, where it is known.
    """
    for theirs, ours in source.names.items():
        if ours not in _KNOWN:
            raise InputError(
                f"unknown keypoint {ours!r}",
                where=f"--name {theirs}={ours}",
                remedy=f"Write a landmark or a keypoint, such as {', '.join(COCO_17[:7])}.",
            )
    left: Counter[str] = Counter()
    kept: list[Row] = []
    for row in rows:
        frame, camera, theirs, x, y, sure, told, person = row
        name = source.names.get(theirs) or keypoint_name(theirs)
        if name not in _KNOWN:
            left["of keypoints that are no part of the body's layouts"] += 1
        elif frame < 0 or (frames is not None and frame >= frames):
            left[f"of frames that the recording does not have (0:{frames})"] += 1
        elif sure <= 0.0:
            left["without confidence"] += 1
        else:
            kept.append((frame, camera, name, x, y, sure, told, person))
    keypoints = keypoints_of(kept)
    if lost := len(kept) - len(keypoints):
        left["without a place"] += lost
    if not len(keypoints):
        said = "; ".join(f"{count} {why}" for why, count in left.items()) or "no person is there"
        raise InputError(
            f"there is no keypoint to use ({said})",
            where=str(source.path),
            remedy="Check that the file is of this recording, and state names with --name "
            "THEIRS=OURS where they are unusual.",
        )
    return FoundKeypoints(keypoints, dict(left))
