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

MEDIAN_SURPRISE = 2.0 * np.log(2.0)
"""Median of the squared distance of a right click, over its variance: chi squared of two."""

_UPPER_QUARTILE = 2.0 * np.log(4.0)
"""The same for the upper quartile."""

_TOLD_BY_OTHERS = 0.9
"""Leverage below which others say something of a click."""

_ENOUGH = 6
"""Clicks whose scatter can be told."""


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


def mixture_cost(
    residual: FloatArray, sigma: FloatArray, share: float, mistake_spread: float
) -> FloatArray:
    """What residuals (M, 2) in pixels cost (M,): -2 log of how probable they are, 0 for none.

    Clicks here are what :func:`judged` says of them, right ones or gross mistakes.
    """
    right, wrong = _mixture(residual, sigma, share, mistake_spread)
    result: FloatArray = -2.0 * np.logaddexp(right, wrong)
    return result


def mixture_weight(
    residual: FloatArray, sigma: FloatArray, share: float, mistake_spread: float
) -> FloatArray:
    """Weights (M,) on 1 / sigma^2 under which a least-squares step lowers the mixture's cost.

    A wrong click still pulls, as weakly as its spread is wide, so that none is lost for ever.
    """
    right, wrong = _mixture(residual, sigma, share, mistake_spread)
    mistake = np.exp(wrong - np.logaddexp(right, wrong))
    result: FloatArray = 1.0 - mistake + mistake * sigma**2 / (sigma**2 + mistake_spread**2)
    return result


def _mixture(
    residual: FloatArray, sigma: FloatArray, share: float, mistake_spread: float
) -> tuple[FloatArray, FloatArray]:
    """Logarithms (M,) of how probable residuals are of right and of wrong clicks."""
    squared = (residual**2).sum(axis=1)
    wide = sigma**2 + mistake_spread**2
    right = np.log1p(-share) - 0.5 * squared / sigma**2
    wrong = np.log(max(share, 1e-12)) - 0.5 * squared / wide + np.log(sigma**2 / wide)
    return right, wrong


def scatter(judgement: Judgement) -> float:
    """By which factor clicks scatter more than they were taken to; 1 where too few can tell.

    From the upper quartile of what the others say of each click, over those that the others say
    something of, so that gross mistakes do not count.
    """
    told = judgement.surprise[judgement.leverage < _TOLD_BY_OTHERS]
    if len(told) < _ENOUGH:
        return 1.0
    return float(np.sqrt(np.percentile(told, 75.0) / _UPPER_QUARTILE))


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
