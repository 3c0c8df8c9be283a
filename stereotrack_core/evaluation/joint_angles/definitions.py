"""Which joint angles there are, and exactly what each means.

As far as nine landmarks have them, the angles are those that the International Society of
Biomechanics recommends: Wu et al., J. Biomech. 38 (2005) 981-992,
doi:10.1016/j.jbiomech.2004.05.042. Left sides are mirrored at the person's plane of symmetry, so
that the same movement of either arm has the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

Side: TypeAlias = Literal["", "left", "right"]

NEAR_POLE = np.radians(10.0)
"""An upper arm that hangs down or points up more nearly than this has no plane of elevation."""

NEARLY_STRAIGHT = np.radians(20.0)
"""An elbow that is bent less does not show how the upper arm is turned about its own axis."""

NEARLY_SIDEWAYS = np.radians(80.0)
"""A torso or head that leans more to a side has neither a turn nor a tilt forward."""


@dataclass(frozen=True)
class AngleDefinition:
    """One angle.

    Attributes
    ----------
    name : str
        Key, for example ``"left_shoulder_elevation"``.
    label : str
        For people, without the side.
    joint : str
        ``torso``, ``head``, ``shoulder`` or ``elbow``.
    side : "", "left" or "right"
    limb : str
        Limb whose colour it has.
    meaning : str
        What is zero, and what is positive.
    lowest : float or None
        Where the range of one turn begins, radians; None for an angle that cannot go round.
    continues : bool
        Whether turns are counted on over frames in which the angle is not known.
    """

    name: str
    label: str
    joint: str
    side: Side
    limb: str
    meaning: str
    lowest: float | None = None
    continues: bool = False

    @property
    def kind(self) -> str:
        """The name without the side: what left and right have in common."""
        return self.name.removeprefix(f"{self.side}_") if self.side else self.name

    @property
    def words(self) -> str:
        """The label with the side."""
        return f"{self.side} {self.label}".strip()


def _arm(side: Literal["left", "right"]) -> tuple[AngleDefinition, ...]:
    return (
        AngleDefinition(
            f"{side}_shoulder_plane", "shoulder plane of elevation", "shoulder", side,
            f"{side}_upper_arm",
            "0 when the upper arm is raised sideways (abduction), 90 forwards (flexion), negative "
            "backwards; undefined within 10 deg of hanging down or pointing up",
            lowest=float(np.radians(-135.0)),
        ),
        AngleDefinition(
            f"{side}_shoulder_elevation", "shoulder elevation", "shoulder", side,
            f"{side}_upper_arm",
            "0 when the upper arm hangs along the torso, 90 at a right angle, 180 pointing up",
        ),
        AngleDefinition(
            f"{side}_shoulder_rotation", "shoulder axial rotation", "shoulder", side,
            f"{side}_upper_arm",
            "rotation of the upper arm about its own axis, measured by the forearm: internal "
            "positive, external negative; undefined when the elbow is bent less than 20 deg or "
            "the plane of elevation is undefined",
            lowest=-float(np.pi),
        ),
        AngleDefinition(
            f"{side}_elbow_flexion", "elbow flexion", "elbow", side, f"{side}_forearm",
            "0 when the arm is straight, positive when bent",
        ),
    )  # fmt: skip


ANGLES: tuple[AngleDefinition, ...] = (
    AngleDefinition(
        "torso_turn", "torso rotation", "torso", "", "torso",
        "0 facing north (the world's y axis), positive to the person's left; full turns are "
        "accumulated; undefined when the torso leans more than 80 deg to a side",
        lowest=-float(np.pi), continues=True,
    ),
    AngleDefinition(
        "torso_forward", "torso forward tilt", "torso", "", "torso",
        "0 upright, positive when bent forwards, negative backwards; undefined when the torso "
        "leans more than 80 deg to a side",
        lowest=-float(np.pi),
    ),
    AngleDefinition(
        "torso_sideways", "torso lateral tilt", "torso", "", "torso",
        "0 when the shoulders are level, positive when the person's right shoulder is lower",
    ),
    AngleDefinition(
        "head_forward", "head forward tilt", "head", "", "head",
        "relative to the torso: 0 when the head landmark is straight above the shoulders, "
        "positive forwards",
        lowest=-float(np.pi),
    ),
    AngleDefinition(
        "head_sideways", "head lateral tilt", "head", "", "head",
        "relative to the torso: positive towards the person's right shoulder",
    ),
    *_arm("left"),
    *_arm("right"),
)  # fmt: skip
"""All angles; every array of angles has this order."""

NAMES: tuple[str, ...] = tuple(angle.name for angle in ANGLES)


def place_of(name: str) -> int:
    """Place of an angle in arrays.

    Raises
    ------
    ValueError
        For a name that no angle has.
    """
    return NAMES.index(name)


def sided() -> tuple[tuple[int, int], ...]:
    """Places of the left and the right angle of every pair."""
    return tuple(
        (i, place_of(f"right_{angle.kind}"))
        for i, angle in enumerate(ANGLES)
        if angle.side == "left"
    )
