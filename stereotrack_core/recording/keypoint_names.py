"""Names of the keypoints of usual 2-D detectors, and which of our landmarks they measure.

Every detector's points have the names that this module gives them, whatever its files call them:
``left_wrist`` is what COCO calls so, ``LWrist`` in OpenPose, ``left wrist`` in a label set.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from stereotrack_core.errors import InputError

_BOTH = ("left", "right")
_FACE = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")
_EYES_AND_EARS = ("right_eye", "left_eye", "right_ear", "left_ear")
_ARMS = tuple(f"{s}_{n}" for n in ("shoulder", "elbow", "wrist") for s in _BOTH)
_LEGS = tuple(f"{s}_{n}" for n in ("hip", "knee", "ankle") for s in _BOTH)
_FEET = tuple(f"{s}_{n}" for s in _BOTH for n in ("big_toe", "small_toe", "heel"))


def _limb(side: str, *names: str) -> tuple[str, ...]:
    return tuple(f"{side}_{name}" for name in names)


_ARM, _LEG = ("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle")
_LONG_ARM = (*_ARM, "hand")

COCO_17: tuple[str, ...] = (*_FACE, *_ARMS, *_LEGS)
"""COCO 2017 person keypoints; the first 17 of COCO-WholeBody."""

_BODY_19 = (
    *("nose", "neck", *_limb("right", *_ARM), *_limb("left", *_ARM), "mid_hip"),
    *(*_limb("right", *_LEG), *_limb("left", *_LEG), *_EYES_AND_EARS),
)

BODY_25: tuple[str, ...] = (*_BODY_19, *_FEET)
"""OpenPose's BODY_25."""

BODY_25B: tuple[str, ...] = (*COCO_17, "upper_neck", "head_top", *_FEET)
"""OpenPose's BODY_25B; the first 25 of its BODY_135."""

COCO_18: tuple[str, ...] = tuple(name for name in _BODY_19 if name != "mid_hip")
"""OpenPose's older COCO model."""

HALPE_26: tuple[str, ...] = (
    *COCO_17,
    *("head_top", "neck", "mid_hip"),
    *(f"{s}_{n}" for n in ("big_toe", "small_toe", "heel") for s in _BOTH),
)
"""Halpe's 26 body points, as RTMPose's body models give them."""

MEDIAPIPE_33: tuple[str, ...] = (
    "nose",
    *(f"{s}_eye{e}" for s in _BOTH for e in ("_inner", "", "_outer")),
    *("left_ear", "right_ear", "mouth_left", "mouth_right"),
    *_ARMS,
    *(f"{s}_{n}" for n in ("pinky", "index", "thumb") for s in _BOTH),
    *_LEGS,
    *(f"{s}_{n}" for n in ("heel", "foot_index") for s in _BOTH),
)
"""MediaPipe's pose landmarks, also known as BlazePose."""

_KINECT_ARM = (*_LONG_ARM, "handtip", "thumb")


def _rest(count: int, first: int) -> tuple[str, ...]:
    """Points of face and hands, which tell nothing about the body."""
    return tuple(f"point_{i}" for i in range(first, count))


LAYOUTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "coco17": COCO_17,
        "coco18": COCO_18,
        "body25": BODY_25,
        "halpe26": HALPE_26,
        "mediapipe33": MEDIAPIPE_33,
        "body25b": BODY_25B,
        "h36m17": (
            *("mid_hip", *_limb("right", *_LEG), *_limb("left", *_LEG)),
            *("spine", "neck", "face", "head_top", *_limb("left", *_ARM), *_limb("right", *_ARM)),
        ),
        "posetrack17": ("nose", "upper_neck", "head_top", *_FACE[3:], *_ARMS, *_LEGS),
        "mpi3dhp17": (
            *("head_top", "neck", *_limb("right", *_ARM), *_limb("left", *_ARM)),
            *(*_limb("right", *_LEG), *_limb("left", *_LEG), "mid_hip", "spine", "face"),
        ),
        "coco_neck18": (*COCO_17, "neck"),
        "body19": _BODY_19,
        "panoptic19": (
            *("neck", "nose", "mid_hip", *_limb("left", *_ARM), *_limb("left", *_LEG)),
            *(*_limb("right", *_ARM), *_limb("right", *_LEG)),
            *("left_eye", "left_ear", "right_eye", "right_ear"),
        ),
        "coco_feet23": (*COCO_17, *_FEET),
        "body23": (*(n for n in _BODY_19 if n not in ("neck", "mid_hip")), *_FEET),
        "kinect25": (
            *("mid_hip", "spine", "upper_neck", "head"),
            *(*_limb("left", *_LONG_ARM), *_limb("right", *_LONG_ARM)),
            *(*_limb("left", *_LEG, "foot"), *_limb("right", *_LEG, "foot")),
            *("neck", *_limb("left", "handtip", "thumb"), *_limb("right", "handtip", "thumb")),
        ),
        "kinect32": (
            *("mid_hip", "spine", "chest", "upper_neck"),
            *(*_limb("left", "clavicle", *_KINECT_ARM), *_limb("right", "clavicle", *_KINECT_ARM)),
            *(*_limb("left", *_LEG, "foot"), *_limb("right", *_LEG, "foot")),
            *("head", "nose", "left_eye", "left_ear", "right_eye", "right_ear"),
        ),
        "crowdpose14": (*_ARMS, *_LEGS, "head_top", "neck"),
        "aic14": (
            *(*_limb("right", *_ARM), *_limb("left", *_ARM)),
            *(*_limb("right", *_LEG), *_limb("left", *_LEG), "head_top", "neck"),
        ),
        "lsp14": (
            *(*_limb("right", *_LEG[::-1]), *_limb("left", *_LEG)),
            *(*_limb("right", *_ARM[::-1]), *_limb("left", *_ARM), "neck", "head_top"),
        ),
        "mpi15": (
            *("head_top", "neck", *_limb("right", *_ARM), *_limb("left", *_ARM)),
            *(*_limb("right", *_LEG), *_limb("left", *_LEG), "chest"),
        ),
        "mpii16": (
            *(*_limb("right", *_LEG[::-1]), *_limb("left", *_LEG)),
            *("mid_hip", "neck", "upper_neck", "head_top"),
            *(*_limb("right", *_ARM[::-1]), *_limb("left", *_ARM)),
        ),
        "coco133": (*COCO_17, *_FEET, *_rest(133, 23)),
        "body135": (*BODY_25B, *_rest(135, 25)),
        "halpe136": (*HALPE_26, *_rest(136, 26)),
    }
)
"""Layouts by name: names of the points in their order; of equal length the usual one first.

Sources: OpenPose's ``poseParameters.cpp``, MMPose's dataset descriptions, Microsoft's Kinect SDKs,
NVIDIA's trt_pose (``coco_neck18``), MediaPipe's pose landmarks.
"""

_SAME_LAYOUT: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("coco", "yolo17", "vitpose17", "posenet17"), "coco17"),
        **dict.fromkeys(("openpose18", "cococmu", "body18", "openposecoco"), "coco18"),
        **dict.fromkeys(("openpose", "openpose25"), "body25"),
        **dict.fromkeys(("halpe", "body26", "rtmpose26"), "halpe26"),
        **dict.fromkeys(("blazepose", "blazepose33", "mediapipe"), "mediapipe33"),
        **dict.fromkeys(("human36m", "human36m17", "h36m"), "h36m17"),
        **dict.fromkeys(("posetrack", "posetrack18"), "posetrack17"),
        **dict.fromkeys(("wholebody", "wholebody133", "cocowholebody"), "coco133"),
        **dict.fromkeys(("kinectv2", "kinect"), "kinect25"),
        **dict.fromkeys(("azurekinect", "kinectazure"), "kinect32"),
        "trtpose": "coco_neck18",
        "mpi": "mpi15",
        "mpii": "mpii16",
        "crowdpose": "crowdpose14",
        "aic": "aic14",
        "lsp": "lsp14",
        "panoptic": "panoptic19",
    }
)
"""Other names of layouts, in lower case without signs."""


def layout_named(text: str) -> str:
    """Name in :data:`LAYOUTS` of a layout as people write it, such as ``BODY_25B``.

    Raises InputError if there is none.
    """
    plain = re.sub(r"[^a-z0-9]", "", text.lower())
    by_name = {name.replace("_", ""): name for name in LAYOUTS} | dict(_SAME_LAYOUT)
    if plain not in by_name:
        raise InputError(
            f"unknown layout {text!r}", where="--layout", remedy=f"Use one of {', '.join(LAYOUTS)}."
        )
    return by_name[plain]


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


def layouts_of(count: int) -> tuple[str, ...]:
    """Names of the layouts with so many points, the usual one first."""
    return tuple(name for name, points in LAYOUTS.items() if len(points) == count)


def exchanged(name: str) -> str:
    """The same point of the other side."""
    for side, other in (("left", "right"), ("right", "left")):
        if name.startswith(f"{side}_"):
            return f"{other}_{name.removeprefix(side + '_')}"
        if name.endswith(f"_{side}"):
            return f"{name.removesuffix('_' + side)}_{other}"
    return name
