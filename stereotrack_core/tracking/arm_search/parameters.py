"""Parameters of the search for arms."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Arm search"


@dataclass(frozen=True)
class SearchParameters(ParameterGroup):
    """How many arms are proposed, and what speaks against one; costs are in data explained."""

    search_arms: bool = parameter(
        True, "Search for better positions of both arms in every frame.", group=_GROUP, thesis=False
    )
    search_proposals: int = parameter(
        220, "Candidates per arm and frame.", group=_GROUP, minimum=20, maximum=5000
    )
    search_data: int = parameter(
        450,
        "Number of points near the shoulders used to score the arms.",
        group=_GROUP,
        minimum=50,
        maximum=5000,
    )
    search_kept: int = parameter(
        8,
        "Best candidates per arm of which all pairs are scored.",
        group=_GROUP,
        minimum=1,
        maximum=50,
    )
    search_refined: int = parameter(
        3, "Best pairs that are refined by the filter.", group=_GROUP, minimum=1, maximum=20
    )
    search_iterations: int = parameter(
        3, "Corrections used to refine a pair.", group=_GROUP, minimum=1, maximum=20
    )
    search_gain: float = parameter(
        3.0,
        "A pair replaces the tracked arms only if its cost is lower by more than this.",
        group=_GROUP,
        minimum=0.0,
        maximum=1000.0,
    )
    see_through_px: float = parameter(
        1.3,
        "A view sees through an arm if its disparity is smaller by more than this.",
        group=_GROUP,
        unit="px",
        minimum=0.1,
        maximum=20.0,
    )
    support_px: float = parameter(
        0.9,
        "A view supports an arm if its disparity differs by less than this.",
        group=_GROUP,
        unit="px",
        minimum=0.1,
        maximum=20.0,
    )
    see_through_cost: float = parameter(
        2.5,
        "Cost of a position that a view sees through; at most two views count.",
        group=_GROUP,
        minimum=0.0,
        maximum=100.0,
    )
    unsupported_cost: float = parameter(
        1.5,
        "Cost of a position that no view supports or occludes.",
        group=_GROUP,
        minimum=0.0,
        maximum=100.0,
    )
    filled_cost: float = parameter(
        0.25,
        "Cost of a position inside a silhouette where no view has a range.",
        group=_GROUP,
        minimum=0.0,
        maximum=100.0,
    )
    only_hidden_cost: float = parameter(
        0.75,
        "Cost of a position that is only occluded in all views.",
        group=_GROUP,
        minimum=0.0,
        maximum=100.0,
    )
    picture_cost: float = parameter(
        1000.0,
        "Render-and-compare cost per square metre in which a view does not show the rendered pose.",
        group=_GROUP,
        unit="1/m^2",
        minimum=0.0,
        maximum=100000.0,
    )
    picture_sigma: float = parameter(
        0.5,
        "Difference between rendered and measured disparity at which the cost is one half.",
        group=_GROUP,
        unit="px",
        minimum=0.05,
        maximum=20.0,
    )
    picture_unknown: float = parameter(
        0.1,
        "Share of the render-and-compare cost where the person is and no range is known.",
        group=_GROUP,
        minimum=0.0,
        maximum=1.0,
    )
    picture_step: int = parameter(
        3, "Compare every n-th pixel.", group=_GROUP, unit="px", minimum=1, maximum=20
    )
