"""By how much a click at any frame, camera and landmark would make the limbs' directions surer.

The direction of an axis, a difference of landmarks or of middles of two, is off by the mean square
angle

    v = sum over l of w_l^2 tr((I - d d^T) P_l) / length^2,

with the landmarks' weights w_l and independent errors P_l, and its unit vector d. A click measures
a landmark's picture: with the Jacobian J of the projection and the covariance P of the landmark in
the fit, it takes B = J^T (J P J^T + sigma^2 I)^-1 J from it, P - P B P. A limb that may be off by v
then may be off by v - sum of tr(Q P B P). The fit's own statement for the limb is brought down by
the same factor, because it also knows how the errors of landmarks hang together. Everything is kept
as arrays over all frames, so that an edit computes the rows anew that it changes, and nothing else.

Limbs move smoothly, so a click also makes the frames around it surer: by a share that falls from
one to nothing at the landmark's next click, or `reach` frames away where there is none so near.
"""

from collections.abc import Iterable
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import GUESSED_FACTOR, USUAL_SIGMA, Click, Sigmas, sigma_of
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.predict import hidden_landmarks, in_image
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.geometry.camera import Camera, pixel_jacobian
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS

SCORED: tuple[str, ...] = tuple(limb for limb in LIMBS if limb != "head")
"""Limbs whose errors are reported; the head enters no measure."""

_ENDS = list(LIMB_ENDS.items())
_ENDS.insert(1, ("torso_cross_axis", (("left_shoulder",), ("right_shoulder",))))
_WEIGHTS: dict[str, dict[str, float]] = {
    axis: dict.fromkeys(far, 1.0 / len(far)) | dict.fromkeys(near, -1.0 / len(near))
    for axis, (near, far) in _ENDS
}

AXES: tuple[str, ...] = tuple(_WEIGHTS)
"""A limb's own axis has its name; the torso has its cross axis besides the long one."""

_LIMB_OF_AXIS: tuple[str, ...] = tuple(
    "torso" if axis == "torso_cross_axis" else axis for axis in AXES
)

COUNTS = np.array([float(limb in SCORED) for limb in _LIMB_OF_AXIS])  # (7,): 1 if scored
OWN_AXES = [AXES.index(limb) for limb in LIMBS]  # of the limbs, in the order of ``LIMBS``
_FURTHER = 0.5  # weight of a landmark that is none of the nine in the axes of its limb
_SHORTEST = 0.05  # metres; a shorter axis is no limb, and counts as long as this


def axis_quadratics(nine: FloatArray, landmark_set: LandmarkSet) -> FloatArray:
    """Q (..., n, 7, 3, 3) with which v (..., a) = sum over l of tr(Q (..., l, a) P_l).

    Of the nine landmarks (..., 9, 3) and n landmarks of a set, 1 / square metres; NaN where an axis
    is not known.
    """
    result: FloatArray = np.zeros((*nine.shape[:-2], len(landmark_set.names), len(AXES), 3, 3))
    for i, (weights, limb) in enumerate(zip(_WEIGHTS.values(), _LIMB_OF_AXIS, strict=True)):
        axis = sum(weight * nine[..., LANDMARKS.index(name), :] for name, weight in weights.items())
        length = np.linalg.norm(axis, axis=-1)[..., None]
        along = axis / np.where(length > 0, length, 1.0)
        across = np.eye(3) - along[..., :, None] * along[..., None, :]
        quadratic = across / np.maximum(length, _SHORTEST)[..., None] ** 2
        for place, landmark in enumerate(landmark_set.landmarks):
            weight = weights.get(landmark.name, 0.0)
            if landmark.name not in LANDMARKS and landmark.limb == limb:
                weight = _FURTHER
            if weight:
                result[..., place, i, :, :] = weight**2 * quadratic
    return result


def mean_squares(quadratics: FloatArray, covariance: FloatArray) -> FloatArray:
    """Mean square angles v (..., 7) from :func:`axis_quadratics` and covariances (..., n, 3, 3)."""
    return np.asarray(np.einsum("...laij,...lji->...a", quadratics, covariance))


REACH = 6
"""Frames. On recordings of fast arm movements at 10 frames per second, suggestions ranked with 3, 6
or 12 frames gave about the same errors, and without this a fifth to a third larger ones."""


