"""Parameters of colours in the correspondences."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Colours"


@dataclass(frozen=True)
class ColourParameters(ParameterGroup):
    """How much colours say about which part a datum belongs to."""

    colour_weight: float = parameter(
        0.06,
        "Distance that a datum counts as farther from a part for each standard deviation by which "
        "its colour differs from the part's; 0 leaves colours out. Says nothing where the "
        "pictures are grey.",
        group=_GROUP,
        unit="m",
        minimum=0.0,
        maximum=1.0,
        thesis=0.0,
    )
    colour_memory: float = parameter(
        0.98,
        "Share of what is known of a part's colours that is kept from frame to frame.",
        group=_GROUP,
        minimum=0.0,
        maximum=1.0,
    )
