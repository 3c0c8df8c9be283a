"""Names of the keypoints of usual 2-D detectors, and which of our landmarks they measure.

Every detector's points have the names that this module gives them, whatever its files call them:
``left_wrist`` is what COCO calls so, ``LWrist`` in OpenPose, ``left wrist`` in a label set.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError

_GROUPS: Mapping[str, tuple[str, ...]] = {
    "FACE": ("nose", "left_eye", "right_eye", "left_ear", "right_ear"),
    "ARMS": tuple(f"{s}_{n}" for n in ("shoulder", "elbow", "wrist") for s in ("left", "right")),
    "LEGS": tuple(f"{s}_{n}" for n in ("hip", "knee", "ankle") for s in ("left", "right")),
    "FEET": tuple(f"{s}_{n}" for s in ("left", "right") for n in ("big_toe", "small_toe", "heel")),
    **{f"{s}_arm": tuple(f"{s}_{n}" for n in ("shoulder", "elbow", "wrist"))
       for s in ("left", "right")},
    **{f"{s}_leg": tuple(f"{s}_{n}" for n in ("hip", "knee", "ankle")) for s in ("left", "right")},
}  # fmt: skip
"""Points that follow each other in several layouts."""


def _points(text: str, count: int = 0) -> tuple[str, ...]:
    """Names of points and groups; up to `count` follow those of face and hands, which tell nothing
    about the body.
    """
    names = [name for word in text.split() for name in _GROUPS.get(word, (word,))]
    return (*names, *(f"point_{i}" for i in range(len(names), count)))


COCO_17: tuple[str, ...] = _points("FACE ARMS LEGS")
"""COCO 2017 person keypoints; the first 17 of COCO-WholeBody."""

MEDIAPIPE_33: tuple[str, ...] = _points(
    "nose left_eye_inner left_eye left_eye_outer right_eye_inner right_eye right_eye_outer "
    "left_ear right_ear mouth_left mouth_right ARMS left_pinky right_pinky left_index right_index "
    "left_thumb right_thumb LEGS left_heel right_heel left_foot_index right_foot_index"
)
"""MediaPipe's pose landmarks, also known as BlazePose."""

_COCO_18 = "nose neck right_arm left_arm right_leg left_leg right_eye left_eye right_ear left_ear"
_HALPE_26 = (
    "FACE ARMS LEGS head_top neck mid_hip left_big_toe right_big_toe left_small_toe "
    "right_small_toe left_heel right_heel"
)

LAYOUTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "coco17": COCO_17,
        "coco18": _points(_COCO_18),
        "body25": _points(f"{_COCO_18.replace('left_arm', 'left_arm mid_hip')} FEET"),
        "halpe26": _points(_HALPE_26),
        "mediapipe33": MEDIAPIPE_33,
        "body25b": _points("FACE ARMS LEGS upper_neck head_top FEET"),
        "h36m17": _points("mid_hip right_leg left_leg spine neck face head_top left_arm right_arm"),
        "coco_feet23": _points("FACE ARMS LEGS FEET"),
        "coco133": _points("FACE ARMS LEGS FEET", 133),
        "halpe136": _points(_HALPE_26, 136),
    }
)
"""Layouts by name: names of the points in their order; of equal length the usual one first.

Sources: OpenPose's ``poseParameters.cpp``, MMPose's dataset descriptions, MediaPipe's landmarks.
"""

_SAME_LAYOUT: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("coco", "yolo17", "vitpose17", "posenet17"), "coco17"),
        **dict.fromkeys(("openpose18", "cococmu", "body18", "openposecoco"), "coco18"),
        **dict.fromkeys(("openpose", "openpose25"), "body25"),
        **dict.fromkeys(("halpe", "body26", "rtmpose26"), "halpe26"),
        **dict.fromkeys(("blazepose", "blazepose33", "mediapipe"), "mediapipe33"),
        **dict.fromkeys(("human36m", "human36m17", "h36m"), "h36m17"),
        **dict.fromkeys(("wholebody", "wholebody133", "cocowholebody"), "coco133"),
    }
)
"""Other names of layouts, in lower case without signs."""


def layout_named(text: str) -> str:
    """Name in :data:`LAYOUTS` of a layout as written, such as ``BODY_25B``; InputError for none."""
    plain = re.sub(r"[^a-z0-9]", "", text.lower())
    by_name = {name.replace("_", ""): name for name in LAYOUTS} | dict(_SAME_LAYOUT)
    if plain not in by_name:
        what = f"unknown layout {text!r}"
        raise InputError(what, "--layout", f"Use one of {', '.join(LAYOUTS)}.")
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
    name = "_".join(words_of(theirs))
    return _SAME.get(name, name)


