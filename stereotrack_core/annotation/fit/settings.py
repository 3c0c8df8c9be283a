"""Parameters of the fit of the body to clicked landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from stereotrack_core.parameters import ParameterGroup, parameter

_clicks = partial(parameter, group="Clicks")
_body = partial(parameter, group="Body", unit="m", minimum=0.0001, maximum=0.2)
_movement = partial(parameter, group="Movement")
_depth = partial(parameter, group="Depth")
_shift = partial(_depth, unit="m", minimum=0.0001, maximum=0.2)
_time = partial(parameter, unit="s", minimum=0.01, maximum=1000.0)
_turning = partial(_movement, unit="deg/s", minimum=0.1, maximum=5000.0)
_sample_size = partial(_depth, minimum=1.0, maximum=20000.0)


@dataclass(frozen=True)
class FitSettings(ParameterGroup):
    """How the body is fitted to clicks; standard deviations are per axis."""

    use_depth: bool = _depth(True, "Use the measured points where the recording has depth.")
    mistake_share: float = _clicks(
        0.03, "Expected share of outliers among the clicks.", minimum=0.0, maximum=0.5
    )
    mistake_spread: float = _clicks(
        70.0, "Standard deviation of outliers.", unit="px", minimum=5.0, maximum=1000.0
    )
    sigma_joint_shift: float = _body(
        0.006, "Standard deviation of joint positions from their place on the rigid body model."
    )
    sigma_landmark_shift: float = _body(0.006, "As joint shift, for landmarks that are not joints.")
    sigma_head_shift: float = _body(
        0.02, "As joint shift, for landmarks of the head, which annotators place differently."
    )
    shift_time: float = _time(2.0, "Correlation time of these shifts.", group="Body")
    speed_position: float = _movement(
        0.25, "Typical speed of the body.", unit="m/s", minimum=0.001, maximum=20.0
    )
    speed_rotation: float = _turning(120.0, "Typical rotation of the torso.")
    speed_joint: float = _turning(100.0, "Typical rotation of a joint.")
    speed_time: float = _movement(
        0.3, "Correlation time of velocities.", unit="s", minimum=0.001, maximum=100.0
    )
    speed_tail: float = _movement(
        1.5,
        "Degrees of freedom of the motion model's t-distribution. Small values allow both still "
        "phases and sudden movements.",
        minimum=1.0,
        maximum=1000.0,
    )
    longest_fill: float = _movement(
        2.0,
        "Without depth, frames farther than this from every clicked frame are not interpolated.",
        unit="s",
        minimum=0.0,
        maximum=1000.0,
    )
    sigma_surface_shift: float = _shift(
        0.012,
        "Standard deviation of the common offset of a limb's measured surface (surface bias). The "
        "trunk has its own value.",
    )
    sigma_surface_turn: float = _depth(
        4.0,
        "Standard deviation of the common rotation of a limb's measured surface (surface bias).",
        unit="deg",
        minimum=0.01,
        maximum=90.0,
    )
    surface_time: float = _time(
        3.0, "Correlation time of these offsets and rotations.", group="Depth"
    )
    sigma_trunk_shift: float = _shift(
        0.025,
        "Standard deviation of the common offset of the trunk's measured surface (surface bias).",
    )
    trunk_time: float = _time(
        20.0, "Correlation time of the trunk's offsets and rotations.", group="Depth"
    )
    depth_points: int = _depth(
        1000, "Number of measured points per frame used in the fit.", minimum=50, maximum=20000
    )
    depth_effective: float = _sample_size(60.0, "Effective sample size of these points.")
    use_outlines: bool = _depth(
        True,
        "Fit the contours of the body to the silhouette edges, in views that have a silhouette.",
    )
    outline_effective: float = _sample_size(
        52.0, "Effective sample size of all contours of a frame."
    )
    fit_shape: bool = _depth(
        True, "Fit the body's surface to the clicked frames before depth is used."
    )
