"""Keypoints of detectors as they are drawn over a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.recording.keypoint_names import LANDMARK_OF
from stereotrack_core.recording.keypoints import Keypoints

from ..widgets.camera.overlays import InsideScene, Marked
from ..widgets.style.limb_colours import LANDMARK_LIMBS, LIMB_COLOURS

_OTHER = "#b8b8b8"
_SIDED = (
    ("shoulder", "elbow", "upper_arm"),
    ("elbow", "wrist", "forearm"),
    ("shoulder", "hip", "torso"),
    ("hip", "knee", ""),
    ("knee", "ankle", ""),
)
_BONES: Mapping[tuple[str, str], str] = {
    **{
        (f"{side}_{a}", f"{side}_{b}"): f"{side}_{limb}" if limb[-3:] == "arm" else limb
        for side in ("left", "right")
        for a, b, limb in _SIDED
    },
    ("left_shoulder", "right_shoulder"): "torso",
    ("left_hip", "right_hip"): "torso",
}
"""Keypoints that a line is drawn between, and the limb in whose colour."""


def keypoint_drawing(keypoints: Keypoints, camera: str) -> InsideScene | None:
    """Keypoints of a frame in the picture of a camera; None where it has none."""
    own = keypoints[keypoints.camera == camera]
    if not len(own):
        return None
    lines: dict[str, list[FloatArray]] = {}
    for places in _people(own):
        for (a, b), limb in _BONES.items():
            if a in places and b in places:
                bone = np.stack([places[a], places[b]])
                lines.setdefault(LIMB_COLOURS.get(limb, _OTHER), []).append(bone)
    dots: dict[str, list[FloatArray]] = {}
    for name, place in zip(own.keypoint.tolist(), own.place, strict=True):
        limb = LANDMARK_LIMBS.get(LANDMARK_OF.get(name, ""), "")
        dots.setdefault(LIMB_COLOURS.get(limb, _OTHER), []).append(place)
    return InsideScene(
        lines=tuple(Marked(colour, np.array(found)) for colour, found in lines.items()),
        dots=tuple(Marked(colour, np.array(found)) for colour, found in dots.items()),
    )


def _people(rows: Keypoints) -> Iterator[dict[str, FloatArray]]:
    """Places by keypoint, of each person of each detector."""
    keys = list(zip(rows.source.tolist(), rows.person.tolist(), strict=True))
    for key in dict.fromkeys(keys):
        chosen = np.array([one == key for one in keys], dtype=np.bool_)
        person = rows[chosen]
        yield dict(zip(person.keypoint.tolist(), person.place, strict=True))
