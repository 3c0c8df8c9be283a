"""Background model on disparities and the foreground in front of it (3.1.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array


@dataclass(frozen=True, eq=False)
class BackgroundModel:
    """What a pixel shows when nobody is there.

    Attributes
    ----------
    disparity : (H, W) float32, pixels
        d_M; finite everywhere, without meaning where `frequency` is low.
    frequency : (H, W) float32
        g_M: how often the disparity was valid, 0 to 1.
    """

    disparity: Float32Array
    frequency: Float32Array

    def limit(self, threshold: float, valid_above: float) -> Float32Array:
        """Disparity (H, W) above which a pixel is foreground.

        Equation (3.3): a valid d is foreground where the model is invalid (limit -inf) or
        where d > d_M + s.
        """
        known = self.frequency > valid_above
        limit: Float32Array = np.where(known, self.disparity + np.float32(threshold), -np.inf)
        return limit.astype(np.float32, copy=False)


def foreground(disparity: Float32Array, limit: Float32Array) -> BoolArray:
    """Equation (3.3): true where the disparity is valid (not NaN) and above the limit."""
    result: BoolArray = disparity > limit
    return result


def empty_scene_model(disparity: Float32Array) -> BackgroundModel:
    """Model from one image of the empty scene, NaN where it has no disparity."""
    valid = np.isfinite(disparity)
    return BackgroundModel(np.where(valid, disparity, np.float32(0)), valid.astype(np.float32))


def averaged(
    model: BackgroundModel | None, disparity: Float32Array, rate: float, validity_rate: float
) -> BackgroundModel:
    """One step of the exponential averages of 3.1.1.

    d_M = (1 - alpha_d) d_M + alpha_d d where d is valid, unchanged elsewhere;
    g_M = (1 - alpha_g) g_M + alpha_g g with g = 1 where d is valid, else 0. The first
    disparity that a pixel shows is taken as it is.

    Parameters
    ----------
    model : BackgroundModel or None
        None before the first image.
    disparity : (H, W) float32, pixels, NaN where invalid
    rate, validity_rate : float
        alpha_d, alpha_g.
    """
    if model is None:
        return empty_scene_model(disparity)
    valid = np.isfinite(disparity)
    never_seen = model.frequency == 0
    step = np.where(never_seen, np.float32(1), np.float32(rate))
    change = np.where(valid, step * (disparity - model.disparity), np.float32(0))
    frequency = model.frequency + np.float32(validity_rate) * (valid - model.frequency)
    return BackgroundModel(model.disparity + change, frequency.astype(np.float32))


def percentile_model(disparities: Sequence[Float32Array], percentile: float) -> BackgroundModel:
    """A low percentile of each pixel's disparities: the background is behind whoever passes.

    Parameters
    ----------
    disparities : sequence of (H, W) float32, pixels, NaN where invalid
    percentile : float
        0 to 100, among the valid disparities of a pixel; the nearest rank below.
    """
    stack = np.stack(disparities, axis=-1)  # sorting is much quicker along the last axis
    stack.sort(axis=-1)  # NaN comes last
    count = np.isfinite(stack).sum(axis=-1)
    rank = np.floor((percentile / 100.0) * np.maximum(count - 1, 0)).astype(np.int64)
    chosen = np.take_along_axis(stack, rank[..., None], axis=-1)[..., 0]
    frequency = (count / len(disparities)).astype(np.float32)
    return BackgroundModel(np.where(count > 0, chosen, np.float32(0)), frequency)
