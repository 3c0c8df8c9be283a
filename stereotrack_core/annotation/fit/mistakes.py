"""How probably each click is a gross mistake: expectation of a mixture, without its own word.

A click is either right, with its sigma, or means something else, with a spread of many pixels.
It is judged by where everything but itself expects the landmark; judged by the fit that it took
part in, a click with a high leverage would always look right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray

_LEAST_WEIGHT = 1e-4


@dataclass(frozen=True, eq=False)
class Judgement:
    """What the rest says about each of M clicks.

    Attributes
    ----------
    mistake : (M,) float64
        Probability of a gross mistake.
    leverage : (M,) float64
        Share (0 to 1) that the click has in where the fit puts its landmark in this picture.
    surprise : (M,) float64
        Squared distance from where the rest expects the landmark, over its variance; a right
        click has 2 on average.
    """

    mistake: FloatArray
    leverage: FloatArray
    surprise: FloatArray

    @property
    def weight(self) -> FloatArray:
        """How far each click is believed (M,)."""
        return np.maximum(1.0 - self.mistake, _LEAST_WEIGHT)


def judged(
    residual: FloatArray,
    spread: FloatArray,
    sigma: FloatArray,
    weight: FloatArray,
    share: float,
    mistake_spread: float,
) -> Judgement:
    """Judge clicks by all but themselves.

    Parameters
    ----------
    residual : (M, 2) float64
        Click minus fitted place, pixels.
    spread : (M, 2, 2) float64
        Covariance J P J' of the fitted places, in which the clicks have had their say.
    sigma : (M,) float64
        Of right clicks, pixels per axis.
    weight : (M,) float64
        With which the clicks took part: their variance was sigma^2 / weight.
    share : float
        Expected share of gross mistakes.
    mistake_spread : float
        Their standard deviation, pixels per axis.
    """
    if not len(residual):
        return Judgement(np.zeros(0), np.zeros(0), np.zeros(0))
    eye = np.eye(2)
    taken = spread * (weight / sigma**2)[:, None, None]
    leverage = np.clip(0.5 * np.trace(taken, axis1=1, axis2=2), 0.0, 1.0)
    kept = _held_below_one(taken)
    without = np.asarray(np.linalg.inv(eye - kept), dtype=np.float64)
    alone = np.einsum("mij,mj->mi", without, residual)
    expected = without @ spread
    right = 0.5 * (expected + np.swapaxes(expected, 1, 2)) + sigma[:, None, None] ** 2 * eye
    wrong = right + mistake_spread**2 * eye
    surprise = np.einsum("mi,mi->m", alone, np.linalg.solve(right, alone[..., None])[..., 0])
    log_right = _log_normal(alone, right) + np.log1p(-share)
    log_wrong = _log_normal(alone, wrong) + np.log(max(share, 1e-12))
    mistake = np.exp(log_wrong - np.logaddexp(log_right, log_wrong))
    return Judgement(mistake, leverage, surprise)


def _held_below_one(taken: FloatArray) -> FloatArray:
    """Keep a click that alone decides just invertible: without it nothing is known."""
    values, vectors = np.linalg.eigh(0.5 * (taken + np.swapaxes(taken, 1, 2)))
    values = np.clip(values, 0.0, 1.0 - 1e-6)
    result: FloatArray = (vectors * values[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return result


def _log_normal(x: FloatArray, P: FloatArray) -> FloatArray:
    squared = np.einsum("mi,mi->m", x, np.linalg.solve(P, x[..., None])[..., 0])
    result: FloatArray = -0.5 * (squared + np.log(np.linalg.det(P)))
    return result
