"""The nine landmarks of the markers of other programs, by name or by a usual marker set.

Joint centres follow from markers on the skin by published rules. Each rule has the error, in
millimetres, that its landmark has then besides that of the measurement. Hips: Harrington et al.
2007, from MRI of 32 people; shoulders: Rab et al. 2002. Errors of elbows, hands and head are
estimates from the breadth of these parts.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.interop.label_source import map_names
from stereotrack_core.interop.landmark_file import FileAxes, Stated, check_axes
from stereotrack_core.interop.marker_sets import MARKER_SETS
from stereotrack_core.recording.landmarks import LANDMARKS

_SIDES = {"L": "left", "R": "right"}
_OTHER = {"left": "right", "right": "left"}
_SEPARATORS = re.compile(r"[\s._-]+")
_FOOT = re.compile(r"ankle|heel|toe|foot")
_LEAST_MARKERS = 4
"""Markers of a set that a file needs to be taken for one of it: two may be called so by chance."""
_ANYWHERE = ("foot", "upper_trunk", "lower_trunk")
"""Places that tell the person's direction alone; sets are not recognised by them."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Points of a file (F, N, 3), metres, its axes, NaN if missing; `place`: of the labels."""

    labels: Sequence[str]
    points: FloatArray
    axes: FileAxes
    path: Path
    place: str

    @property
    def where(self) -> str:
        """Where its labels are."""
        return f"{self.path}, {self.place}"


@dataclass(frozen=True)
class _Rule:
    """How a landmark follows from markers at `places`."""

    places: tuple[str, ...]
    formula: Callable[[Sequence[FloatArray], str], FloatArray]
    words: str
    error_mm: float


def _mean(points: Sequence[FloatArray], _side: str) -> FloatArray:
    return np.asarray(np.mean(np.stack(points), axis=0))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length == 0.0, np.nan, length))


def _shoulder(points: Sequence[FloatArray], _side: str) -> FloatArray:
    """Down the trunk from the acromion, by a share of the distance between both (Rab)."""
    acromion, other, pelvis = points
    width = np.linalg.norm(acromion - other, axis=-1, keepdims=True)
    return np.asarray(acromion + 0.17 * width * _unit(pelvis - (acromion + other) / 2.0))


def _hip(points: Sequence[FloatArray], side: str) -> FloatArray:
    """Harrington's regression on the pelvis's width and depth, from the middle of both ASIS."""
    left, right, back = points
    middle, across = (left + right) / 2.0, right - left
    width = np.linalg.norm(across, axis=-1, keepdims=True)
    depth = np.linalg.norm(middle - back, axis=-1, keepdims=True)
    to_the_right = _unit(across)
    up = _unit(np.cross(across, middle - back))
    forwards = np.cross(up, to_the_right)
    sign = 1.0 if side == "right" else -1.0
    return np.asarray(
        middle
        - (0.24 * depth + 0.0099) * forwards
        - (0.30 * width + 0.0109) * up
        + sign * (0.33 * width + 0.0073) * to_the_right
    )


_HAND_BY_WRIST = AVERAGE.elbow_to_hand / AVERAGE.forearm_length


def _hand(points: Sequence[FloatArray], _side: str) -> FloatArray:
    """On the way from the elbow through the middle of the wrist, as in an average arm."""
    elbow, *wrist = points
    return np.asarray(elbow + _HAND_BY_WRIST * (_mean(wrist, _side) - elbow))


_STRAIGHT = "the forearm made longer, as if the wrist was straight"
_RULES: Mapping[str, tuple[_Rule, ...]] = {
    "hip": (
        _Rule(("{side} hip_centre",), _mean, "joint centre", 10.0),
        _Rule(("left asis", "right asis", "pelvis back"), _hip, "Harrington 2007", 10.0),
    ),
    "shoulder": (
        _Rule(("{side} shoulder_centre",), _mean, "joint centre", 10.0),
        _Rule(("{side} acromion", "{other} acromion", "pelvis"), _shoulder, "Rab 2002", 20.0),
        _Rule(("{side} acromion",), _mean, "the marker on the acromion itself", 60.0),
    ),
    "elbow": (
        _Rule(("{side} elbow_centre",), _mean, "joint centre", 10.0),
        _Rule(("{side} lateral_elbow", "{side} medial_elbow"), _mean, "middle", 10.0),
        _Rule(("{side} lateral_elbow",), _mean, "the lateral marker itself", 40.0),
    ),
    "hand": (
        _Rule(("{side} hand_centre",), _mean, "centre", 10.0),
        _Rule(("{side} second_knuckle", "{side} fifth_knuckle"), _mean, "middle", 15.0),
        _Rule(("{side} middle_knuckle",), _mean, "the marker itself", 20.0),
        _Rule(("{side}_elbow", "{side} wrist_centre"), _hand, _STRAIGHT, 40.0),
        _Rule(("{side}_elbow", "{side} radial_wrist", "{side} ulnar_wrist"), _hand, _STRAIGHT, 40),
    ),
    "head": (
        _Rule(("head_centre",), _mean, "centre", 20.0),
        _Rule(("left side_head", "right side_head"), _mean, "middle", 30.0),
        _Rule(
            ("left front_head", "right front_head", "left back_head", "right back_head"),
            _mean,
            "middle",
            30.0,
        ),
    ),
}
"""In the order in which they need one another; the first rule holds whose places are there."""