_UNTIL_FIT = 15
"""Frames around a new click that count as surer until the next fit, so that the next suggestions go
elsewhere; fewer led to clicks too close to each other."""


def distances(clicked: BoolArray, reach: int) -> tuple[IntArray, IntArray]:
    """Frames (F, n) since and until a click (F, n) of a landmark, at most `reach`; 0 at one."""
    frames = np.arange(len(clicked))[:, None]
    far = len(clicked) + reach
    last = np.maximum.accumulate(np.where(clicked, frames, -far), axis=0)
    following = np.where(clicked, frames, 2 * far)[::-1]
    following = np.minimum.accumulate(following, axis=0)[::-1]
    return np.minimum(frames - last, reach), np.minimum(following - frames, reach)


def over_frames(gain: FloatArray, clicked: BoolArray, reach: int) -> FloatArray:
    """Gains (F, C, n) at single frames summed up over the frames around; degrees times frames."""
    before, after = distances(clicked, reach)
    total = gain.copy()
    for away in range(1, min(reach, len(gain))):
        earlier = np.clip(1.0 - away / np.maximum(before, 1), 0.0, 1.0)[:, None]
        later = np.clip(1.0 - away / np.maximum(after, 1), 0.0, 1.0)[:, None]
        total[away:] += earlier[away:] * gain[:-away]
        total[:-away] += later[:-away] * gain[away:]
    return total


def shares_around(row: int, clicked: BoolArray, reach: int) -> tuple[IntArray, FloatArray]:
    """Rows that profit from a click at one row, and by which share; `clicked` is (F,)."""
    others = np.flatnonzero(clicked)
    before, after = others[others < row], others[others > row]
    low = max(int(before[-1]) if len(before) else -1, row - reach)
    high = min(int(after[0]) if len(after) else len(clicked), row + reach)
    low_side = row - reach if not len(before) else low
    high_side = row + reach if not len(after) else high
    rows = np.arange(low + 1, high)
    rising = (rows - low_side) / max(row - low_side, 1)
    falling = (high_side - rows) / max(high_side - row, 1)
    share = np.where(rows < row, rising, falling)
    return rows, share


_ROWS_AT_ONCE = 256
_LOST = 90.0  # degrees; a limb that may be off farther is not known at all


class Place(IntEnum):
    """State of a landmark in an image."""

    FREE = 0
    CLICKED = 1
    REFUSED = 2


