"""What a run itself says about each limb in each frame; needs no truth and no pictures."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import maximum_filter1d, median_filter, uniform_filter1d

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.episodes.closeness import turns
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
