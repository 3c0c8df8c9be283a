"""The correction in O(m n^2) against its dense form and against filterpy."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.experiments.benchmark.speed import exponent, median_seconds
from stereotrack_core.filtering.correction import Correction, correct
from stereotrack_core.filtering.sigma_points import SigmaWeights, scaled_weights, sigma_deviations

MEASUREMENTS = (64, 256, 1024, 4096)
STATES = 14
_ALPHA, _BETA, _KAPPA = 0.1, 2.0, 0.0


@dataclass(frozen=True)
class CorrectionSpeed:
    """Time of one correction with m measurements.

    Attributes
    ----------
    seconds : float
        Of the correction in O(m n^2).
    filterpy_seconds : float or None
        None where filterpy is not installed.
    difference : float
        Largest difference of the corrected state and covariance from the dense form's, in
        units of the state's standard deviations.
    """

    m: int
    seconds: float
    dense_seconds: float
    filterpy_seconds: float | None
    difference: float


@dataclass(frozen=True, eq=False)
class Problem:
    """One correction to be done: see :func:`stereotrack_core.filtering.correction.correct`."""

    P: FloatArray
    dX: FloatArray
    Y: FloatArray
    z: FloatArray
    R: FloatArray
    weights: SigmaWeights

    @property
    def z_hat(self) -> FloatArray:
        """Weighted mean (m,) of the predicted measurements."""
        result: FloatArray = self.weights.mean @ self.Y
        return result


def make_problem(m: int, seed: int = 0) -> Problem:
    """A nearly linear measurement of a state like the body's."""
    random = np.random.default_rng(seed)
    root = random.normal(0.0, 0.1, (STATES, STATES))
    P = root @ root.T + 0.01 * np.eye(STATES)
    weights = scaled_weights(STATES, _ALPHA, _BETA, _KAPPA)
    dX = sigma_deviations(P, weights)
    H = random.normal(0.0, 1.0, (STATES, m))
    Y = dX @ H + 0.1 * (dX @ random.normal(0.0, 1.0, (STATES, m))) ** 2
    return Problem(P, dX, Y, random.normal(0.0, 0.05, m), np.full(m, 0.02**2), weights)


def fast_form(problem: Problem) -> Correction:
    """Run the program's own correction."""
    z_hat = problem.z_hat
    return correct(
        problem.P,
        problem.dX,
        problem.Y - z_hat,
        problem.weights.covariance,
        problem.z - z_hat,
        problem.R,
    )


def dense_form(problem: Problem) -> Correction:
    """K = P_xz P_zz^-1 as the textbook has it, with the m x m matrix (2.2.1)."""
    z_hat, Wc = problem.z_hat, problem.weights.covariance
    dY = problem.Y - z_hat
    P_zz = (dY.T * Wc) @ dY + np.diag(problem.R)
    P_xz = (problem.dX.T * Wc) @ dY
    K = np.linalg.solve(P_zz, P_xz.T).T
    return Correction(K @ (problem.z - z_hat), problem.P - K @ P_zz @ K.T)


def filterpy_form(problem: Problem) -> Callable[[], Correction] | None:
    """The same correction by filterpy's ``UnscentedKalmanFilter``; None without filterpy.

    The predicted measurements are looked up, so that only the correction is timed.
    """
    if importlib.util.find_spec("filterpy") is None:
        return None
    kalman = importlib.import_module("filterpy.kalman")
    m = len(problem.z)
    points = kalman.MerweScaledSigmaPoints(STATES, _ALPHA, _BETA, _KAPPA)
    rows: list[FloatArray] = list(problem.Y)
    order = iter(rows)
    ukf = kalman.UnscentedKalmanFilter(
        STATES, m, dt=1.0, hx=lambda _: next(order), fx=lambda x, _: x, points=points
    )
    ukf.R = np.diag(problem.R)

    def once() -> Correction:
        nonlocal order
        order = iter(rows)
        ukf.x, ukf.P = np.zeros(STATES), problem.P.copy()
        ukf.sigmas_f = problem.dX
        ukf.update(problem.z)
        return Correction(ukf.x, ukf.P)

    return once


def correction_speed(
    measurements: Sequence[int] = MEASUREMENTS,
    *,
    budget: float = 1.0,
    on_progress: Callable[[int], None] = lambda _: None,
) -> tuple[CorrectionSpeed, ...]:
    """Median times for each m, the forms called in turn.

    Parameters
    ----------
    budget : float
        Seconds for each form and m.
    on_progress : callable, optional
        Told how many sizes are done.
    """
    results = []
    for done, m in enumerate(measurements, start=1):
        problem = make_problem(m)
        forms: dict[str, Callable[[], object]] = {
            "fast": lambda p=problem: fast_form(p),  # type: ignore[misc]
            "dense": lambda p=problem: dense_form(p),  # type: ignore[misc]
        }
        theirs = filterpy_form(problem)
        if theirs is not None:
            forms["filterpy"] = theirs
        times = median_seconds(forms, budget=budget)
        results.append(
            CorrectionSpeed(
                m=m,
                seconds=times["fast"],
                dense_seconds=times["dense"],
                filterpy_seconds=times.get("filterpy"),
                difference=difference(fast_form(problem), dense_form(problem), problem.P),
            )
        )
        on_progress(done)
    return tuple(results)


def difference(a: Correction, b: Correction, P: FloatArray) -> float:
    """Largest difference of two corrections in units of the deviations before, P (n, n)."""
    sigma = np.sqrt(np.diag(P))
    in_state = np.abs(a.dx - b.dx) / sigma
    in_covariance = np.abs(a.P - b.P) / np.outer(sigma, sigma)
    return float(max(in_state.max(), in_covariance.max()))


def growth(speeds: Sequence[CorrectionSpeed]) -> float:
    """Exponent e of time ~ m^e."""
    return exponent([speed.m for speed in speeds], [speed.seconds for speed in speeds])
