"""What the timeline shows of an annotation: a lane per landmark and one per limb."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from stereotrack_core.annotation.click import ClickKey, Seen
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.project.history import Changed
from stereotrack_core.project.marks import GAP
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import CLICK

from ...widgets.style.colours import LIMB_COLOURS, limb_words
from ...widgets.timeline.lanes import Lane, Mark, MarkArray

FULL_SIGMA_DEG = 15.0  # uncertainty that is shown in a lane's full colour
_TABLES = frozenset({"click", "frame_flag", "keyframe"})

_Flags: TypeAlias = dict[int, list[str]]


class AnnotationLanes:
    """Lanes of a project's clicks and of the trajectory that was fitted to them.

    A change of some frames reads these frames again, and makes the lanes anew that differ.
    `frames`: number of frames F of the recording; `cameras`: number of cameras for clicks.
    """

    def __init__(self, project: Project, frames: int, cameras: int) -> None:
        self._project = project
        self._frames = frames
        self._enough = max(1, min(2, cameras))
        self._limbs: tuple[Lane, ...] = ()
        self._filled: BoolArray = np.zeros(frames, dtype=np.bool_)
        self._outliers: set[ClickKey] = set()
        self._proposed: Mapping[int, Collection[str]] = {}
        self.read_again()

    def read_again(self) -> None:
        self.landmark_set: LandmarkSet = self._project.landmark_set()
        self._read_flags()
        self._read_keyframes()
        self._base: MarkArray = np.zeros(
            (len(self.landmark_set.names), self._frames), dtype=np.uint8
        )
        self._marks = [np.zeros(self._frames, np.uint8) for _ in self.landmark_set.names]
        self._lanes: list[Lane | None] = [None] * len(self._marks)
        self._read(0, self._frames)

    def follow(self, changed: Changed) -> bool:
        """Take over what has changed in the project; whether a lane may be different now."""
        if "landmark_set" in changed.tables or "choice" in changed.tables:
            self.read_again()
            return True
        if not changed.tables & _TABLES:
            return False
        if "frame_flag" in changed.tables:
            self._read_flags()
        if "keyframe" in changed.tables:
            self._read_keyframes()
        edited = {change.key for change in changed.changes if change.table is CLICK}
        self._outliers = {key for key in self._outliers if key not in edited}
        frames = set().union(*(changed.frames(table) for table in _TABLES))
        if frames:
            self._read(min(frames), min(max(frames) + 1, self._frames))
        return True

    def show_reference(
        self, reference: Reference | None, outliers: Iterable[ClickKey] = ()
    ) -> None:
        """Show how certain the fitted trajectory is, and which frames it has filled in.

        `outliers` are flagged until they are edited.
        """
        self._outliers = set(outliers)
        self._filled = np.zeros(self._frames, dtype=np.bool_)
        sigma = None
        if reference is not None:
            inside = reference.frame < self._frames
            frame = reference.frame[inside]
            if reference.filled is not None:
                known = np.isfinite(reference.points).any(axis=(1, 2))
                self._filled[frame] = (reference.filled & known)[inside]
            if reference.limb_sigma_deg is not None:
                sigma = np.full((self._frames, len(LIMBS)), np.nan)
                sigma[frame] = reference.limb_sigma_deg[inside]
        self._limbs = () if sigma is None else _uncertainty_lanes(sigma)
        self._dress(0, self._frames)

    def show_proposed(self, proposed: Mapping[int, Collection[str]]) -> bool:
        """Show what can be accepted: landmarks by frame; whether a lane may be different now."""
        if proposed == self._proposed:
            return False
        frames = {*proposed, *self._proposed}
        self._proposed = proposed
        self._dress(min(frames), min(max(frames) + 1, self._frames))
        return True

    def lanes(self) -> tuple[Lane, ...]:
        """The lanes; unchanged ones are the same objects as before."""
        return (*(self._lane(place) for place in range(len(self.landmark_set.names))), *self._limbs)

    def flagged_frames(self) -> IntArray:
        flagged = [marks == Mark.FLAGGED for marks in self._marks]
        return np.flatnonzero(np.any(flagged, axis=0))

    def next_flagged(self, frame: int, *, backwards: bool = False) -> int | None:
        found = self.flagged_frames()
        found = found[found < frame][-1:] if backwards else found[found > frame][:1]
        return int(found[0]) if len(found) else None

    def _lane(self, place: int) -> Lane:
        lane, one = self._lanes[place], self.landmark_set.landmarks[place]
        if lane is None:
            lane = Lane(one.label, one.colour, "marks", self._marks[place], key=one.name)
            self._lanes[place] = lane
        return lane

    def _read_flags(self) -> None:
        self._flags: _Flags = {}
        self._gaps: _Flags = {}
        for flag in self._project.marks.flags():
            kind = self._gaps if flag.kind == GAP else self._flags
            kind.setdefault(flag.frame, []).append(flag.landmark)

    def _read_keyframes(self) -> None:
        keyframes = [one.frame for one in self._project.marks.keyframes()]
        self._keyframes = np.zeros(self._frames, dtype=np.bool_)
        self._keyframes[[frame for frame in keyframes if frame < self._frames]] = True

    def _read(self, first: int, end: int) -> None:
        if end > first:
            seen = self._project.clicks.seen(first, end)
            self._base[:, first:end] = self._marks_between(first, end, seen)
            self._dress(first, end)

    def _dress(self, first: int, end: int) -> None:
        """Add interpolated, proposed and outlying frames to the marks."""
        marks = self._base[:, first:end].copy()
        marks[(marks == Mark.NONE) & self._filled[first:end]] = Mark.INTERPOLATED
        places = {name: place for place, name in enumerate(self.landmark_set.names)}
        for frame, names in self._proposed.items():
            for name in names if first <= frame < end else ():
                lane = places.get(name, -1), frame - first
                if lane[0] >= 0 and marks[lane] in (Mark.NONE, Mark.INTERPOLATED, Mark.MISSING):
                    marks[lane] = Mark.PROPOSED
        for key in self._outliers:
            if first <= key.frame < end and key.landmark in places:
                marks[places[key.landmark], key.frame - first] = Mark.FLAGGED
        for place, new in enumerate(marks):
            if (new != self._marks[place][first:end]).any():
                # a lane's values are not changed once it was handed on
                self._marks[place] = self._marks[place].copy()
                self._marks[place][first:end] = new
                self._lanes[place] = None

    def _marks_between(self, first: int, end: int, seen: Sequence[Seen]) -> MarkArray:
        places = {name: place for place, name in enumerate(self.landmark_set.names)}
        marks: MarkArray = np.full((len(places), end - first), Mark.NONE, dtype=np.uint8)
        wanted, outside = self._keyframes[first:end].copy(), []
        for one in seen:
            lane, frame = places.get(one.landmark), one.frame - first
            wanted[frame] = True
            if lane is None:
                continue
            if one.doubted:
                marks[lane, frame] = Mark.FLAGGED
            elif one.positions:
                clicked = one.positions >= self._enough
                marks[lane, frame] = Mark.CLICKED if clicked else Mark.PARTLY
            else:  # somebody has looked and says that it is outside
                outside.append((lane, frame))
        every: dict[str, slice | int] = {"": slice(None), **places}
        for frame, landmark in _inside(self._flags, first, end):
            if landmark in every:
                marks[every[landmark], frame] = Mark.FLAGGED
        nothing = marks == Mark.NONE
        marks[nothing & wanted] = Mark.MISSING
        for lane, frame in outside:
            if nothing[lane, frame]:
                marks[lane, frame] = Mark.NONE
        for frame, landmark in _inside(self._gaps, first, end):
            if landmark in every:
                lanes = every[landmark]
                free = nothing[lanes, frame]
                marks[lanes, frame] = np.where(free, Mark.GAP, marks[lanes, frame])
        return marks


def _inside(flags: _Flags, first: int, end: int) -> list[tuple[int, str]]:
    frames: Iterable[int] = flags if len(flags) < end - first else range(first, end)
    return [
        (frame - first, landmark)
        for frame in frames
        if first <= frame < end
        for landmark in flags.get(frame, ())
    ]


def _uncertainty_lanes(sigma: FloatArray) -> tuple[Lane, ...]:
    return tuple(
        Lane(
            f"{limb_words(limb)} ±", LIMB_COLOURS[limb], "heat", sigma[:, column],
            FULL_SIGMA_DEG, "°", key=f"{limb} ±",
        )
        for column, limb in enumerate(LIMBS)
    )  # fmt: skip
