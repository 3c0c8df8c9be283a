"""Fits of a trajectory as they come out where every so many frames are clicked."""

import numpy as np

from stereotrack_core.annotation.click_gains import OWN_AXES, axis_quadratics, mean_squares
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.landmark_set import NINE


def limb_sigma_deg(nine, covariance, landmark_set):
    """Root mean square angles (..., 6), degrees, of limbs by covariances (..., n, 3, 3)."""
    v = mean_squares(axis_quadratics(nine, landmark_set), covariance)
    return np.degrees(np.sqrt(np.maximum(v[..., OWN_AXES], 0.0)))


def fit_of(points, clicked, *, sure=0.01, unsure=0.06, unknown=(), residuals=None, outliers=None):
    """A fit of landmarks (F, 9, 3), known to `sure` metres at clicked frames, worse between."""
    frames = len(points)
    clicked = np.array(sorted(clicked))
    away = np.abs(np.arange(frames)[:, None] - clicked).min(axis=1)
    largest = max(int(np.diff(clicked).max()) / 2, 1.0) if len(clicked) > 1 else frames
    spread = sure + (unsure - sure) * np.sqrt(np.minimum(away / largest, 1.0))
    covariance = np.square(spread)[:, None, None, None] * np.eye(3)
    covariance = np.broadcast_to(covariance, (frames, 9, 3, 3)).copy()
    points = points.copy()
    kind = np.where(away == 0, CLICKED, INTERPOLATED)
    for row in unknown:
        points[row], covariance[row], kind[row] = np.nan, np.nan, GAP
    return TrajectoryFit(
        names=NINE.names, frame=np.arange(frames), landmarks=points, covariance=covariance,
        limb_sigma_deg=limb_sigma_deg(points, covariance, NINE), kind=kind, nine=points,
        residual_px=residuals or {}, outlier_probability=outliers or {},
    )  # fmt: skip
