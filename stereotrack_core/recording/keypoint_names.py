"""Names of the keypoints of usual 2-D detectors, and which of our landmarks they measure.

Every detector's points have the names that this module gives them, whatever its files call them:
``left_wrist`` is what COCO calls so, ``LWrist`` in OpenPose, ``left wrist`` in a label set.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

_FACE = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")
_ARMS = tuple(f"{s}_{n}" for n in ("shoulder", "elbow", "wrist") for s in ("left", "right"))
_LEGS = tuple(f"{s}_{n}" for n in ("hip", "knee", "ankle") for s in ("left", "right"))

COCO_17: tuple[str, ...] = (*_FACE, *_ARMS, *_LEGS)
"""COCO 2017 person keypoints; the first 17 of COCO-WholeBody."""

BODY_25: tuple[str, ...] = (
    *("nose", "neck", "right_shoulder", "right_elbow", "right_wrist"),
    *("left_shoulder", "left_elbow", "left_wrist", "mid_hip"),
    *("right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle"),
    *("right_eye", "left_eye", "right_ear", "left_ear"),
    *("left_big_toe", "left_small_toe", "left_heel"),
    *("right_big_toe", "right_small_toe", "right_heel"),
)
"""OpenPose's BODY_25."""

COCO_18: tuple[str, ...] = (
    *("nose", "neck", "right_shoulder", "right_elbow", "right_wrist"),
    *("left_shoulder", "left_elbow", "left_wrist"),
    *("right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle"),
    *("right_eye", "left_eye", "right_ear", "left_ear"),
)
"""OpenPose's older COCO model."""

HALPE_26: tuple[str, ...] = (
    *COCO_17,
    *("head_top", "neck", "mid_hip"),
    *("left_big_toe", "right_big_toe", "left_small_toe", "right_small_toe"),
    *("left_heel", "right_heel"),
)
"""Halpe's 26 body points, as RTMPose's body models give them."""

MEDIAPIPE_33: tuple[str, ...] = (
    "nose",
    *(f"{s}_eye{e}" for s in ("left", "right") for e in ("_inner", "", "_outer")),
    *("left_ear", "right_ear", "mouth_left", "mouth_right"),
    *_ARMS,
    *(f"{s}_{n}" for n in ("pinky", "index", "thumb") for s in ("left", "right")),
    *_LEGS,
    *(f"{s}_{n}" for n in ("heel", "foot_index") for s in ("left", "right")),
)
"""MediaPipe's pose landmarks."""

LAYOUTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "coco17": COCO_17,
        "coco18": COCO_18,
        "body25": BODY_25,
        "halpe26": HALPE_26,
        "mediapipe33": MEDIAPIPE_33,
    }
)
"""Layouts by name: names of the points in their order."""

LANDMARK_OF: Mapping[str, str] = MappingProxyType(
    {
        **{n: n for s in ("left", "right") for n in (f"{s}_shoulder", f"{s}_elbow", f"{s}_hip")},
        **{f"{s}_{n}": f"{s}_hand" for s in ("left", "right") for n in ("wrist", "hand")},
        "head": "head",
        **dict.fromkeys(("left_ear", "right_ear", "nose"), "head"),
    }
)
"""The landmark that a keypoint tells most about. A wrist is extended along the forearm to the
hand's landmark, and the head lies between the ears; what is not here tells about none."""

_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_SAME: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("hip", "midhip", "pelvis", "root", "hip_center"), "mid_hip"),
        "top_head": "head_top",
        "head_center": "head",
        **{f"{side}_mouth": f"mouth_{side}" for side in ("left", "right")},
    }
)


def keypoint_name(theirs: str) -> str:
    """Our name of a keypoint: its side first, words in lower case, joined by ``_``.

    Examples
    --------
    >>> keypoint_name("RWrist"), keypoint_name("elbow_L"), keypoint_name("Left Hip")
    ('right_wrist', 'left_elbow', 'left_hip')
    """
    words = [word.lower() for word in _WORD.findall(theirs)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    name = "_".join((*sides, *(word for word in words if word not in _SIDES)))
    return _SAME.get(name, name)


def layout_of(count: int) -> Sequence[str] | None:
    """Names of so many points in a file that names none; None where no usual detector has them.

    More than 130 are those of a whole body, whose first ones are COCO's (133) or Halpe's (136).
    """
    by_count: dict[int, Sequence[str]] = {len(names): names for names in LAYOUTS.values()}
    whole = {133: (*COCO_17, *_unnamed(133, 17)), 136: (*HALPE_26, *_unnamed(136, 26))}
    return (by_count | whole).get(count)


def _unnamed(count: int, first: int) -> tuple[str, ...]:
    return tuple(f"point_{i}" for i in range(first, count))


def exchanged(name: str) -> str:
    """The same point of the other side."""
    for side, other in (("left", "right"), ("right", "left")):
        if name.startswith(f"{side}_"):
            return f"{other}_{name.removeprefix(side + '_')}"
        if name.endswith(f"_{side}"):
            return f"{name.removesuffix('_' + side)}_{other}"
    return name
