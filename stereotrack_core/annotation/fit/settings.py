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
        "Expected share of outliers among the clicks.",
        group=_CLICKS,
        minimum=0.0,
        maximum=0.5,
    )
    mistake_spread: float = parameter(
        70.0,
        "Standard deviation of outliers.",
        group=_CLICKS,
        unit="px",
        minimum=5.0,
        maximum=1000.0,
    )
    sigma_joint_shift: float = parameter(
        0.006,
        "Standard deviation of joint positions from their place on the rigid body model.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_landmark_shift: float = parameter(
        0.006,
        "As joint shift, for landmarks that are not joints.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_head_shift: float = parameter(
        0.02,
        "As joint shift, for landmarks of the head, which annotators place differently.",
        group=_BODY,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    shift_time: float = parameter(
        2.0,
        "Correlation time of these shifts.",
        group=_BODY,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    speed_position: float = parameter(
        0.25, "Typical speed of the body.", group=_MOVEMENT, unit="m/s", minimum=0.001, maximum=20.0
    )
    speed_rotation: float = parameter(
        120.0,
        "Typical rotation of the torso.",
        group=_MOVEMENT,
        unit="deg/s",
        minimum=0.1,
        maximum=5000.0,
    )
    speed_joint: float = parameter(
        100.0,
        "Typical rotation of a joint.",
        group=_MOVEMENT,
        unit="deg/s",
        minimum=0.1,
        maximum=5000.0,
    )
    speed_time: float = parameter(
        0.3,
        "Correlation time of velocities.",
        group=_MOVEMENT,
        unit="s",
        minimum=0.001,
        maximum=100.0,
    )
    speed_tail: float = parameter(
        1.5,
        "Degrees of freedom of the motion model's t-distribution. Small values allow both still "
        "phases and sudden movements.",
        group=_MOVEMENT,
        minimum=1.0,
        maximum=1000.0,
    )
    longest_fill: float = parameter(
        2.0,
        "Without depth, frames farther than this from every clicked frame are not interpolated.",
        group=_MOVEMENT,
        unit="s",
        minimum=0.0,
        maximum=1000.0,
    )
    sigma_surface_shift: float = parameter(
        0.012,
        "Standard deviation of the common offset of a limb's measured surface (surface bias). The "
        "trunk has its own value.",
        group=_DEPTH,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    sigma_surface_turn: float = parameter(
        4.0,
        "Standard deviation of the common rotation of a limb's measured surface (surface bias).",
        group=_DEPTH,
        unit="deg",
        minimum=0.01,
        maximum=90.0,
    )
    surface_time: float = parameter(
        3.0,
        "Correlation time of these offsets and rotations.",
        group=_DEPTH,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    sigma_trunk_shift: float = parameter(
        0.025,
        "Standard deviation of the common offset of the trunk's measured surface (surface bias).",
        group=_DEPTH,
        unit="m",
        minimum=0.0001,
        maximum=0.2,
    )
    trunk_time: float = parameter(
        20.0,
        "Correlation time of the trunk's offsets and rotations.",
        group=_DEPTH,
        unit="s",
        minimum=0.01,
        maximum=1000.0,
    )
    depth_points: int = parameter(
        1000,
        "Number of measured points per frame used in the fit.",
        group=_DEPTH,
        minimum=50,
        maximum=20000,
    )
    depth_effective: float = parameter(
        60.0,
        "Effective sample size of these points.",
        group=_DEPTH,
        minimum=1.0,
        maximum=20000.0,
    )
    use_outlines: bool = parameter(
        True,
        "Fit the contours of the body to the silhouette edges, in views that have a silhouette.",
        group=_DEPTH,
    )
    outline_effective: float = parameter(
        52.0,
        "Effective sample size of all contours of a frame.",
        group=_DEPTH,
        minimum=1.0,
        maximum=20000.0,
    )
    fit_shape: bool = parameter(
        True,
        "Fit the body's surface to the clicked frames before depth is used.",
        group=_DEPTH,
    )