def landmarks_in_world(markers: Markers, stated: Stated) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Landmarks (F, 9, 3), world, and notes; InputError: :func:`body_of`, :func:`.check_axes`."""
    lost = (markers.points == 0.0).all(axis=-1)
    lost &= (lost.sum(axis=1, keepdims=True) > 1) | ~lost.all(axis=0)  # else the origin itself
    points = np.where(lost[..., None], np.nan, markers.points)
    markers = replace(markers, points=points)
    landmarks, trunk, legs, notes = body_of(markers, stated.names)
    if lost.any():
        what = f"{counted(int(lost.sum()), 'place')} of markers at 0, 0, 0 taken as missing"
        notes.append(_note(markers, what))
    axes = markers.axes
    if stated.world_from_file is not None:
        axes = FileAxes(stated.world_from_file, "as stated", is_certain=True)
    elif stated.tilted:
        axes = replace(axes, is_certain=True)
    directions = {"trunk": trunk, "legs": legs}
    note = check_axes(axes, directions, markers.points, str(markers.path))
    world_from_file = stated.up.rotation.T @ axes.world_from_file
    return landmarks @ world_from_file.T, (note, *notes)


def body_of(
    markers: Markers, stated: Mapping[str, str]
) -> tuple[FloatArray, FloatArray, FloatArray, list[Finding]]:
    """Landmarks (F, 9, 3), vectors (F, 3) from pelvis to neck and from feet to pelvis, and notes.

    In metres and the file's axes, NaN where not known. `stated` names go before those that are
    alike (:func:`.map_names`), and these before the usual marker sets. InputError where no landmark
    is there, two labels mean the same one, or there are markers of several people.
    """
    labels, stated = _plain_labels(markers.labels, stated)
    there: BoolArray = np.asarray(np.isfinite(markers.points).all(axis=-1).any(axis=0))
    marker_set, places = _recognised(labels, there)
    shorter = _without_prefix(labels)
    if marker_set is None and _recognised(shorter, there)[0]:
        of_full = dict(zip(labels, shorter, strict=True))
        stated = {of_full.get(name, name): ours for name, ours in stated.items()}
        labels = shorter
        marker_set, places = _recognised(labels, there)
    names = [name for name in dict.fromkeys(labels) if name]
    known = map_names(names, LANDMARKS, stated, where=markers.where, needed=marker_set is None)
    _check_unique(markers, labels, {*known, *(name for own in places.values() for name in own)})
    at = {place: _mean_of(markers, labels, own) for place, own in places.items()}
    at |= {ours: _mean_of(markers, labels, [name]) for name, ours in known.items()}
    notes = [] if marker_set is None else [_note(markers, f"its labels are those of {marker_set}")]
    notes += [_note(markers, text) for text in _add_landmarks(at, places)]
    points = np.full((len(markers.points), len(LANDMARKS), 3), np.nan)
    for k, name in enumerate(LANDMARKS):
        if name in at:
            points[:, k] = at[name]
    missing = [name for name in LANDMARKS if name not in at]
    if len(missing) == len(LANDMARKS):
        map_names(names, LANDMARKS, stated, where=markers.where)  # refuses them
    if missing:
        notes.append(_note(markers, f"no label tells {', '.join(missing)}"))
    feet = [name for place, own in places.items() if place.endswith("foot") for name in own]
    named = (name for name in names if _FOOT.search(name.lower()))
    feet = feet or [name for name in named if there[labels.index(name)]]
    return points, *_directions(at, _mean_of(markers, labels, feet)), notes


def _note(markers: Markers, what: str) -> Finding:
    return Finding("note", markers.where, what, "")


def _mean_of(markers: Markers, labels: Sequence[str], names: Sequence[str]) -> FloatArray:
    """Mean (F, 3) of the markers of these names; NaN if one is missing, or there is none."""
    if not names:
        return np.full((len(markers.points), 3), np.nan)
    return _mean([markers.points[:, labels.index(name)] for name in names], "")


def _plain_labels(
    labels: Sequence[str], stated: Mapping[str, str]
) -> tuple[list[str], dict[str, str]]:
    """Labels without a subject and a colon, and the stated names, which may choose a subject."""
    full = [label.strip() for label in labels]
    chosen = {name.rpartition(":")[0] for name in stated if name in full and ":" in name}
    plain = []
    for name in full:
        subject, _, own = name.rpartition(":")
        plain.append("" if len(chosen) == 1 and subject not in chosen else own.strip())
    of_full = dict(zip(full, plain, strict=True))
    return plain, {of_full.get(name) or name: ours for name, ours in stated.items()}


def _without_prefix(labels: Sequence[str]) -> list[str]:
    """Labels without a subject's name and the underscore behind it, such as ``Kim_HeadL``."""
    first = Counter(name.partition("_")[0] for name in labels if "_" in name)
    common = first.most_common(1)[0][0] if first else ""
    return [name.removeprefix(f"{common}_") for name in labels]


