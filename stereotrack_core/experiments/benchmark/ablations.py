"""What is taken away from ``accurate``, one part at a time. A new part is one more row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stereotrack_core.parameters import Value


@dataclass(frozen=True)
class Ablation:
    """One part of ``accurate`` that is left out, or exchanged for the plain way.

    Attributes
    ----------
    name : str
        As the table calls it.
    changes : mapping from parameter to value
        What differs from ``accurate``.
    """

    name: str
    changes: Mapping[str, Value] = field(default_factory=dict)


ABLATIONS: tuple[Ablation, ...] = (
    Ablation("no arm search", {"search_arms": False}),
    Ablation("no silhouettes", {"measure_outlines": False}),
    Ablation("no render-and-compare", {"picture_cost": 0.0}),
    Ablation("no free space", {"sight_cost": 0.0}),
    Ablation("a third of the proposals", {"search_proposals": 73}),
    Ablation("no fitted shape", {"fit_shape": False}),
    Ablation("no legs", {"legs": False}),
    Ablation("average proportions", {"proportions": "average"}),
    Ablation("no colours", {"colour_weight": 0.0}),
    Ablation("wide loss scale throughout", {"loss_scale": 0.12}),
    Ablation("no robust loss", {"first_loss_scale": 2.0, "loss_scale": 2.0}),
    Ablation("no prior inflation", {"prior_inflation_above": 100.0}),
    Ablation("the thesis's process noise", {"sigma_rotation": 20.0, "sigma_joint": 40.0}),
    Ablation("three iterations", {"iterations": 3}),
    Ablation("300 data", {"data_points": 300}),
    Ablation("no collisions", {"clearance": 0.0}),
    Ablation("full-image matching", {"match_region": "whole"}),
    Ablation("no left-right check", {"match_left_right": -1}),
    Ablation("background without silhouette evidence", {"background_doubt": False}),
)
"""Each row against ``accurate`` says what its part brings."""
