"""Parameters of silhouettes, detections and colours."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_OUTLINES = "Silhouettes"


@dataclass(frozen=True)
class SilhouetteParameters(ParameterGroup):
    """How the body's outlines in the pictures are weighed."""

    measure_outlines: bool = parameter(
        True,
        "Fit the contours of the body to the silhouette edges.",
        group=_OUTLINES,
        thesis=False,
    )
    outline_sigma: float = parameter(
        0.02,
        "Expected distance between a contour and its edge.",
        group=_OUTLINES,
        unit="m",
        minimum=0.001,
        maximum=1.0,
    )
    outline_points: float = parameter(
        120.0,
        "Effective sample size of all contours of a frame set.",
        group=_OUTLINES,
        minimum=1.0,
        maximum=20000.0,
    )
    outline_scale: float = parameter(
        0.06,
        "Distance at which a contour loses three quarters of its weight.",
        group=_OUTLINES,
        unit="m",
        minimum=0.005,
        maximum=2.0,
    )
    outline_reach: float = parameter(
        0.15,
        "Contours farther than this from every edge are not used.",
        group=_OUTLINES,
        unit="m",
        minimum=0.01,
        maximum=2.0,
    )
    outline_depth: float = parameter(
        0.15,
        "An edge whose range differs by more than this from the contour belongs to another part.",
        group=_OUTLINES,
        unit="m",
        minimum=0.02,
        maximum=10.0,
    )


_DETECTIONS = "Keypoints"


@dataclass(frozen=True)
class DetectionParameters(ParameterGroup):
    """Where detections of head and hands come from besides a file, and which are believed."""

    detect: str = parameter(
        "none",
        "Detect head and hands in every frame: as the ends of the cloud, or as skin in colour "
        "images.",
        group=_DETECTIONS,
        choices=("none", "extremities", "skin"),
        thesis="none",
    )
    detection_gate: float = parameter(
        0.3,
        "A keypoint farther than this from every plausible position is rejected.",
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
        "Distance added between a point and a part for each standard deviation by which its "
        "colour differs from the part's colours; 0 disables colours. No effect on grey images.",
        group=_COLOURS,
        unit="m",
        minimum=0.0,
        maximum=1.0,
        thesis=0.0,
    )
    colour_memory: float = parameter(
        0.98,
        "Share of a part's learned colours that is kept from frame to frame.",
        group=_COLOURS,
        minimum=0.0,
        maximum=1.0,
    )
