"""Which pictures, and which corners in them, do not fit the others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.sightings import Sightings

_LEAST_FACTOR, _SPREADS = 2.5, 5.0
_LEAST_OFF_PX = 0.3  # pictures that lie off by less are as good as any
_FAR_CORNER = 6.0  # standard deviations from which a single corner is an outlier
_LEAST_CORNER_PX = 0.5
_NORMAL = 1.4826  # standard deviations of a normal distribution in a median deviation


def outlying_views(errors: FloatArray, most: int) -> tuple[list[int], list[str]]:
    """Rows of pictures far worse than the usual one, the worst first, and why each is left out.

    Parameters
    ----------
    errors : (F, n, 2); pixels
    most
        How many at most.
    """
    rms = np.array([rms_of(one) for one in errors])
    if len(rms) < 3:
        return [], []
    level = np.log(np.maximum(rms, 1e-9))
    usual = float(np.nanmedian(level))
    spread = _NORMAL * float(np.nanmedian(np.abs(level - usual)))
    limit = max(np.exp(usual + max(_SPREADS * spread, np.log(_LEAST_FACTOR))), _LEAST_OFF_PX)
    rows = [int(i) for i in np.argsort(-rms) if rms[i] > limit][: max(most, 0)]
    return rows, [_reason(errors[i], rms[i], float(np.exp(usual))) for i in rows]


def _reason(error: FloatArray, rms: float, usual: float) -> str:
    seen = error[np.isfinite(error[:, 0])]
    length = np.linalg.norm(seen, axis=1)
    few = float(np.median(length)) < 0.3 * rms
    cause = "some corners are in wrong places" if few else "blurred, bent or wrongly detected"
    return f"its corners lie {rms:.2f} px off, usual are {usual:.2f} px: {cause}"


def without_far_corners(sightings: Sightings, errors: FloatArray) -> Sightings:
    """The same with single corners that lie far off made unseen."""
    length = np.linalg.norm(errors, axis=-1)
    scale = float(np.nanmedian(length)) / 1.1774  # median of Rayleigh's distribution
    far = length > max(_FAR_CORNER * scale, _LEAST_CORNER_PX)
    usual = far.mean(axis=1) < 0.2  # where more are off the whole picture is judged
    far &= usual[:, None]
    if not far.any():
        return sightings
    pixels = sightings.pixels.copy()
    pixels[far] = np.nan
    return replace(sightings, pixels=pixels)