def words_of(name: str) -> tuple[str, ...]:
    """Words of a name with the side first: ``Elbow_L`` becomes ``left``, ``elbow``."""
    words = [word.lower() for word in _WORD.findall(name)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    return (*sides, *(word for word in words if word not in _SIDES))


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


_UNNAMED = re.compile(r"point (\d+) of (\d+)")

_MOST_PEOPLE = 600  # people in single pictures that are looked at, spread over all frames
_FARTHEST = 1e6  # pixels beyond which a number is no place in an image
_FEWEST_BONES = 4  # bones without which a person tells nothing about the order
_MARGIN = 0.05  # misfit by which another order than the usual one must be better
_BODY_LIKE = 0.35  # misfit that another order than the usual one may have at most

_DOUBTFUL = 0.5
"""Misfit above which no known order looks like a body: right ones have 0.15 to 0.45, as of a person
seen from the side, wrong ones of the same number mostly 0.5 to 0.8."""

_MOST = 2.0  # largest deviation of one bone, as a logarithm, so that a gross error counts as one

_FORESHORTENED = 0.5
"""Weight of a bone that is too short, which perspective does, relative to one that is too long."""

_HIDDEN_SHOULDERS = 0.3
"""Misfit if no shoulder is ever seen: of a person behind a table, legs are missing and not they."""

_BONES: Mapping[tuple[str, str], float] = {
    **{("nose", f"{s}_eye"): 0.045 for s in ("left", "right")},
    **{(f"{s}_eye", f"{s}_ear"): 0.09 for s in ("left", "right")},
    **{("nose", f"{s}_ear"): 0.13 for s in ("left", "right")},
    **{(f"{s}_ear", f"{s}_shoulder"): 0.24 for s in ("left", "right")},
    **{("neck", f"{s}_shoulder"): 0.18 for s in ("left", "right")},
    **{("upper_neck", f"{s}_shoulder"): 0.21 for s in ("left", "right")},
    **{(f"{s}_shoulder", f"{s}_elbow"): 0.28 for s in ("left", "right")},
    **{(f"{s}_elbow", f"{s}_wrist"): 0.25 for s in ("left", "right")},
    **{(f"{s}_wrist", f"{s}_index"): 0.10 for s in ("left", "right")},
    **{(f"{s}_shoulder", f"{s}_hip"): 0.50 for s in ("left", "right")},
    **{("mid_hip", f"{s}_hip"): 0.11 for s in ("left", "right")},
    **{(f"{s}_hip", f"{s}_knee"): 0.42 for s in ("left", "right")},
    **{(f"{s}_knee", f"{s}_ankle"): 0.41 for s in ("left", "right")},
    **{(f"{s}_ankle", f"{s}_heel"): 0.08 for s in ("left", "right")},
    **{(f"{s}_ankle", f"{s}_big_toe"): 0.17 for s in ("left", "right")},
    **{(f"{s}_big_toe", f"{s}_small_toe"): 0.07 for s in ("left", "right")},
    ("left_shoulder", "right_shoulder"): 0.36,
    ("left_hip", "right_hip"): 0.22,
    ("nose", "head_top"): 0.20,
    ("neck", "nose"): 0.22,
    ("neck", "head_top"): 0.32,
    ("upper_neck", "head_top"): 0.25,
    ("upper_neck", "nose"): 0.14,
    ("face", "head_top"): 0.15,
    ("neck", "face"): 0.18,
    ("neck", "mid_hip"): 0.52,
    ("spine", "mid_hip"): 0.24,
    ("spine", "neck"): 0.28,
}
"""Lengths of an adult, metres; only their ratios count."""

AnyRow = TypeVar("AnyRow", bound=tuple[object, ...])


def unnamed(count: int, where: str, *, stated: str | None = None) -> Sequence[str]:
    """Names of so many points in a file that names none, as long as their order is not decided.

    Raises InputError if no usual layout has so many points, or fewer than the stated one.
    """
    what = ""
    if stated is not None and count < len(LAYOUTS[stated]):
        what = f"a person has {count} points, the layout {stated} {len(LAYOUTS[stated])}"
    elif stated is None and not layouts_of(count):
        what = f"a person has {count} points, which is none of the usual layouts"
    if what:
        raise InputError(what, where, f"State another layout with --layout: {', '.join(LAYOUTS)}.")
    return [f"point {i} of {count}" for i in range(count)]


@dataclass(frozen=True)
class LayoutChoice:
    """Order of the points of all people with equally many."""

    count: int
    layout: str
    stated: bool
    misfit: float  # logarithmic deviation of the bones from a body's proportions; NaN if unknown
    others: Mapping[str, float]  # the same of the other layouts of that length

    def sentence(self) -> str:
        """The choice and its reason; empty if there was nothing to choose."""
        order = f"{self.count} points without names: in the order of {self.layout}"
        misfits = [(np.nan_to_num(one, nan=np.inf), name) for name, one in self.others.items()]
        least, best = min(misfits, default=(np.inf, ""), key=lambda one: one[0])
        better = least < self.misfit - _MARGIN
        if self.stated:
            doubt = f", although a body's proportions speak for {best}" if better else ""
            return f"{order}, as stated{doubt}"
        doubt = ""
        if self.misfit > _DOUBTFUL:
            doubt = "; no known order looks like a body, so check it in the window"
        if not self.others:
            return f"{order}{doubt}"
        if np.isnan(self.misfit):
            why = "the usual one; no person is seen well enough to tell"
        elif better:
            why = f"the usual one, although {best} looks more like a body"
        elif least < self.misfit + _MARGIN:
            why = "a body's proportions hardly decide it"
        else:
            why = "told by a body's proportions"
        others = f"not of {', '.join(self.others)}{doubt}"
        return f"{order} ({why}), {others}; another order can be stated (--layout)"


def with_layouts(
    rows: Sequence[AnyRow], stated: str | None = None
) -> tuple[list[AnyRow], tuple[LayoutChoice, ...]]:
    """Name the points of rows that have the names of :func:`unnamed`; also the choices made.

    Rows have frame, camera, keypoint, column, row, confidence, source and person. The order of
    points is the `stated` layout, or told by a body's proportions: in the right order, bones are as
    long in a picture as perspective leaves of them; in a wrong one, an eye may be as far from the
    nose as a knee.
    """
    matches = [_UNNAMED.fullmatch(str(row[2])) for row in rows]
    people: dict[int, dict[tuple[object, ...], list[tuple[int, float, float]]]] = {}
    for row, match in zip(rows, matches, strict=True):
        if match is not None:
            own = people.setdefault(int(match[2]), {}).setdefault((row[0], row[1], *row[6:]), [])
            x, y, sure = (float(str(value)) for value in row[3:6])
            if sure > 0.0 and max(abs(x), abs(y)) < _FARTHEST:
                own.append((int(match[1]), x, y))
    seen = {count: [one for one in own.values() if one] for count, own in people.items()}
    choices = {count: _choice(count, own, stated) for count, own in seen.items()}
    names = {n: _points(" ".join(LAYOUTS[one.layout]), n) for n, one in choices.items()}
    named = [
        row if match is None else (*row[:2], names[int(match[2])][int(match[1])], *row[3:])
        for row, match in zip(rows, matches, strict=True)
    ]
    return named, tuple(choices.values())  # type: ignore[return-value]  # the same kind of tuples


def _choice(
    count: int, people: Sequence[Sequence[tuple[int, float, float]]], stated: str | None
) -> LayoutChoice:
    candidates = dict.fromkeys(([stated] if stated else []) + list(layouts_of(count)))
    step = max(1, len(people) // _MOST_PEOPLE)
    places = np.full((len(people[::step]), count, 2), np.nan)
    for own, points in zip(places, people[::step], strict=True):
        for place, x, y in points:
            own[place] = x, y
    misfits = {name: _misfit(places, LAYOUTS[name]) for name in candidates}
    usual = next(iter(candidates))
    best = min(candidates, key=lambda name: np.nan_to_num(misfits[name], nan=np.inf))
    better = misfits[best] < min(misfits[usual] - _MARGIN, _BODY_LIKE)
    chosen = usual if stated or not better else best
    others = {name: misfit for name, misfit in misfits.items() if name != chosen}
    return LayoutChoice(count, chosen, stated is not None, misfits[chosen], others)


def _misfit(places: FloatArray, names: Sequence[str]) -> float:
    """Mean deviation of the bones (P people) from proportions; NaN where too few are seen."""
    known = [(*ends, length) for ends, length in _BONES.items() if set(ends) <= set(names)]
    bones = [(names.index(a), names.index(b), length) for a, b, length in known]
    one, other, length = (np.array(column) for column in zip(*bones, strict=True))
    seen = np.linalg.norm(places[:, one] - places[:, other], axis=2)
    ratio = np.log(np.maximum(seen, 0.5) / length)
    ratio = ratio[np.isfinite(ratio).sum(axis=1) >= _FEWEST_BONES]
    if not len(ratio):
        return float("nan")
    off = ratio - np.nanmedian(ratio, axis=1, keepdims=True)
    off = np.where(off < 0.0, -_FORESHORTENED * off, off)
    shoulders = places[:, [names.index(f"{side}_shoulder") for side in ("left", "right")]]
    hidden = float(np.isnan(shoulders).mean())
    return float(np.nanmean(np.minimum(off, _MOST))) + _HIDDEN_SHOULDERS * hidden