class ClickGains:
    """Expected gains (F, C, n) over frames, cameras and landmarks, by a fit of this set.

    Deleted clicks and those outside say that nothing shall be clicked there. `sigma` is the usual
    standard deviation of a click in pixels per axis.

    Attributes
    ----------
    names : cameras, in the order of the arrays
    state : (F, C, n); values of :class:`Place`
    seen : (F, C, n); whether the landmark is in the image
    hidden : (F, C, n); whether the body stands before it
    gain : (F, C, n); degrees, summed up over the limbs that count; 0 where nothing is known or seen
    sigma_deg : (F, 7); angles by which the axes, in the order of ``AXES``, may be off, as far as
        clicks since the fit tell
    """

    def __init__(
        self,
        cameras: Cameras,
        landmark_set: LandmarkSet,
        fit: TrajectoryFit,
        clicks: Iterable[Click],
        *,
        sigma: Sigmas = USUAL_SIGMA,
    ) -> None:
        self.names = tuple(cameras)
        self.frame = fit.frame
        self._cameras = tuple(cameras.values())
        self._places = np.array([camera.position_world for camera in self._cameras])
        self._set, self._points, self._nine = landmark_set, fit.landmarks, fit.nine
        usual = [sigma_of(Click(0, "", name, (0.0, 0.0)), sigma) for name in landmark_set.names]
        self._usual = np.array(usual)
        self._covariance = fit.covariance.copy()
        limbs = [LIMBS.index(limb) for limb in _LIMB_OF_AXIS]
        self.sigma_deg: FloatArray = fit.limb_sigma_deg[:, limbs].copy()
        # the torso's cross axis is as much surer than the long axis as the landmarks say
        v = mean_squares(axis_quadratics(fit.nine, landmark_set), fit.covariance)
        cross = AXES.index("torso_cross_axis")
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.sqrt(v[:, cross] / v[:, 0])
        self.sigma_deg[:, cross] *= np.nan_to_num(relative, nan=1.0, posinf=1.0)
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
        return self.sigma_deg[:, OWN_AXES]

    def clicked(self) -> BoolArray:
        """Whether (F, n) a landmark has a click in some image."""
        return np.asarray((self.state == Place.CLICKED).any(axis=1))

    def by_axis(self, row: int, camera: int, landmark: int) -> FloatArray:
        """Gain (7,) of a place for each axis that counts, degrees."""
        rows, cameras = np.array([row]), np.array([camera])
        parts = self._gains(rows, self._click_sigma(rows)[:, cameras], cameras)
        return np.asarray(parts[0, 0, landmark])

    def update(self, frame: int, clicks: Iterable[Click]) -> None:
        """Take in the clicks of an edited frame, deleted ones too, until the next fit."""
        row = self.row(frame)
        if row is None:
            return
        before = self.state[row] == Place.CLICKED
        self.state[row] = Place.FREE
        self._place_clicks(clicks)
        new = (self.state[row] == Place.CLICKED) & ~before
        self._refresh(self._spread(row, new))

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
        points = self._points[rows]
        for i, camera in enumerate(self._cameras):
            self.seen[rows, i] = in_image(camera, camera.project(points))
        names = self._set.names
        self.hidden[rows] = hidden_landmarks(self._nine[rows], names, points, self._places)
        every = np.arange(len(self._cameras))
        gain = self._gains(rows, self._click_sigma(rows), every).sum(axis=-1)
        self.gain[rows] = np.where(self.seen[rows], np.nan_to_num(gain), 0.0)

    def _click_sigma(self, rows: IntArray) -> FloatArray:
        """Pixels per axis (R, C, n) to be expected of clicks."""
        return np.asarray(np.where(self.hidden[rows], GUESSED_FACTOR, 1.0) * self._usual)

    def _gains(self, rows: IntArray, sigma: FloatArray, cameras: IntArray) -> FloatArray:
        """Degrees (R, c, n, 7) by which each axis becomes surer by clicks in these cameras."""
        covariance = self._covariance[rows]
        quadratics = axis_quadratics(self._nine[rows], self._set)
        now = mean_squares(quadratics, covariance)
        taken = np.einsum("rlij,rlmjk,rlkn->rlmin", covariance, quadratics, covariance)
        used = enumerate(self._cameras[camera] for camera in cameras)
        information = [self._information(camera, rows, sigma[:, i]) for i, camera in used]
        less = np.einsum("rlmij,rclji->rclm", taken, np.stack(information, axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(less / now[:, None, None], 0.0, 1.0)
        before = self.sigma_deg[rows][:, None, None]
        after = before * np.sqrt(1.0 - share)
        gain = np.minimum(before, _LOST) - np.minimum(after, _LOST)
        return np.asarray(np.nan_to_num(gain) * COUNTS)

    def _information(self, camera: Camera, rows: IntArray, sigma: FloatArray) -> FloatArray:
        """B = J^T (J P J^T + sigma^2 I)^-1 J (R, n, 3, 3) of a click in a camera."""
        jacobian = pixel_jacobian(camera, self._points[rows])
        across = np.swapaxes(jacobian, -1, -2)
        noise = np.square(sigma)[..., None, None] * np.eye(2)
        innovation = jacobian @ self._covariance[rows] @ across + noise
        unknown: BoolArray = np.asarray(~np.isfinite(innovation).all(axis=(-1, -2)))
        innovation[unknown] = np.eye(2)
        result: FloatArray = across @ np.linalg.solve(innovation, jacobian)
        return np.where(unknown[..., None, None], 0.0, result)

    def _spread(self, row: int, new: BoolArray) -> IntArray:
        """Bring down the covariances that new clicks (C, n) of a frame make surer; these rows."""
        changed = {row}
        for landmark in np.flatnonzero(new.any(axis=0)):
            clicked = self.clicked()[:, landmark]
            rows, share = shares_around(row, clicked, _UNTIL_FIT)
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
            self.sigma_deg[rows] *= np.where(np.isfinite(ratio), ratio, 1.0)
        return np.array(sorted(changed))

    def _sure(self, rows: IntArray) -> FloatArray:
        """Mean square angles (R, 7) from the covariances alone."""
        return mean_squares(axis_quadratics(self._nine[rows], self._set), self._covariance[rows])
