"""Corrections of trackers on the manifold, taken apart after they were made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.jacobian import Columns
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import FOREARMS
from stereotrack_core.filtering.linearisation import linearised
from stereotrack_core.filtering.sigma_points import SigmaWeights, sigma_deviations
from stereotrack_core.tracking.arms_apart import ApartResidual
from stereotrack_core.tracking.correction import Residual
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.detections.residual import DetectionResidual
from stereotrack_core.tracking.inside.events import Corrected, Correcting
from stereotrack_core.tracking.inside.trace import (
    TOO_FAR,
    Correction,
    Points,
    Rows,
    SigmaPoints,
    Unused,
)
from stereotrack_core.tracking.limits import ClearanceResidual, DirectionResidual
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.tracker import PersonTracker


@dataclass(frozen=True, eq=False)
class Method:
    """What is needed to take a correction apart.

    Attributes
    ----------
    body : BodyModel
    joints : tuple of int
    columns : Columns
    weights : SigmaWeights
    by_sigma_points : bool
        Whether the tracker linearises by sigma points; else by derivatives.
    """

    body: BodyModel
    joints: tuple[int, ...]
    columns: Columns
    weights: SigmaWeights
    by_sigma_points: bool

    @staticmethod
    def of(tracker: PersonTracker) -> Method:
        """Method of a tracker."""
        setup = tracker.setup
        by_points = setup.parameters.linearisation == "sigma_points"
        return Method(setup.body, setup.joints, setup.columns, setup.weights, by_points)


@dataclass(frozen=True, eq=False)
class Place:
    """Where one correction came about.

    Attributes
    ----------
    stage : str
    iteration : int
    correspond_seconds, correct_seconds : float
    """

    stage: str
    iteration: int
    correspond_seconds: float
    correct_seconds: float


@dataclass(frozen=True, eq=False)
class Line:
    """One residual as the correction saw it: z - z_hat = H dx + e.

    Attributes
    ----------
    nu : (m,) float64
    H : (m, n) float64
    R : (m,) float64
        Variances of e.
    """

    nu: FloatArray
    H: FloatArray
    R: FloatArray


def correction_of(
    method: Method, data: FloatArray, told: Correcting, done: Corrected, place: Place
) -> Correction:
    """Take one correction apart.

    Parameters
    ----------
    method : Method
    data : (N, 3 or more) float64
        That looked for the model.
    told, done
        What the tracker has said before and after.
    place : Place
    """
    deviations = sigma_deviations(told.P, method.weights)
    poses = displaced(told.pose, deviations, method.joints)
    surface, lines = told.rows[0], _lines(method, told, method.body.frames(poses))
    assert isinstance(surface, SurfaceResidual)  # noqa: S101 - the points always come first
    of_points = lines[0]
    P_xz = told.P @ of_points.H.T
    return Correction(
        stage=place.stage,
        iteration=place.iteration,
        prior=Belief(told.prior, told.P0),
        before=Belief(told.pose, told.P),
        sigma_points=SigmaPoints(deviations, poses, method.by_sigma_points),
        points=points_of(surface, of_points),
        unused=_unused(data, surface),
        rows=_rows(told.rows[1:], lines[1:], done.P),
        P_xz=P_xz,
        P_zz=np.einsum("mn,nm->m", of_points.H, P_xz),
        gain=done.P @ (of_points.H.T / of_points.R),
        dx=done.dx,
        from_prior=done.P
        @ np.linalg.solve(told.P0, difference(told.prior, told.pose, method.joints)),
        after=Belief(done.pose, done.P),
        correspond_seconds=place.correspond_seconds,
        correct_seconds=place.correct_seconds,
    )


def points_of(surface: SurfaceResidual, line: Line | None = None) -> Points:
    """Pairs of a residual, as they are or as a correction saw them."""
    return Points(
        surface.part,
        surface.data,
        surface.foot,
        surface.direction,
        surface.distance if line is None else line.nu,
        np.sqrt(surface.variance if line is None else line.R),
        surface.weight,
    )


def is_among(rows: FloatArray, others: FloatArray) -> BoolArray:
    """Which rows (N, k) are, to the last bit, among others (M, k)."""
    kind = np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))
    a, b = (np.ascontiguousarray(each).view(kind).ravel() for each in (rows, others))
    return np.isin(a, b)


def _lines(method: Method, told: Correcting, spread: PartFrames) -> list[Line]:
    if method.by_sigma_points:
        return [_by_sigma_points(residual, method, told.P, spread) for residual in told.rows]
    frames = method.body.frames(told.pose)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    return [
        Line(
            residual.measured - residual.predicted(stacked)[0],
            residual.jacobian(frames, method.columns),
            residual.variance,
        )
        for residual in told.rows
    ]


def _by_sigma_points(residual: Residual, method: Method, P: FloatArray, spread: PartFrames) -> Line:
    line = linearised(residual.predicted(spread), method.weights, about="centre")
    L = np.linalg.cholesky(P)
    H: FloatArray = scipy.linalg.solve_triangular(L, line.D, lower=True, trans="T").T
    return Line(residual.measured - line.mean, H, residual.variance + line.spread)


def _unused(data: FloatArray, surface: SurfaceResidual) -> Unused:
    places = np.ascontiguousarray(data[:, :3])
    left = places[~is_among(places, surface.data)]
    part = np.full(len(left), -1, dtype=np.int64)
    return Unused(left, part, np.full(len(left), TOO_FAR, dtype=np.int64))


def _rows(residuals: tuple[Residual, ...], lines: list[Line], P: FloatArray) -> tuple[Rows, ...]:
    """Rows by kind; `P` is the covariance after the correction."""
    found: dict[tuple[str, str], list[Rows]] = {}
    for residual, line in zip(residuals, lines, strict=True):
        kind, part, unit = _kind_of(residual)
        dx = P @ (line.H.T @ (line.nu / line.R))
        rows = Rows(kind, part, line.nu, np.sqrt(line.R), unit, dx)
        found.setdefault((kind, unit), []).append(rows)
    return tuple(_joined(rows) for rows in found.values() if sum(len(r.part) for r in rows))


def _joined(rows: list[Rows]) -> Rows:
    part, residual, sigma = (
        np.concatenate([getattr(row, name) for row in rows])
        for name in ("part", "residual", "sigma")
    )
    dx = np.sum([row.dx for row in rows], axis=0)
    return Rows(rows[0].kind, part, residual, sigma, rows[0].unit, dx)


def _kind_of(residual: Residual) -> tuple[str, IntArray, str]:
    """Kind, parts (m,) and unit of a residual's rows."""
    count = len(residual.variance)
    match residual:
        case SurfaceResidual():
            return "outline", residual.part, "m"
        case ApartResidual():
            return "arms", residual.left, "m"
        case ClearanceResidual():
            return "torso", residual.part, "m"
        case DirectionResidual():
            kind = "elbow" if residual.part[0] in FOREARMS else "rest"
            return kind, residual.part, "rad"
        case DetectionResidual():
            unit = "m" if residual.camera is None else "px"
            return "detection", np.full(count, residual.part, dtype=np.int64), unit
    return "other", np.full(count, -1, dtype=np.int64), "m"
