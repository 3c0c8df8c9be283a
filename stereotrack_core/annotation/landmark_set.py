"""Sets of landmarks to click, as data: names, colours, limbs, and places on the body."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.toml_table import load_toml

_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")
_FARTHEST = 1.0  # metres; a landmark farther than this from its part is a slip


@dataclass(frozen=True)
class Landmark:
    """A place on the body that people click."""

    name: str  # as in clicks and trajectories; left and right are the person's own
    colour: str  # ``#rrggbb``
    limb: str  # one of ``LIMBS``: where it is listed, and whose direction it tells
    part: str  # one of the body's ``PARTS``: what it is fixed to
    along: float = 0.0  # share of the part's length from its joint along its z axis
    across: float = 0.0  # share of the hip width along the part's x axis (the torso's points right)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Metres in the part's frame, added to that."""
    mirror: str = ""  # the landmark of the other side, that it may be mixed up with; empty: none

    @property
    def label(self) -> str:
        """The name as a person reads it."""
        return self.name.replace("_", " ")


@dataclass(frozen=True)
class LandmarkSet:
    """Landmarks in the order of their keys. Raises InputError for one that is not usable."""

    name: str
    landmarks: tuple[Landmark, ...]

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise InputError("the landmark set has no name", remedy="Give it one.")
        if not self.landmarks:
            raise InputError("there are no landmarks", self.name, "Add at least one.")
        counts = Counter(landmark.name for landmark in self.landmarks)
        name, count = counts.most_common(1)[0]
        if count > 1:
            what = f"{count} landmarks have the name {name!r}"
            raise InputError(what, self.name, "Rename all but one.")
        for landmark in self.landmarks:
            _check(landmark, f"{self.name}, {landmark.name}")
            other = landmark.mirror
            if other and (other not in counts or self[other].mirror != landmark.name):
                what = f"its mirror {other!r} does not name it as its mirror"
                remedy = "Both landmarks of a pair must name each other as mirror."
                raise InputError(what, f"{self.name}, {landmark.name}", remedy)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names in their order."""
        return tuple(landmark.name for landmark in self.landmarks)

    def __getitem__(self, name: str) -> Landmark:
        """The landmark of that name; KeyError where there is none."""
        return {one.name: one for one in self.landmarks}[name]

    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Landmarks of both sides that may be mixed up, each pair once."""
        place = {name: i for i, name in enumerate(self.names)}
        both = ((one.name, one.mirror) for one in self.landmarks if one.mirror)
        return tuple(pair for pair in both if place[pair[0]] < place[pair[1]])

    def places(self, body: BodyModel, frames: PartFrames) -> FloatArray:
        """Where the landmarks are (..., n, 3), world, metres, in the order of :attr:`names`."""
        parts = [PARTS.index(one.part) for one in self.landmarks]
        rotations, in_parts = frames.rotations[..., parts, :, :], self.in_parts(body)
        return frames.origins[..., parts, :] + (rotations @ in_parts[..., None])[..., 0]

    def in_parts(self, body: BodyModel) -> FloatArray:
        """Where the landmarks are (n, 3) in the frames of their parts, metres."""
        places = np.array([one.offset for one in self.landmarks])
        for place, one in zip(places, self.landmarks, strict=True):
            place[2] += one.along * body.skeleton.lengths[PARTS.index(one.part)]
            place[0] += one.across * body.skeleton.proportions.hip_width
        return places

    def facts(self) -> dict[str, Any]:
        """The set as plain data; :func:`landmark_set_of` makes it again."""
        return {"name": self.name, "landmarks": [asdict(one) for one in self.landmarks]}


_NUMBERS: Kind = {"along": float, "across": float, "offset": [float, float, float]}
_TEXTS: Kind = dict.fromkeys(("name", "colour", "limb", "part", "mirror"), str)
_KIND: Kind = {"name": str, "landmarks": [{**_TEXTS, **_NUMBERS}]}
_REMEDY = "It must have name, colour, limb, part, along, across, offset (x, y, z) and mirror."


def landmark_set_of(facts: Mapping[str, Any]) -> LandmarkSet:
    """The set that plain data describe; InputError where they do not describe one."""
    name = str(facts.get("name", ""))
    check_kind(facts, _KIND, name, _REMEDY)
    try:
        landmarks = [
            Landmark(**{**one, "offset": tuple(one.get("offset", (0.0, 0.0, 0.0)))})
            for one in facts.get("landmarks") or ()
        ]
    except TypeError as error:
        raise InputError(f"a landmark cannot be read ({error})", name, _REMEDY) from error
    return LandmarkSet(name, tuple(landmarks))


def _check(landmark: Landmark, where: str) -> None:
    if not landmark.name or any(sign in landmark.name for sign in ',;"\n\t'):
        what = f"{landmark.name!r} is not a valid name"
        raise InputError(what, where, "Use letters, digits and _.")
    if not _COLOUR.fullmatch(landmark.colour):
        raise InputError(f"{landmark.colour!r} is not a colour", where, "Write it as #rrggbb.")
    for word, known in ((landmark.limb, LIMBS), (landmark.part, PARTS)):
        if word not in known:
            raise InputError(f"unknown name {word!r}", where, f"Use one of {', '.join(known)}.")
    numbers = np.array([landmark.along, landmark.across, *landmark.offset])
    if numbers.shape != (5,) or not np.isfinite(numbers).all() or (abs(numbers) > _FARTHEST).any():
        remedy = "Fractions and offsets (three, in metres) must be between -1 and 1."
        raise InputError("the position is not on the body", where, remedy)


def _both_sides(
    place: str,
    limb: str,
    part: str,
    colours: tuple[str, str],
    along: float = 0.0,
    to_the_right: float = 0.0,
) -> Iterator[Landmark]:
    for side, other, colour, across in (
        ("left", "right", colours[0], 0.0 - to_the_right),
        ("right", "left", colours[1], to_the_right),
    ):
        own, fixed_to = limb.format(side=side), part.format(side=side)
        mirror = f"{other}_{place}"
        yield Landmark(f"{side}_{place}", colour, own, fixed_to, along, across, mirror=mirror)


_UPPER, _FORE, _GREY = ("#0072B2", "#D55E00"), ("#56B4E9", "#E69F00"), ("#8c8c8c", "#8c8c8c")
_UPPER_ARM, _FOREARM = "{side}_upper_arm", "{side}_forearm"

NINE = LandmarkSet(
    "nine landmarks",
    (
        *_both_sides("shoulder", _UPPER_ARM, _UPPER_ARM, _UPPER),
        *_both_sides("elbow", _UPPER_ARM, _FOREARM, _UPPER),
        *_both_sides("hand", _FOREARM, _FOREARM, _FORE, along=1.0),
        Landmark("head", "#009E73", "head", "head", along=1.0),
        *_both_sides("hip", "torso", "torso", _GREY, to_the_right=0.5),
    ),
)
"""The landmarks of every reference and run, in the order of ``LANDMARKS``."""


def read_landmark_set(path: Path) -> LandmarkSet:
    """The set that a file describes, without a name the file's. Raises InputError."""
    facts: dict[str, Any] = {"name": path.stem, **load_toml(path)}
    try:
        return landmark_set_of(facts)
    except InputError as error:
        where = f"{path.name}, {error.where}" if error.where else path.name
        raise InputError(error.what, where, error.remedy) from error
