"""Episodes found without truth: by what the tracker itself says."""

from __future__ import annotations

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.by_error import frames_of
from stereotrack_core.evaluation.episodes.chance import Coefficients, lost_chances
from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.joining import joined
from stereotrack_core.evaluation.episodes.rules import EpisodeRules
from stereotrack_core.evaluation.episodes.stretches import high_stretches
from stereotrack_core.tracking.frame import Run


def episodes_by_signs(
    run: Run, fps: float, rules: EpisodeRules | None = None, fitted: Coefficients | None = None
) -> tuple[Episode, ...]:
    """Stretches in which a limb probably fails, by :func:`lost_chances`.

    What is not tracked is an episode of all limbs. `fitted` replaces the coefficients.
    """
    rules = rules or EpisodeRules()
    chance = lost_chances(run, fps) if fitted is None else lost_chances(run, fps, fitted)
    least = max(1, frames_of(rules.episode_least, fps))
    enter = rules.episode_chance
    stretches = {
        limb: high_stretches(
            run.frame, chance[:, i], enter, rules.episode_calm * enter, least,
            frames_of(rules.episode_bridge, fps),
        )
        for i, limb in enumerate(LIMBS)
    }  # fmt: skip
    return joined(stretches, "signs", "chance")
