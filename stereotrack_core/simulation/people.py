"""The people of the simulation: lengths and builds, different from the tracker's own body."""

import math
import zlib
from dataclasses import dataclass, fields, replace

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Subject

_SHARES = {
    "shoulder_width": 0.210,
    "hip_width": 0.118,
    "torso_length": 0.282,
    "upper_arm": 0.168,
    "forearm": 0.150,
    "hand": 0.108,
    "shoulder_to_head": 0.116,
    "thigh": 0.246,
    "shank": 0.244,
    "ankle_height": 0.042,
}
"""Lengths between joint centres as shares of the stature, near the middle of the tables in
Winter, Biomechanics and Motor Control of Human Movement (2009), chapter 4."""

_UPRIGHT = ("ankle_height", "shank", "thigh", "torso_length", "shoulder_to_head")
_SPREAD = 0.03  # standard deviation of a length as share of itself; cut at one and a half


@dataclass(frozen=True)
class Person:
    """One person; lengths in metres between joint centres.

    `shoulder_width` and `hip_width` and `torso_length` and `upper_arm` and `forearm` and `hand`: as
    `Subject` names them; `hand` is wrist to fingertip.
    """

    name: str
    stature: float
    shoulder_width: float
    hip_width: float
    torso_length: float
    upper_arm: float
    forearm: float
    hand: float
    shoulder_to_head: float  # shoulder midpoint to the centre of the head
    thigh: float
    shank: float
    ankle_height: float
    girth: float  # factor on the radii of the trunk
    muscle: float  # factor on the radii of the limbs
    hips: float  # factor on the width of the pelvis

    @property
    def arm(self) -> float:
        """Shoulder to wrist, stretched."""
        return self.upper_arm + self.forearm

    @property
    def leg(self) -> float:
        """Hip to ankle, stretched."""
        return self.thigh + self.shank

    def subject(self) -> Subject:
        """The lengths as a person would measure them for ``subject.toml``."""
        return Subject(
            name=self.name,
            shoulder_width=self.shoulder_width,
            hip_width=self.hip_width,
            torso_length=self.torso_length,
            upper_arm_length=self.upper_arm,
            forearm_length=self.forearm,
            hand_length=self.hand,
            shoulder_to_head=self.shoulder_to_head,
        )


def _person(name: str, stature: float, girth: float, muscle: float, hips: float) -> Person:
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    lengths = {
        key: share * stature * (1 + _SPREAD * float(np.clip(rng.normal(), -1.5, 1.5)))
        for key, share in _SHARES.items()
    }
    above_head_centre = 0.122 * math.sqrt(stature / 1.75)
    tall = sum(lengths[key] for key in _UPRIGHT) + above_head_centre
    lengths = {key: length * stature / tall for key, length in lengths.items()}
    return Person(name, stature, **lengths, girth=girth, muscle=muscle, hips=hips)


PEOPLE: dict[str, Person] = {
    person.name: person
    for person in (
        _person("P1", 1.89, girth=0.96, muscle=0.97, hips=0.95),
        _person("P2", 1.75, girth=1.04, muscle=1.06, hips=1.00),
        _person("P3", 1.99, girth=1.12, muscle=1.10, hips=0.98),
        _person("P4", 1.68, girth=0.93, muscle=0.90, hips=1.10),
    )
}
"""The four people by name."""


def person_named(name: str) -> Person:
    """The person of that name; raises :class:`InputError` for an unknown one."""
    try:
        return PEOPLE[name]
    except KeyError:
        raise InputError(
            f"unknown person {name!r}", where="--person", remedy=f"Use one of {', '.join(PEOPLE)}."
        ) from None


def grown(person: Person, stature: float) -> Person:
    """The person scaled to another stature in metres; girth and muscle are factors and stay."""
    factor = stature / person.stature
    lengths = {
        field.name: factor * getattr(person, field.name)
        for field in fields(person)
        if field.name not in {"name", "girth", "muscle", "hips"}
    }
    return replace(person, **lengths)


def girth_scale(person: Person) -> float:
    """Factor by which radii of the average body (1.75 m) grow with the stature."""
    return math.sqrt(person.stature / 1.75)
