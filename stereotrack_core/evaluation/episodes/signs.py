"""Episodes found without truth: what a run says about each limb, and how likely it fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import maximum_filter1d, median_filter, uniform_filter1d
from scipy.special import expit

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.evaluation.episodes import coefficients
from stereotrack_core.evaluation.episodes.closeness import turns
from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.stretches import (
    EpisodeRules,
    frames_of,
    high_stretches,
    joined,
)
from stereotrack_core.tracking.failure.features import NEIGHBOUR
from stereotrack_core.tracking.frame import Run

_TURNS = ("turned before", "turns after")

SAID_SIGNS: tuple[str, ...] = (
    *_TURNS, "lost around", "lost most around", "lost of the neighbour",
)  # fmt: skip
"""What is known of a limb where the run says how likely it is lost, which sums up all else."""

UNSAID_SIGNS: tuple[str, ...] = (
    *_TURNS, "sigma", "sigma around", "unexplained", "residual more than usual",
)  # fmt: skip
"""What is known of it where the run does not; both in the order of the coefficients."""

_AROUND, _USUAL = 0.35, 4.0
"""Seconds before and after a frame that count as around it, and as usual."""

_ENDS = 1.0
"""Seconds before and after a frame within which a limb that goes astray turns abruptly."""


def episode_signs(run: Run, fps: float, *, said: bool) -> FloatArray:
    """Signs (F, 6, S) of the limbs in each frame of a run, of those that say it or do not.

    All say the more for a failing limb the larger they are. Logarithms of the largest angle that
    the limb turned from one frame to the next within a second before and after: a limb that goes
    astray, or comes back, turns abruptly. Of the logit of the probability that the limb is lost:
    mean and largest value around the frame, and the mean of the neighbouring limb. Or else the
    logarithm of its standard deviation, in the frame and around it; the share of the cloud that
    the model leaves unexplained; the logarithm of the residual over the usual one. NaN in frames
    that are not tracked, and for torso and head.
    """
    around, usual = (2 * max(1, round(s * fps)) + 1 for s in (_AROUND, _USUAL))
    ends = max(1, round(_ENDS * fps))
    turn = np.log1p(np.nan_to_num(turns(run.frame.astype(np.float64), run.landmarks)))
    columns = [_largest_before(turn, ends), _largest_before(turn[::-1], ends)[::-1]]
    if said:
        lost = _logit(run.limb_lost)
        mean = uniform_filter1d(lost, around, axis=0, mode="nearest")
        largest = maximum_filter1d(lost, around, axis=0, mode="nearest")
        columns += [mean, largest, mean[:, list(NEIGHBOUR)]]
    else:
        sigma = np.log(np.clip(np.nan_to_num(run.limb_sigma_deg, nan=20.0), 0.3, 90.0))
        cover = np.minimum(np.nan_to_num(run.unexplained_fraction, nan=1.0), 1.0)
        columns += [sigma, uniform_filter1d(sigma, around, axis=0, mode="nearest")]
        columns += [_each(cover), _each(_over_usual(run.residual, usual))]
    signs = np.stack(columns, axis=-1)
    signs[~run.tracked] = np.nan
    signs[:, [i for i in range(len(LIMBS)) if i not in (*UPPER_ARMS, *FOREARMS)]] = np.nan
    return signs


def _logit(chance: FloatArray) -> FloatArray:
    """Logits (F, 6), at most 7; 0 where no chance is known in all of the run."""
    held = np.clip(np.nan_to_num(chance, nan=0.5), 1e-3, 1.0 - 1e-3)
    result: FloatArray = np.log(held / (1.0 - held))
    return result


def _largest_before(values: FloatArray, frames: int) -> FloatArray:
    """Largest of each value (F, 6) and of the `frames` before it; none is below 0."""
    padded = np.pad(values, ((frames, 0), (0, 0)))
    result: FloatArray = sliding_window_view(padded, frames + 1, axis=0).max(axis=-1)
    return result


def _over_usual(values: FloatArray, usual: int) -> FloatArray:
    known = np.isfinite(values) & (values > 0)
    filled = np.where(known, values, np.median(values[known]) if known.any() else 1.0)
    result: FloatArray = np.log(filled / median_filter(filled, usual, mode="nearest"))
    return np.clip(result, -3.0, 3.0)


def _each(values: FloatArray) -> FloatArray:
    return np.repeat(values[:, None], len(LIMBS), axis=1)


ARM_HALVES: MappingProxyType[str, tuple[int, ...]] = MappingProxyType(
    {"UPPER_ARM": UPPER_ARMS, "FOREARM": FOREARMS}
)
"""Limbs that are judged alike, by the name of their coefficients."""

UNSAID = "_WITHOUT_LOST"
"""Ending of that name for runs that do not say how likely limbs are lost."""

Coefficients: TypeAlias = Mapping[str, Sequence[float]]
"""A constant and a slope per sign, by their name."""

_FITTED: Coefficients = MappingProxyType(
    {name: getattr(coefficients, name) for half in ARM_HALVES for name in (half, f"{half}{UNSAID}")}
)


def lost_chances(run: Run, fps: float, fitted: Coefficients = _FITTED) -> FloatArray:
    """Probability (F, 6) that each limb is in an episode by its error, by a run's own signs.

    A logistic regression over :func:`episode_signs`, one for the upper arms and one for the
    forearms, fitted on simulated recordings alone by ``tools/fit_episodes.py``. It differs from
    ``Run.limb_lost``, which knows single frames only, by looking at what is before and after, and
    by what it is the probability of: not of a limb that is off in this frame, but of one that is
    in a stretch in which it is. A run that does not say how likely limbs are lost is judged by
    the other signs alone. In frames that are not tracked all limbs fail; NaN for torso and head
    elsewhere, which failed too rarely to learn from.

    Parameters
    ----------
    run : Run
    fps : float
    fitted : mapping of str to sequence of float
    """
    said = bool(np.isfinite(run.limb_lost[run.tracked]).any())
    signs = episode_signs(run, fps, said=said)
    result: FloatArray = np.full((len(run.frame), len(LIMBS)), np.nan)
    for half, limbs in ARM_HALVES.items():
        constant, *slopes = fitted[half if said else f"{half}{UNSAID}"]
        result[:, list(limbs)] = expit(constant + signs[:, list(limbs)] @ np.array(slopes))
    for limb in (TORSO, *UPPER_ARMS, *FOREARMS):
        result[~run.tracked, limb] = 1.0
    return result


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
