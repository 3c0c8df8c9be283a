"""Parameters of measuring outlines."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Outlines"


@dataclass(frozen=True)
class OutlineTrust(ParameterGroup):
    """How the body's outlines in the pictures are weighed."""

    measure_outlines: bool = parameter(
        True,
        "Hold the body's outlines to the edges of the silhouettes.",
        group=_GROUP,
        thesis=False,
    )
    outline_sigma: float = parameter(
        0.02,
        "Distance expected between an outline and its edge.",
        group=_GROUP,
        unit="m",
        minimum=0.001,
        maximum=1.0,
    )
    outline_points: float = parameter(
        120.0,
        "Independent measurements in all outlines of a frame set.",
        group=_GROUP,
        minimum=1.0,
        maximum=20000.0,
    )
    outline_scale: float = parameter(
        0.06,
        "Distance at which an outline loses three quarters of its weight.",
        group=_GROUP,
        unit="m",
        minimum=0.005,
        maximum=2.0,
    )
    outline_reach: float = parameter(
        0.15,
        "Outlines farther than this from every edge are not measured.",
        group=_GROUP,
        unit="m",
        minimum=0.01,
        maximum=2.0,
    )
    outline_depth: float = parameter(
        0.15,
        "An edge whose range differs by more than this from the outline's is another part's.",
        group=_GROUP,
        unit="m",
        minimum=0.02,
        maximum=10.0,
    )
