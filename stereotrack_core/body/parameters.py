"""Parameters of the body's shape; lengths come from the subject."""

import dataclasses
from dataclasses import dataclass

from stereotrack_core.body.outline_parameters import OutlineParameters
from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Body"


@dataclass(frozen=True)
class BodyParameters(ParameterGroup):
    """Shape of the cones, for a person of average size; they grow with the proportions."""

    proportions: str = parameter(
        "individual",
        "Segment lengths: of the recording's subject file, average lengths, or estimated from the "
        "sequence (its first part is then tracked twice).",
        group=_GROUP,
        choices=("individual", "average", "sequence"),
        thesis="individual",
    )
    legs: bool = parameter(
        True,
        "Add cones for the legs, so that leg points are not assigned to other parts.",
        group=_GROUP,
        thesis=False,
    )
    girdle: bool = parameter(
        True,
        "Let the shoulders be raised, protracted and retracted. Otherwise they are fixed to the "
        "torso.",
        group=_GROUP,
        thesis=False,
    )
    torso_radius_low: float = parameter(
        0.165, "Radius of the torso at the hips.", group=_GROUP, unit="m", minimum=0.05, maximum=0.4
    )
    torso_radius_high: float = parameter(
        0.175,
        "Radius of the torso at the shoulders.",
        group=_GROUP,
        unit="m",
        minimum=0.05,
        maximum=0.4,
    )
    torso_flatness: float = parameter(
        0.62, "Depth of the torso relative to its width.", group=_GROUP, minimum=0.3, maximum=1.0
    )
    torso_forward_low: float = parameter(
        0.03,
        "Forward offset of the torso centre at the hips.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
        thesis=0.0,
    )
    torso_forward_high: float = parameter(
        0.015,
        "Forward offset of the torso centre at the shoulders.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
        thesis=0.0,
    )
    shoulder_rise: float = parameter(
        0.0,
        "Height of the shoulder cones above the shoulder joints.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
    )
    shoulder_radius_factor: float = parameter(
        1.0, "Scale of the shoulder radii.", group=_GROUP, minimum=0.3, maximum=3.0
    )
    head_rise: float = parameter(
        0.0,
        "Height of the widest point of the head above the head landmark.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
    )
    head_radius_factor: float = parameter(
        1.0, "Scale of the head radii.", group=_GROUP, minimum=0.3, maximum=3.0
    )
    leg_forward: float = parameter(
        0.015,
        "Forward offset of the leg centre at hips and knees.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
    )
    head_forward: float = parameter(
        0.015,
        "Forward offset of the head centre at the neck.",
        group=_GROUP,
        unit="m",
        minimum=-0.2,
        maximum=0.2,
        thesis=0.0,
    )
    arm_radius_factor: float = parameter(
        1.0, "Scale of the radii of arms and hands.", group=_GROUP, minimum=0.3, maximum=3.0
    )
    leg_radius_factor: float = parameter(
        1.0, "Scale of the leg radii.", group=_GROUP, minimum=0.3, maximum=3.0
    )
    outline: OutlineParameters = dataclasses.field(default_factory=OutlineParameters)
