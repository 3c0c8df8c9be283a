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
