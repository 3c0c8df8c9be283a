"""When the reference is as good as wanted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.annotation.limb_axes import SCORED
from stereotrack_core.annotation.suggestion import StopSign
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS


def good_enough(
    limb_sigma_deg: FloatArray,
    wanted_deg: float,
    *,
    limbs: Sequence[str] = SCORED,
    allowed: float = 0.05,
) -> StopSign:
    """Count what misses the wanted accuracy.

    Parameters
    ----------
    limb_sigma_deg : (F, 6) float64
        Root mean square angle by which each limb may be off, in the order of ``LIMBS``; NaN where
        nothing is known, which misses every accuracy. Leave out flagged gaps.
    wanted_deg : float
    limbs : sequence of str
        Those that count.
    allowed : float
        Share of the frames that may miss it.

    Raises
    ------
    ValueError
        Where the wanted accuracy is not positive or the share is none.
    """
    if not wanted_deg > 0 or not 0 <= allowed < 1:
        raise ValueError(f"{wanted_deg} deg in all but a share of {allowed} is not a valid target")
    sigma = limb_sigma_deg[:, [LIMBS.index(limb) for limb in limbs]]
    missing = ~(sigma <= wanted_deg)
    known = np.isfinite(sigma)
    counts = np.maximum(known.sum(axis=0), 1)
    rms = np.sqrt(np.square(np.where(known, sigma, 0.0)).sum(axis=0) / counts)
    rms = np.where(known.any(axis=0), rms, np.nan)
    return StopSign(
        wanted_deg=wanted_deg,
        frames=len(sigma),
        frames_missing=int(missing.any(axis=1).sum()),
        missing_by_limb={limb: int(missing[:, i].sum()) for i, limb in enumerate(limbs)},
        unknown=int((~known.any(axis=1)).sum()),
        rms_deg={limb: float(rms[i]) for i, limb in enumerate(limbs)},
        allowed=allowed,
    )
