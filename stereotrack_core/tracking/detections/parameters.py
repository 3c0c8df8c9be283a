"""Parameters of detections."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Detections"


@dataclass(frozen=True)
class DetectionParameters(ParameterGroup):
    """Where detections of head and hands come from besides a file, and which are believed."""

    detect: str = parameter(
        "none",
        "Find head and hands in every frame: as the ends of the cloud, or as skin in colour "
        "pictures.",
        group=_GROUP,
        choices=("none", "extremities", "skin"),
        thesis="none",
    )
    detection_gate: float = parameter(
        0.3,
        "A detection that is farther from every place where it could belong is not believed.",
        group=_GROUP,
        unit="m",
        minimum=0.01,
        maximum=5.0,
    )
