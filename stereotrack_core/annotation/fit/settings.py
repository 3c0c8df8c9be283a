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
    outlier_share: float = parameter(0.03, _CLICKS, (0.0, 0.5))(
        "Expected share of outliers among the clicks."
    )
    sigma_joint_shift: float = parameter(0.006, _BODY, (0.0001, 0.2), unit="m")(
        "Standard deviation of joint positions from their place on the rigid body model."
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
    longest_fill: float = parameter(2.0, _MOVEMENT, (0.0, 1000.0), unit="s")(
        "Without depth, frames farther than this from every clicked frame are not interpolated."
    )
    sigma_surface_shift: float = parameter(0.012, _DEPTH, (0.0001, 0.2), unit="m")(
        "Standard deviation of the common offset of a limb's measured surface (surface bias). "
        "The trunk has its own value."
    )
    use_silhouettes: bool = parameter(True, _DEPTH)(
        "Fit the contours of the body to the silhouette edges, in views that have a silhouette."
    )
    fit_shape: bool = parameter(True, _DEPTH)(
        "Fit the body's surface to the clicked frames before depth is used."
    )
