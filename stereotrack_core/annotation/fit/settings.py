"""Parameters of the fit of the body to clicked landmarks."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_CLICKS, _BODY, _MOVEMENT, _DEPTH = "Clicks", "Body", "Movement", "Depth"


@dataclass(frozen=True)
class FitSettings(ParameterGroup):
    """How the body is fitted to clicks; standard deviations are per axis."""

    use_depth: bool = parameter(
        True, "Use the measured points where the recording has depth.", group=_DEPTH
    )
    mistake_share: float = parameter(
        0.03,
        "Share of clicks that are expected to be gross mistakes.",
        group=_CLICKS,
        minimum=0.0,
        maximum=0.5,
    )
    mistake_spread: float = parameter(
        70.0,
        "Standard deviation of gross mistakes.",
        group=_CLICKS,
        unit="px",
        minimum=5.0,
        maximum=1000.0,
    )
    sigma_joint_shift: float = parameter(
        0.006,
        "How far a person's joints lie off their place on the body of fixed lengths.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_landmark_shift: float = parameter(
        0.006,
        "The same for landmarks that are no joints.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_head_shift: float = parameter(
        0.02,
        "The same for landmarks of the head, which people mean differently.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    shift_time: float = parameter(
        2.0,
        "Time over which such shifts stay alike.",
        group=_BODY,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    speed_position: float = parameter(
        0.25, "Usual speed of the body.", group=_MOVEMENT, unit="m/s", minimum=0.001, maximum=20.0
    )
    speed_rotation: float = parameter(
        120.0,
        "Usual rotation of the torso.",
        group=_MOVEMENT,
        unit="deg/s",
        minimum=0.1,
        maximum=5000.0,
    )
    speed_joint: float = parameter(
        100.0,
        "Usual rotation of a joint.",
        group=_MOVEMENT,
        unit="deg/s",
        minimum=0.1,
        maximum=5000.0,
    )
    speed_time: float = parameter(
        0.3,
        "Time over which a speed is kept.",
        group=_MOVEMENT,
        unit="s",
        minimum=0.001,
        maximum=100.0,
    )
    speed_tail: float = parameter(
        1.5,
        "Degrees of freedom of the movement's distribution: small allows for still stretches "
        "and sudden movements side by side.",
        group=_MOVEMENT,
        minimum=1.0,
        maximum=1000.0,
    )
    longest_fill: float = parameter(
        2.0,
        "Without depth, frames farther than this from every clicked one are not filled.",
        group=_MOVEMENT,
        unit="s",
        minimum=0.0,
        maximum=1000.0,
    )
    sigma_surface_shift: float = parameter(
        0.012,
        "How far a limb's measured surface is off as a whole; the trunk has its own value.",
        group=_DEPTH,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_surface_turn: float = parameter(
        4.0,
        "How far a limb's measured surface is turned as a whole.",
        group=_DEPTH,
        unit="deg",
        minimum=0.01,
        maximum=90.0,
    )
    surface_time: float = parameter(
        3.0,
        "Time over which such shifts and turns stay alike.",
        group=_DEPTH,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    sigma_trunk_shift: float = parameter(
        0.025,
        "How far the trunk's measured surface is off as a whole.",
        group=_DEPTH,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    trunk_time: float = parameter(
        20.0,
        "Time over which the trunk's shifts and turns stay alike.",
        group=_DEPTH,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    depth_points: int = parameter(
        1000,
        "Measured points of a frame that look for the body.",
        group=_DEPTH,
        minimum=50,
        maximum=20000,
    )
    depth_effective: float = parameter(
        60.0,
        "Independent measurements among them.",
        group=_DEPTH,
        minimum=1.0,
        maximum=20000.0,
    )
    use_outlines: bool = parameter(
        True,
        "Hold the body's outlines to the edges of the person, where the views know them.",
        group=_DEPTH,
    )
    outline_effective: float = parameter(
        52.0,
        "Independent measurements in all outlines of a frame.",
        group=_DEPTH,
        minimum=1.0,
        maximum=20000.0,
    )
    fit_shape: bool = parameter(
        True,
        "Fit the body's surface to clicked frames before depth is used.",
        group=_DEPTH,
    )