def _check_unique(markers: Markers, labels: Sequence[str], used: set[str]) -> None:
    """Refuse labels that are used and stand in the file more than once."""
    twice = next((name for name in labels if name in used and labels.count(name) > 1), None)
    if twice is not None:
        own = [label for label, name in zip(markers.labels, labels, strict=True) if name == twice]
        subjects = dict.fromkeys(label.rpartition(":")[0] for label in own)
        what, remedy = f"{len(own)} markers have the label {twice!r}", "Rename one of them."
        if len(subjects) > 1:
            what = f"the file has markers of {len(subjects)} people ({', '.join(subjects)})"
            choice = f"with a label in full, for example --name {own[0]}=left_shoulder"
            remedy = f"Choose one of them {choice}, or export one person alone."
        raise InputError(what, markers.where, remedy)


def _recognised(labels: Sequence[str], there: BoolArray) -> tuple[str | None, dict[str, list[str]]]:
    """Name of the marker set that fits best, and labels of its places, such as ``left acromion``.

    One label of each place, and all of feet and trunk; `there` (N,): markers that are ever seen.
    """
    best: tuple[int, str | None, dict[str, list[str]]] = (_LEAST_MARKERS - 1, None, {})
    known = [name for name, is_there in zip(labels, there, strict=True) if is_there and name]
    by_sign = {_SEPARATORS.sub("", name).upper(): name for name in reversed(known)}
    for marker_set, of_set in MARKER_SETS.items():
        places: dict[str, list[str]] = {}
        for (place, patterns), (sign, side) in product(of_set.items(), _SIDES.items()):
            signs = patterns.replace("{S}", sign).split()
            if own := [by_sign[one] for one in signs if one in by_sign]:
                name = f"{side} {place}" if "{S}" in patterns else place
                places[name] = own if place in _ANYWHERE else own[:1]
        count = sum(not place.endswith(_ANYWHERE) for place in places)
        if count > best[0]:
            best = count, marker_set, places
    return best[1:]


def _add_landmarks(at: dict[str, FloatArray], places: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Add the landmarks that the places tell, and say by which rule; nothing is replaced."""
    labels = {place: list(own) for place, own in places.items()}
    for back in (("left psis", "right psis"), ("sacrum",)):
        if "pelvis back" not in at and all(place in at for place in back):
            at["pelvis back"] = _mean([at[place] for place in back], "")
            labels["pelvis back"] = [name for place in back for name in labels[place]]
    for kind, rules in _RULES.items():
        made: dict[str, list[str]] = {}
        for side, other in _OTHER.items():
            landmark = kind if kind == "head" else f"{side}_{kind}"
            for rule in rules if landmark not in at else ():
                needed = [place.format(side=side, other=other) for place in rule.places]
                if all(place in at for place in needed):
                    at[landmark] = rule.formula([at[place] for place in needed], side)
                    used = [name for place in needed for name in labels.get(place, [place])]
                    text = f"{rule.words}, within about {rule.error_mm:.0f} mm"
                    made.setdefault(text, []).append(f"{landmark} of {', '.join(used)}")
                    break
        yield from (f"{'; '.join(ones)}: {text}" for text, ones in made.items())
        if kind == "hip" and all(f"{side}_hip" in at for side in _OTHER):
            at["pelvis"] = _mean([at[f"{side}_hip"] for side in _OTHER], "")
            labels["pelvis"] = ["the hips"]
        elif kind == "hip" and "lower_trunk" in at:
            at["pelvis"], labels["pelvis"] = at["lower_trunk"], labels["lower_trunk"]


def _directions(at: Mapping[str, FloatArray], feet: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Trunk and legs (F, 3): from the pelvis to the neck, from the feet to the pelvis."""
    unknown: FloatArray = np.full_like(feet, np.nan)

    def middle(*places: str) -> FloatArray:
        return _mean([at.get(place, unknown) for place in places], "")

    def first(*points: FloatArray) -> FloatArray:
        return next((one for one in points if np.isfinite(one).any()), unknown)

    shoulders = first(
        middle("left_shoulder", "right_shoulder"), middle("left acromion", "right acromion")
    )
    pelvis = first(middle("left_hip", "right_hip"), middle("left asis", "right asis"))
    neck = first(shoulders, at.get("upper_trunk", unknown), at.get("head", unknown))
    trunk = first(neck - pelvis, at.get("head", unknown) - shoulders)
    return trunk, pelvis - feet
