"""By how much a click at any frame, camera and landmark would make the limbs' directions surer.

A click measures a landmark's picture: with the Jacobian J of the projection and the covariance P of
the landmark in the fit, it takes B = J^T (J P J^T + sigma^2 I)^-1 J from it, P - P B P. A limb that
may be off by the mean square angle v then may be off by v - sum of tr(Q P B P) (see
:mod:`limb_axes`). The fit's own statement for the limb is brought down by the same factor, because
it also knows how the errors of landmarks hang together. Everything is kept as arrays over all
frames, so that an edit computes the rows anew that it changes, and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.click_reach import (
    REACH,
    UNTIL_FIT,
    hidden_landmarks,
    shares_around,
)
from stereotrack_core.annotation.epipolar import in_image
from stereotrack_core.annotation.fit.measurement import GUESSED_FACTOR, USUAL_SIGMA, sigma_of
from stereotrack_core.annotation.fit.results import FrameFit, TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.limb_axes import (
    OWN_AXES,
    SCORED,
    axis_quadratics,
    axis_sigma_deg,
    mean_squares,
    scored,
)
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.geometry.camera import Camera, pixel_jacobian

_ROWS_AT_ONCE = 256
_LOST = 90.0
"""Degrees; a limb that may be off farther is not known at all."""


class Place(IntEnum):
    """What a person has said about a landmark in an image."""

    FREE = 0
    CLICKED = 1
    REFUSED = 2


class ClickGains:
    """Expected gains (F, C, n) over frames, cameras and landmarks.

    Parameters
    ----------
    cameras : mapping from name to Camera
    landmark_set : LandmarkSet
    fit : TrajectoryFit
        Of this set of landmarks.
    clicks : iterable of Click
        All of them; deleted ones and those outside say that nothing shall be clicked there.
    sigma : float or mapping from landmark to float
        Usual standard deviation of a click in pixels per axis.
    limbs : sequence of str
        Limbs that count.
    reach : int
        Frames on each side that a click tells about.

    Attributes
    ----------
    reach : int
    frame : (F,) int64
    names : tuple of str
        Cameras, in the order of the arrays.
    state : (F, C, n) uint8
        Values of :class:`Place`.
    seen : (F, C, n) bool
        Whether the landmark is in the image.
    hidden : (F, C, n) bool
        Whether the body stands before it.
    gain : (F, C, n) float64
        Degrees, summed up over the limbs that count; 0 where nothing is known or seen.
    """

    def __init__(
        self,
        cameras: Mapping[str, Camera],
        landmark_set: LandmarkSet,
        fit: TrajectoryFit,
        clicks: Iterable[Click],
        *,
        sigma: Mapping[str, float] | float = USUAL_SIGMA,
        limbs: Sequence[str] = SCORED,
        reach: int = REACH,
    ) -> None:
        if fit.names != landmark_set.names:
            raise ValueError("the fit was made with another landmark set")
        self.names = tuple(cameras)
        self.reach = reach
        self.frame = fit.frame
        self._cameras = tuple(cameras.values())
        self._places = np.array([camera.position_world for camera in self._cameras])
        self._set = landmark_set
        self._usual = sigma
        self._counts = scored(limbs)
        self._points = fit.landmarks.copy()
        self._nine = fit.nine.copy()
        self._covariance = fit.covariance.copy()
        self._sigma = axis_sigma_deg(fit.limb_sigma_deg, fit.nine, fit.covariance, landmark_set)
        shape = (len(fit.frame), len(self._cameras), len(landmark_set.names))
        self.state: NDArray[np.uint8] = np.zeros(shape, dtype=np.uint8)
        self.seen: BoolArray = np.zeros(shape, dtype=np.bool_)
        self.hidden: BoolArray = np.zeros(shape, dtype=np.bool_)
        self.gain: FloatArray = np.zeros(shape)
        self._place_clicks(clicks)
        for first in range(0, len(fit.frame), _ROWS_AT_ONCE):
            self._refresh(np.arange(first, min(first + _ROWS_AT_ONCE, len(fit.frame))))

    def row(self, frame: int) -> int | None:
        """Where a frame stands in the arrays; None where the fit does not have it."""
        at = int(np.searchsorted(self.frame, frame))
        return at if at < len(self.frame) and self.frame[at] == frame else None

    def limb_sigma_deg(self) -> FloatArray:
        """Angles (F, 6) by which the limbs may be off, as far as clicks since the fit tell."""
        result: FloatArray = self._sigma[:, OWN_AXES]
        return result

    def clicked(self) -> BoolArray:
        """Whether (F, n) a landmark has a click in some image."""
        result: BoolArray = np.asarray((self.state == Place.CLICKED).any(axis=1))
        return result

    def axis_sigma_deg(self, row: int) -> FloatArray:
        """The same of one frame for all axes (7,), in the order of ``AXES``."""
        result: FloatArray = self._sigma[row]
        return result

    def by_axis(self, row: int, camera: int, landmark: int) -> FloatArray:
        """Gain (7,) of a place for each axis that counts, degrees."""
        rows, cameras = np.array([row]), np.array([camera])
        parts = self._gains(rows, self._click_sigma(rows)[:, cameras], cameras)
        result: FloatArray = parts[0, 0, landmark]
        return result

    def points(self, row: int) -> FloatArray:
        """Landmarks (n, 3) of a frame, world."""
        result: FloatArray = self._points[row]
        return result

    def update(self, frame: int, clicks: Iterable[Click], fit: FrameFit | None = None) -> None:
        """Take in the present clicks of a frame that was edited.

        Without a fit of that frame, new clicks are taken in by their covariance alone, and the
        frames around profit the less the nearer they are to other clicks of the landmark. What was
        taken away is known again after the next fit of the trajectory.

        Parameters
        ----------
        frame : int
        clicks : iterable of Click
            All of the frame, deleted ones too.
        fit : FrameFit, optional
            The fit of these clicks.
        """
        row = self.row(frame)
        if row is None:
            return
        before = self.state[row] == Place.CLICKED
        self.state[row] = Place.FREE
        self._place_clicks(clicks)
        new = (self.state[row] == Place.CLICKED) & ~before
        changed = self._spread(row, new)
        if fit is not None:
            self._points[row] = fit.landmarks_world
            self._covariance[row] = fit.landmark_covariance
            self._sigma[row] = axis_sigma_deg(
                fit.limb_sigma_deg, self._nine[row], fit.landmark_covariance, self._set
            )
        self._refresh(changed)

    def _place_clicks(self, clicks: Iterable[Click]) -> None:
        cameras = {name: i for i, name in enumerate(self.names)}
        landmarks = {name: i for i, name in enumerate(self._set.names)}
        for click in clicks:
            row = self.row(click.frame)
            camera, landmark = cameras.get(click.camera), landmarks.get(click.landmark)
            if row is not None and camera is not None and landmark is not None:
                refused = click.deleted or click.position is None
                self.state[row, camera, landmark] = Place.REFUSED if refused else Place.CLICKED

    def _refresh(self, rows: IntArray) -> None:
        """Compute gains of these rows anew."""
        points = self._points[rows]
        for i, camera in enumerate(self._cameras):
            self.seen[rows, i] = in_image(camera, camera.project(points))
        self.hidden[rows] = hidden_landmarks(
            self._nine[rows], self._set.names, points, self._places
        )
        every = np.arange(len(self._cameras))
        gain = self._gains(rows, self._click_sigma(rows), every).sum(axis=-1)
        self.gain[rows] = np.where(self.seen[rows], np.nan_to_num(gain), 0.0)

    def _click_sigma(self, rows: IntArray) -> FloatArray:
        """Pixels per axis (R, C, n) to be expected of clicks."""
        usual = [sigma_of(Click(0, "", name, (0.0, 0.0)), self._usual) for name in self._set.names]
        factor = np.where(self.hidden[rows], GUESSED_FACTOR, 1.0)
        result: FloatArray = factor * np.array(usual)
        return result

    def _gains(self, rows: IntArray, sigma: FloatArray, cameras: IntArray) -> FloatArray:
        """Degrees (R, c, n, 7) by which each axis becomes surer by clicks in these cameras."""
        covariance = self._covariance[rows]
        quadratics = axis_quadratics(self._nine[rows], self._set)
        now = mean_squares(quadratics, covariance)
        taken = np.einsum("rlij,rlmjk,rlkn->rlmin", covariance, quadratics, covariance)
        information = [
            self._information(self._cameras[camera], rows, sigma[:, i])
            for i, camera in enumerate(cameras)
        ]
        less = np.einsum("rlmij,rclji->rclm", taken, np.stack(information, axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(less / now[:, None, None], 0.0, 1.0)
        before = self._sigma[rows][:, None, None]
        after = before * np.sqrt(1.0 - share)
        gain = np.minimum(before, _LOST) - np.minimum(after, _LOST)
        result: FloatArray = np.nan_to_num(gain) * self._counts
        return result

    def _information(self, camera: Camera, rows: IntArray, sigma: FloatArray) -> FloatArray:
        """B = J^T (J P J^T + sigma^2 I)^-1 J (R, n, 3, 3) of a click in a camera."""
        jacobian = pixel_jacobian(camera, self._points[rows])
        across = np.swapaxes(jacobian, -1, -2)
        innovation_covariance = jacobian @ self._covariance[rows] @ across
        innovation_covariance = innovation_covariance + np.square(sigma)[..., None, None] * np.eye(
            2
        )
        unknown: BoolArray = np.asarray(~np.isfinite(innovation_covariance).all(axis=(-1, -2)))
        innovation_covariance[unknown] = np.eye(2)
        result: FloatArray = across @ np.linalg.solve(innovation_covariance, jacobian)
        return np.where(unknown[..., None, None], 0.0, result)

    def _spread(self, row: int, new: BoolArray) -> IntArray:
        """Bring down the covariances that new clicks (C, n) of a frame make surer; these rows."""
        changed = {row}
        for landmark in np.flatnonzero(new.any(axis=0)):
            clicked = self.clicked()[:, landmark]
            rows, share = shares_around(row, clicked, UNTIL_FIT)
            changed.update(rows.tolist())
            before = self._sure(rows)
            for camera in np.flatnonzero(new[:, landmark]):
                sigma = self._click_sigma(rows)[:, camera]
                information = self._information(self._cameras[camera], rows, sigma)[:, landmark]
                own = self._covariance[rows, landmark]
                less = own @ information @ own
                self._covariance[rows, landmark] = own - share[:, None, None] * less
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.sqrt(self._sure(rows) / before)
            self._sigma[rows] *= np.where(np.isfinite(ratio), ratio, 1.0)
        return np.array(sorted(changed))

    def _sure(self, rows: IntArray) -> FloatArray:
        """Mean square angles (R, 7) from the covariances alone."""
        return mean_squares(axis_quadratics(self._nine[rows], self._set), self._covariance[rows])
