"""What counts as an episode."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Episodes"


@dataclass(frozen=True)
class EpisodeRules(ParameterGroup):
    """From which error, for how long, and what is taken together."""

    episode_error: float = parameter(
        45.0, "Error of a limb's direction with which an episode begins.", group=_GROUP, unit="deg",
        minimum=1.0, maximum=180.0,
    )  # fmt: skip
    episode_release: float = parameter(
        0.75, "Share of that error below which it ends.", group=_GROUP, minimum=0.1, maximum=1.0
    )
    episode_chance: float = parameter(
        0.55, "Probability of a failing limb with which an episode without truth begins.",
        group=_GROUP, minimum=0.01, maximum=0.99,
    )  # fmt: skip
    episode_calm: float = parameter(
        0.5, "Share of that probability below which it ends.",
        group=_GROUP, minimum=0.1, maximum=1.0,
    )  # fmt: skip
    episode_least: float = parameter(
        0.3, "What is shorter is no episode.", group=_GROUP, unit="s", minimum=0.0, maximum=60.0
    )
    episode_bridge: float = parameter(
        0.5, "Shorter gaps within an episode are bridged.", group=_GROUP, unit="s",
        minimum=0.0, maximum=60.0,
    )  # fmt: skip
