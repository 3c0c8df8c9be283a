"""A set of landmarks while it is edited, and drawn on a body."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.annotation.landmark_set import Landmark, LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.pose import PartFrames, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector

from ....widgets.forms.body_sketch import Sketch

_SPREAD_ARMS = 0.6
"""Radians by which the drawn person holds the arms away from the body."""


@dataclass(frozen=True)
class Draft:
    """A set that may not be right yet."""

    name: str
    landmarks: tuple[Landmark, ...]

    def checked(self) -> LandmarkSet:
        """The set; InputError names the landmark that is not usable, and what would be right."""
        return LandmarkSet(self.name.strip(), self.landmarks)

    def problem(self) -> InputError | None:
        """What is wrong, if anything is."""
        try:
            self.checked()
        except InputError as error:
            return error
        return None

    def changed(self, row: int, **values: object) -> Draft:
        """The draft with other values of one landmark; its mirror follows a new name."""
        old = self.landmarks[row]
        new = replace(old, **values)  # type: ignore[arg-type]
        landmarks = [new if i == row else one for i, one in enumerate(self.landmarks)]
        if new.name != old.name:
            landmarks = [
                replace(one, mirror=new.name) if one.mirror == old.name else one
                for one in landmarks
            ]
        elif new.mirror != old.mirror:
            landmarks = [_paired(one, new, old.mirror) for one in landmarks]
        return replace(self, landmarks=tuple(landmarks))

    def added(self) -> Draft:
        """The draft with one more landmark, to be filled in."""
        names = {one.name for one in self.landmarks}
        number = next(i for i in range(1, 1000) if f"landmark_{i}" not in names)
        new = Landmark(f"landmark_{number}", "#CC79A7", "torso", "torso", along=0.5)
        return replace(self, landmarks=(*self.landmarks, new))

    def without(self, rows: Iterable[int]) -> Draft:
        """The draft without these landmarks; who was paired with them is not any more."""
        gone = set(rows)
        names = {one.name for i, one in enumerate(self.landmarks) if i in gone}
        kept = [one for i, one in enumerate(self.landmarks) if i not in gone]
        freed = [replace(one, mirror="") if one.mirror in names else one for one in kept]
        return replace(self, landmarks=tuple(freed))

    def moved(self, row: int, by: int) -> Draft:
        """The draft with a landmark at another place of the order, which is that of the keys."""
        to = row + by
        if not (0 <= row < len(self.landmarks) and 0 <= to < len(self.landmarks)):
            return self
        landmarks = list(self.landmarks)
        landmarks.insert(to, landmarks.pop(row))
        return replace(self, landmarks=tuple(landmarks))


def _paired(one: Landmark, new: Landmark, before: str) -> Landmark:
    """Let the two of a pair name each other, and nobody else name either of them."""
    if one.name == new.name:
        return new
    if new.mirror and one.name == new.mirror:
        return replace(one, mirror=new.name)
    if one.mirror in (new.name, new.mirror) or one.name == before:
        return replace(one, mirror="")
    return one


def sketch_of(landmarks: Sequence[Landmark]) -> Sketch:
    """A person seen from the front, with the landmarks that have a place on the body."""
    body = body_model(AVERAGE)
    pose = hanging_pose(np.zeros(3))
    turned = pose.rotations.copy()
    for part, sign in ((2, 1.0), (3, -1.0), (4, 1.0), (5, -1.0)):
        turned[part] = rotation_from_vector(np.array([0, sign * _SPREAD_ARMS, 0])) @ turned[part]
    frames = body.frames(replace(pose, rotations=turned))
    usable = [one for one in landmarks if _has_place(one)]
    dots: tuple[tuple[float, float, str, str], ...] = ()
    if usable:
        places = _unchecked(usable).places(body, frames)
        dots = tuple(
            (*_seen(place), one.colour, one.label)
            for place, one in zip(places, usable, strict=True)
        )
    return Sketch(_lines(body, frames), dots)


def _has_place(landmark: Landmark) -> bool:
    try:
        LandmarkSet("one", (replace(landmark, mirror=""),))
    except InputError:
        return False
    return True


def _unchecked(landmarks: Sequence[Landmark]) -> LandmarkSet:
    """A set of landmarks whose names and mirrors do not matter."""
    renamed = (replace(one, name=f"l{i}", mirror="") for i, one in enumerate(landmarks))
    return LandmarkSet("sketch", tuple(renamed))


def _lines(
    body: BodyModel, frames: PartFrames
) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    ends = []
    for part in range(len(LIMBS)):
        origin = frames.origins[part]
        tip = origin + frames.rotations[part][:, 2] * body.skeleton.lengths[part]
        ends.append((_seen(origin), _seen(tip)))
    half_hips = np.array([0.5 * AVERAGE.hip_width, 0.0, 0.0])
    ends.append((_seen(-half_hips), _seen(half_hips)))
    ends.append((_seen(frames.origins[2]), _seen(frames.origins[3])))
    return tuple(ends)


def _seen(point: FloatArray) -> tuple[float, float]:
    """Right and down of a viewer in front: the person's right is at the viewer's left."""
    return -float(point[0]), -float(point[2])
