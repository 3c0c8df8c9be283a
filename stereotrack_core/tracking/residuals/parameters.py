"""Parameters of silhouettes, detections and colours."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_OUTLINES = "Outlines"


@dataclass(frozen=True)
class SilhouetteParameters(ParameterGroup):
    """How the body's outlines in the pictures are weighed."""

    measure_outlines: bool = parameter(
        True,
        "Hold the body's outlines to the edges of the silhouettes.",
        group=_OUTLINES,
        thesis=False,
    )
    outline_sigma: float = parameter(
        0.02,
        "Distance expected between an outline and its edge.",
        group=_OUTLINES,
        unit="m",
        minimum=0.001,
        maximum=1.0,
    )
    outline_points: float = parameter(
        120.0,
        "Independent measurements in all outlines of a frame set.",
        group=_OUTLINES,
        minimum=1.0,
        maximum=20000.0,
    )
    outline_scale: float = parameter(
        0.06,
        "Distance at which an outline loses three quarters of its weight.",
        group=_OUTLINES,
        unit="m",
        minimum=0.005,
        maximum=2.0,
    )
    outline_reach: float = parameter(
        0.15,
        "Outlines farther than this from every edge are not measured.",
        group=_OUTLINES,
        unit="m",
        minimum=0.01,
        maximum=2.0,
    )
    outline_depth: float = parameter(
        0.15,
        "An edge whose range differs by more than this from the outline's is another part's.",
        group=_OUTLINES,
        unit="m",
        minimum=0.02,
        maximum=10.0,
    )


_DETECTIONS = "Detections"


@dataclass(frozen=True)
class DetectionParameters(ParameterGroup):
    """Where detections of head and hands come from besides a file, and which are believed."""

    detect: str = parameter(
        "none",
        "Find head and hands in every frame: as the ends of the cloud, or as skin in colour "
        "pictures.",
        group=_DETECTIONS,
        choices=("none", "extremities", "skin"),
        thesis="none",
    )
    detection_gate: float = parameter(
        0.3,
        "A detection that is farther from every place where it could belong is not believed.",
        group=_DETECTIONS,
        unit="m",
        minimum=0.01,
        maximum=5.0,
    )


_COLOURS = "Colours"


@dataclass(frozen=True)
class ColourParameters(ParameterGroup):
    """How much colours say about which part a datum belongs to."""

    colour_weight: float = parameter(
        0.06,
        "Distance that a datum counts as farther from a part for each standard deviation by which "
        "its colour differs from the part's; 0 leaves colours out. Says nothing where the "
        "pictures are grey.",
        group=_COLOURS,
        unit="m",
        minimum=0.0,
        maximum=1.0,
        thesis=0.0,
    )
    colour_memory: float = parameter(
        0.98,
        "Share of what is known of a part's colours that is kept from frame to frame.",
        group=_COLOURS,
        minimum=0.0,
        maximum=1.0,
    )
