"""Named settings: ``thesis``, ``accurate``, ``fast``, and the peers they are measured against."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import Value
from stereotrack_core.tracking.settings import Settings

_CHANGES: Mapping[str, Mapping[str, Value]] = MappingProxyType(
    {
        "accurate": MappingProxyType({}),
        "thesis": MappingProxyType(
            {
                "matching": "model_to_data",
                "iterations": 4,
                "sigma_position": 0.1,
                "sigma_rotation": 20.0,
                "sigma_joint": 40.0,
                "sigma_measurement": 0.02,
                "velocity": 0.0,
                "sampling": "random",
                "model_points": 64,
                "clearance": 0.15,
                "arms_apart": 0.0,
                "legs": False,
                "fit_shape": False,
                "search_arms": False,
                "colour_weight": 0.0,
                "torso_forward_low": 0.0,
                "torso_forward_high": 0.0,
                "head_forward": 0.0,
                "low_pass": 0.8,
                "edge_images": False,
                "match_left_right": -1,
                "disparity_from_volume": False,
                "match_region": "whole",
                "background_doubt": False,
                "outlines": False,
                "subpixel": "matcher",
                "halo_trim": "none",
                "measure_outlines": False,
                "background_mode": "average",
                "outlier_repeat": True,
            }
        ),
        "fast": MappingProxyType(
            {
                "data_points": 800,
                "sigma_measurement": 0.02,
                "colour_weight": 0.0,
                "iterations": 3,
                "search_proposals": 120,
                "search_refined": 1,
                "search_iterations": 2,
                "outlines": False,
                "subpixel": "matcher",
                "halo_trim": "none",
                "measure_outlines": False,
                "picture_cost": 0.0,
            }
        ),
        "ekf": MappingProxyType({"estimator": "extended_kalman"}),
        "annealed": MappingProxyType({"estimator": "annealed_particles"}),
        "limb-icp": MappingProxyType({"estimator": "limb_icp"}),
        "scalar": MappingProxyType({"estimator": "scalar_distance"}),
    }
)

PRESETS: tuple[str, ...] = tuple(_CHANGES)

PEERS: tuple[str, ...] = ("ekf", "annealed", "limb-icp", "scalar")
"""Presets that differ from ``accurate`` in the estimator alone."""


def preset(name: str) -> Settings:
    """Settings of a preset.

    Raises
    ------
    InputError
        Where there is no preset of that name.
    """
    if name not in _CHANGES:
        raise InputError(
            f"there is no preset {name!r}",
            where="--preset",
            remedy=f"Known are: {', '.join(PRESETS)}.",
        )
    return Settings().replaced(**_CHANGES[name])
