"""What a run itself says about each limb in each frame; needs no truth and no pictures."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter, uniform_filter1d

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.episodes.closeness import to_other_arm, to_torso, turns
from stereotrack_core.tracking.lost.signs import NEIGHBOUR
from stereotrack_core.tracking.run import Run

EPISODE_SIGNS: tuple[str, ...] = (
    "lost",
    "lost around",
    "lost most around",
    "lost of the neighbour",
    "lost of the other arm",
    "sigma",
    "sigma around",
    "unexplained",
    "unexplained more than usual",
    "innovation",
    "residual",
    "near the other arm",
    "near the torso",
    "turn",
    "turn most around",
    "jerk most around",
)
"""What is known of a limb, in the order of the coefficients; see :func:`episode_signs`."""

_AROUND = 0.35
"""Seconds before and after a frame that count as around it."""

_USUAL = 4.0
"""Seconds before and after a frame over which the usual is taken."""

_NEAR = 0.25
"""Metres from which a limb counts as near."""

OTHER_ARM = (0, 0, 3, 2, 5, 4)


def episode_signs(run: Run, fps: float) -> FloatArray:
    """Signs (F, 6, len(EPISODE_SIGNS)) of the limbs in each frame of a run.

    The logit of the probability that the limb is lost: in the frame, its mean and its largest
    value around it, and those of the neighbouring limb and of the same limb of the other arm; the
    logarithm of the limb's standard deviation, in the frame and around it; the share of the cloud
    that the model leaves unexplained, alone and over the usual; logarithms of innovation and
    residual over the usual ones; by how much the limb is nearer than 25 centimetres to the other
    arm and to the torso, in decimetres; logarithms of the angle that it turned since the frame
    before, alone and the largest around, and of the largest change of direction of such turns.
    NaN where the run does not say: in frames that are not tracked, and for torso and head.
    """
    around = 2 * max(1, round(_AROUND * fps)) + 1
    usual = 2 * max(1, round(_USUAL * fps)) + 1
    lost = _logit(run.limb_lost)
    sigma = np.log(np.clip(np.nan_to_num(run.limb_sigma_deg, nan=20.0), 0.3, 90.0))
    turn = np.nan_to_num(turns(run.frame.astype(np.float64), run.landmarks))
    jerk = np.abs(np.diff(turn, axis=0, prepend=turn[:1]))
    cover = np.minimum(np.nan_to_num(run.coverage, nan=1.0), 1.0)
    columns = (
        lost,
        uniform_filter1d(lost, around, axis=0, mode="nearest"),
        maximum_filter1d(lost, around, axis=0, mode="nearest"),
        lost[:, list(NEIGHBOUR)],
        lost[:, list(OTHER_ARM)],
        sigma,
        uniform_filter1d(sigma, around, axis=0, mode="nearest"),
        _each(cover),
        _each(cover - median_filter(cover, usual, mode="nearest")),
        _each(_over_usual(run.innovation, usual)),
        _each(_over_usual(run.residual, usual)),
        10.0 * np.clip(_NEAR - np.nan_to_num(to_other_arm(run.landmarks), nan=1.0), 0.0, None),
        10.0 * np.clip(_NEAR - np.nan_to_num(to_torso(run.landmarks), nan=1.0), 0.0, None),
        np.log1p(turn),
        np.log1p(maximum_filter1d(turn, around, axis=0, mode="nearest")),
        np.log1p(maximum_filter1d(jerk, around, axis=0, mode="nearest")),
    )
    signs = np.stack(columns, axis=-1)
    signs[~run.tracked] = np.nan
    signs[:, [i for i in range(len(LIMBS)) if i not in (*UPPER_ARMS, *FOREARMS)]] = np.nan
    return signs


def _logit(chance: FloatArray) -> FloatArray:
    """Logits (F, 6), at most 7; 0 where no chance is known in all of the run."""
    held = np.clip(np.nan_to_num(chance, nan=0.5), 1e-3, 1.0 - 1e-3)
    result: FloatArray = np.log(held / (1.0 - held))
    return result


def _over_usual(values: FloatArray, usual: int) -> FloatArray:
    known = np.isfinite(values) & (values > 0)
    filled = np.where(known, values, np.median(values[known]) if known.any() else 1.0)
    result: FloatArray = np.log(filled / median_filter(filled, usual, mode="nearest"))
    return np.clip(result, -3.0, 3.0)


def _each(values: FloatArray) -> FloatArray:
    return np.repeat(values[:, None], len(LIMBS), axis=1)
