"""Episodes found with truth: a limb's error is large for some time."""

from __future__ import annotations

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.joining import joined
from stereotrack_core.evaluation.episodes.rules import EpisodeRules
from stereotrack_core.evaluation.episodes.stretches import high_stretches
from stereotrack_core.evaluation.errors import LimbErrors


def frames_of(seconds: float, fps: float) -> int:
    """Number of frames in some seconds, to the nearest one."""
    return round(seconds * fps)


def episodes_by_error(
    errors: LimbErrors, fps: float, rules: EpisodeRules | None = None
) -> tuple[Episode, ...]:
    """Stretches in which the error of a limb's direction exceeds the threshold long enough.

    Frames that are not tracked count with the 90 degrees that they have in `errors`; the head
    has no errors.
    """
    rules = rules or EpisodeRules()
    least = max(1, frames_of(rules.episode_least, fps))
    bridge = frames_of(rules.episode_bridge, fps)
    enter = rules.episode_error
    stretches = {
        limb: high_stretches(
            errors.frame, np.degrees(errors.of_limb(limb)), enter,
            rules.episode_release * enter, least, bridge,
        )
        for limb in LIMBS
    }  # fmt: skip
    return joined(stretches, "truth", "error")
