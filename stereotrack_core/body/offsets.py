"""Where a person's bones lie in the flesh: landmarks against the surface that is tracked.

Where a joint lies in the cones differs between people by a centimetre or so, and stays as it is in
all poses. Every landmark has three numbers for it, along axes that its limb carries:

- shoulders and hips: the torso's axes, to the person's right, forward and up;
- the head: the axes of the head;
- elbows and hands: along the limb, towards the inside of the bent elbow, and across both; the last
  two fade out as the elbow straightens, whose turn about its axis is not known.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import FOREARMS, HEAD, TORSO, UPPER_ARMS
from stereotrack_core.recording.landmarks import LANDMARKS

# (9, 3): landmarks lie where the surface puts them
NO_OFFSETS: FloatArray = np.zeros((len(LANDMARKS), 3))
NO_OFFSETS.flags.writeable = False
# parts whose axes the offsets off the arms have
TRUNK = MappingProxyType({"shoulder": TORSO, "hip": TORSO, "head": HEAD})


def offsets_of(values: Mapping[str, tuple[float, float, float]]) -> FloatArray:
    """Offsets (9, 3), metres, of a subject's by landmark; zeros where none are known."""
    return np.array([values.get(name, (0.0, 0.0, 0.0)) for name in LANDMARKS])


def offsets_by_landmark(offsets: FloatArray) -> dict[str, tuple[float, float, float]]:
    """The same by landmark, as a subject has them, to a hundredth of a millimetre."""
    rounded = np.round(offsets, 5).tolist()
    return {name: (x, y, z) for name, (x, y, z) in zip(LANDMARKS, rounded, strict=True)}


def offset_axes(frames: PartFrames) -> FloatArray:
    """Axes (..., 9, 3, 3), world, in the columns, along which offsets move the landmarks."""
    z = frames.rotations[..., :, :, 2]
    found = []
    for name in LANDMARKS:
        side, _, place = name.rpartition("_")
        if place in TRUNK:
            found.append(frames.rotations[..., TRUNK[place], :, :])
            continue
        k = 0 if side == "left" else 1
        upper, fore = z[..., UPPER_ARMS[k], :], z[..., FOREARMS[k], :]
        own, other = (upper, fore) if place == "elbow" else (fore, upper)
        inwards = other - np.sum(own * other, axis=-1, keepdims=True) * own
        across = np.cross(upper, fore) if side == "right" else np.cross(fore, upper)
        found.append(np.stack([own, inwards, across], axis=-1))
    return np.stack(found, axis=-3)


def with_offsets(points: FloatArray, offsets: FloatArray, frames: PartFrames) -> FloatArray:
    """Landmarks (..., 9, 3), world, metres, of those that the surface has, by offsets (9, 3)."""
    if not offsets.any():
        return points
    return np.asarray(points + np.einsum("...lij,lj->...li", offset_axes(frames), offsets))
