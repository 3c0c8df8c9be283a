"""Parameters of the fit of the body to clicked landmarks."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_CLICKS, _BODY, _MOVEMENT, _DEPTH = "Clicks", "Body", "Movement", "Depth"


@dataclass(frozen=True)
class FitSettings(ParameterGroup):
    """How the body is fitted to clicks; standard deviations are per axis."""

    use_depth: bool = parameter(True, _DEPTH)(
        "Use the measured points where the recording has depth."
    )
    mistake_share: float = parameter(0.03, _CLICKS, (0.0, 0.5))(
        "Expected share of outliers among the clicks."
    )
    mistake_spread: float = parameter(70.0, _CLICKS, (5.0, 1000.0), unit="px")(
        "Standard deviation of outliers."
    )
    sigma_joint_shift: float = parameter(0.006, _BODY, (0.0001, 0.2), unit="m")(
        "Standard deviation of joint positions from their place on the rigid body model."
    )
    sigma_landmark_shift: float = parameter(0.006, _BODY, (0.0001, 0.2), unit="m")(
        "As joint shift, for landmarks that are not joints."
    )
    sigma_head_shift: float = parameter(0.02, _BODY, (0.0001, 0.2), unit="m")(
        "As joint shift, for landmarks of the head, which annotators place differently."
    )
    shift_time: float = parameter(2.0, _BODY, (0.01, 1000.0), unit="s")(
        "Correlation time of these shifts."
    )
    speed_position: float = parameter(0.25, _MOVEMENT, (0.001, 20.0), unit="m/s")(
        "Typical speed of the body."
    )
    speed_rotation: float = parameter(120.0, _MOVEMENT, (0.1, 5000.0), unit="deg/s")(
        "Typical rotation of the torso."
    )
    speed_joint: float = parameter(100.0, _MOVEMENT, (0.1, 5000.0), unit="deg/s")(
        "Typical rotation of a joint."
    )
    speed_time: float = parameter(0.3, _MOVEMENT, (0.001, 100.0), unit="s")(
        "Correlation time of velocities."
    )
    speed_tail: float = parameter(1.5, _MOVEMENT, (1.0, 1000.0))(
        "Degrees of freedom of the motion model's t-distribution. Small values allow both still "
        "phases and sudden movements."
    )
    longest_fill: float = parameter(2.0, _MOVEMENT, (0.0, 1000.0), unit="s")(
        "Without depth, frames farther than this from every clicked frame are not interpolated."
    )
    sigma_surface_shift: float = parameter(0.012, _DEPTH, (0.0001, 0.2), unit="m")(
        "Standard deviation of the common offset of a limb's measured surface (surface bias). "
        "The trunk has its own value."
    )
    sigma_surface_turn: float = parameter(4.0, _DEPTH, (0.01, 90.0), unit="deg")(
        "Standard deviation of the common rotation of a limb's measured surface (surface bias)."
    )
    surface_time: float = parameter(3.0, _DEPTH, (0.01, 1000.0), unit="s")(
        "Correlation time of these offsets and rotations."
    )
    sigma_trunk_shift: float = parameter(0.025, _DEPTH, (0.0001, 0.2), unit="m")(
        "Standard deviation of the common offset of the trunk's measured surface (surface bias)."
    )
    trunk_time: float = parameter(20.0, _DEPTH, (0.01, 1000.0), unit="s")(
        "Correlation time of the trunk's offsets and rotations."
    )
    depth_points: int = parameter(1000, _DEPTH, (50, 20000))(
        "Number of measured points per frame used in the fit."
    )
    depth_effective: float = parameter(60.0, _DEPTH, (1.0, 20000.0))(
        "Effective sample size of these points."
    )
    use_silhouettes: bool = parameter(True, _DEPTH)(
        "Fit the contours of the body to the silhouette edges, in views that have a silhouette."
    )
    silhouette_effective: float = parameter(52.0, _DEPTH, (1.0, 20000.0))(
        "Effective sample size of all contours of a frame."
    )
    fit_shape: bool = parameter(True, _DEPTH)(
        "Fit the body's surface to the clicked frames before depth is used."
    )
