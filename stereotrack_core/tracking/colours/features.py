"""Colours as three numbers that light changes little."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray

_OFFSET = 10.0
"""Levels added to every channel, so that noise in the dark counts little."""

FLOOR = np.array([0.20, 0.06, 0.06])
"""Standard deviations that shading and noise give to brightness and to both colour ratios of a
single stuff."""


def colour_features(colours: FloatArray) -> FloatArray:
    """Logarithms (N, 3) of brightness, of red to green, and of blue to green.

    Parameters
    ----------
    colours : (N, 3) float64
        BGR from 0 to 255; NaN stays NaN.
    """
    blue, green, red = np.log(np.maximum(colours, 0.0) + _OFFSET).T
    return np.stack([(blue + green + red) / 3.0, red - green, blue - green], axis=1)
