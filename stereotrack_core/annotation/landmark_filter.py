"""Prediction of the landmarks of a frame from the clicks of others.

One Gaussian holds, for all landmarks, place and velocity in the world and, for every image, how far
a person's clicks lie from where the calibration puts the place. Clicked frames are taken in one
after the other by an iterated extended Kalman filter (Bar-Shalom, Li and Kirubarajan, Estimation
with Applications to Tracking and Navigation, 10.5). Velocities fade, and random accelerations come
in, whose size is learned.

Where the body was followed through the images, the difference of the places is measured (stochastic
cloning: Roumeliotis and Burdick, ICRA 2002). Predictions from both sides are fused.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, Prediction, sigma_of
from stereotrack_core.annotation.follow_body import BodyStep
from stereotrack_core.annotation.predict import pixel_scale, predicted_points
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.geometry.camera import pixel_jacobian
from stereotrack_core.recording.description import Cameras

WANTED_MM = 20.0  # root mean square error of the landmarks where nobody has said otherwise
STEADY = 0.5  # share of a click's standard deviation that is not in the offset
_FRAMES = 10  # clicked frames on each side that are taken in
_PLACE, _ANYWHERE, _SPEED = 0.3, 2.0, 1.0  # metres around first clicks, or around others; m/s
_FADING = 0.3  # seconds after which velocities have faded
_STEP, _MOST_STEPS = 0.1, 30  # seconds that an acceleration lasts
_ACCELERATION = 10.0  # metres per square second, before it is learned
_LEARNING = 0.2  # share of the last frame in what is learned
_ALIKE = 0.4  # metres over which accelerations are alike
_LEAST_OFFSET, _OFFSET, _DRIFT = 1.0, 20.0, 1.0
"""Pixels at 480 lines by which clicks lie beside the calibration, at least and at most, and per
root second."""

_ENOUGH = 10  # residuals that tell how far it is
_SLACK = (0.004, 0.010, 0.050)
"""Metres by which a landmark moves beside the followed body: at least, before it is learned, at
most."""

_ASTRAY = 0.05  # share of a followed way that it may be off besides
_ACCEPTED_SIGMA = 2.0  # pixels at 480 lines; nobody has looked closer than that
_FREEDOM = 4.0  # of the t distribution of followed points
_STEP_FREEDOM = 3.0  # of that of the followed body
_ROUNDS = 3
_STEEPEST = 1e6  # pixels a metre; more is so near to a camera that nothing is seen


@dataclass(frozen=True, eq=False)
class ProposalQuestion:
    """Clicks and motion from which a frame's landmarks are proposed."""

    frame: int
    clicks: tuple[Click, ...]  # of this frame
    around: tuple[Click, ...]  # of other frames
    followed: tuple[Prediction, ...]  # to this frame, from clicks of others, or detected in it
    cameras: Cameras  # whose images are clicked
    names: tuple[str, ...]  # of the landmarks
    fps: float
    sigmas: Mapping[str, float] = field(default_factory=dict)  # of clicks, pixels
    steps: tuple[BodyStep, ...] = ()  # how the body was seen to move from clicked frames to others
    wanted_mm: float = WANTED_MM  # accuracy of the landmarks up to which clicks are asked for


@dataclass(frozen=True, eq=False)
class Gaussian:
    """Mean (n, S) and covariance (n S, n S) of n landmarks: place, velocity, offset per camera."""

    mean: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class Measured:
    """M pixels of landmarks in images."""

    camera: IntArray  # (M,)
    landmark: IntArray  # (M,)
    pixel: FloatArray  # (M, 2)
    sigma: FloatArray  # (M,)
    followed: BoolArray  # (M,); may be far off


class Rig:
    """The cameras and landmarks of a question, by number."""

    def __init__(self, question: ProposalQuestion) -> None:
        self.names, self.sigmas = question.names, question.sigmas
        self.cameras = tuple(question.cameras.values())
        self.scale = np.array([pixel_scale(camera) for camera in self.cameras])
        self._camera = {name: place for place, name in enumerate(question.cameras)}
        self._landmark = {name: place for place, name in enumerate(question.names)}
        self.size = 6 + 2 * len(self.cameras)

    def measured(self, clicks: Sequence[Click], followed: Sequence[Prediction] = ()) -> Measured:
        """Clicks, and followed points of what is not clicked, as measurements."""
        said = {click.key for click in clicks}
        alike = Counter(one.landmark for one in clicks if one.accepted)
        rows = [
            (c.camera, c.landmark, c.position, self._sigma(c, alike[c.landmark]), False)
            for c in clicks
            if c.position is not None
        ] + [
            (one.camera, one.landmark, one.position, one.sigma or USUAL_SIGMA, True)
            for one in followed
            if one.key not in said
        ]
        rows = [row for row in rows if row[0] in self._camera and row[1] in self._landmark]
        return Measured(
            np.array([self._camera[row[0]] for row in rows], dtype=np.int64),
            np.array([self._landmark[row[1]] for row in rows], dtype=np.int64),
            np.array([row[2] for row in rows], dtype=np.float64).reshape(-1, 2),
            np.array([row[3] for row in rows], dtype=np.float64),
            np.array([row[4] for row in rows], dtype=np.bool_),
        )

    def _sigma(self, click: Click, alike: int) -> float:
        """Accepted places are off in all images alike, so that several tell no more than one."""
        sigma = STEADY * sigma_of(click, self.sigmas)
        if not click.accepted or click.camera not in self._camera:
            return sigma
        least = _ACCEPTED_SIGMA * float(self.scale[self._camera[click.camera]])
        return sqrt(alike) * max(sigma, least)

    def pixels(self, mean: FloatArray) -> FloatArray:
        """Where the landmarks are seen (C, n, 2), offsets included."""
        offsets = mean[:, 6:].reshape(len(mean), -1, 2)
        return np.stack(
            [c.project(mean[:, :3]) + offsets[:, i] for i, c in enumerate(self.cameras)]
        )

    def missed(self, measured: Measured, mean: FloatArray) -> FloatArray:
        """Pixels (M, 2) by which the landmarks miss what is measured; 0 behind a camera.

        Two cameras that face each other hardly tell how far away a place between them is.
        """
        return np.nan_to_num(measured.pixel - self.pixels(mean)[measured.camera, measured.landmark])

    def jacobian(self, mean: FloatArray, camera: IntArray, landmark: IntArray) -> FloatArray:
        """Derivative (M, 2, n S) of pixels of landmarks in images by the state."""
        by_place = np.stack([pixel_jacobian(c, mean[:, :3]) for c in self.cameras])
        found = np.zeros((len(camera), 2, len(mean), self.size))
        row = np.arange(len(camera))
        found[row, :, landmark, :3] = by_place[camera, landmark]
        for axis in range(2):
            found[row, axis, landmark, 6 + 2 * camera + axis] = 1.0
        seen = (np.abs(found) < _STEEPEST).all(axis=(1, 2, 3))  # NaN behind a camera
        found[~seen] = 0.0
        return found.reshape(len(camera), 2, len(mean) * self.size)


class LandmarkFilter:
    """Takes in the clicked frames around one frame."""

    def __init__(self, question: ProposalQuestion) -> None:
        self._question, self._rig = question, Rig(question)
        self._steps = {(s.start, s.end): s for s in question.steps if s.names == question.names}
        by_frame: dict[int, list[Click]] = {}
        for click in question.around:
            if click.camera in question.cameras:
                by_frame.setdefault(click.frame, []).append(click)
        self._clicks = by_frame

    def predicted(self) -> Gaussian | None:
        """Prediction for the frame itself; None if too little has been clicked."""
        frame = self._question.frame
        before = [known for known in sorted(self._clicks) if known < frame][-_FRAMES:]
        after = [known for known in sorted(self._clicks, reverse=True) if known > frame][-_FRAMES:]
        sides = [side for frames in (before, after) if (side := self._from(frames)) is not None]
        if len(sides) < 2:
            return sides[0] if sides else None
        one, two = sides
        gain = np.linalg.solve(one.covariance + two.covariance, one.covariance).T
        apart = (two.mean - one.mean).ravel()
        mean = one.mean + (gain @ apart).reshape(one.mean.shape)
        return Gaussian(mean, _symmetric(one.covariance - gain @ one.covariance))

    def detected(self) -> Gaussian | None:
        """Wide prior from what a detector sees in the frame; None without it in two images."""
        followed = self._question.followed
        seen = {one.key: Click(*one.key, one.position, sigma=one.sigma) for one in followed}
        clicked = {one.key: one for one in self._question.clicks}
        return self._begun(tuple((seen | clicked).values())) if seen else None

    def _from(self, frames: Sequence[int]) -> Gaussian | None:
        """The prediction from clicked frames on one side, in the order they are taken in."""
        acceleration = np.full(len(self._rig.names), _ACCELERATION)
        slack = np.full(len(self._rig.names), _SLACK[1])
        state: Gaussian | None = None
        for place, frame in enumerate(frames):
            clicks = self._clicks[frame]
            if state is None:
                begun = self._begun(clicks)
                state = begun and updated(begun, self._rig, self._rig.measured(clicks))
                continue
            seconds = (frame - frames[place - 1]) / self._question.fps
            before = state
            expected = self._moved(state, frames[place - 1], frame, acceleration, slack)
            state = updated(expected, self._rig, self._rig.measured(clicks))
            slack = self._learned(slack, frames[place - 1], frame, before, state)
            off = np.linalg.norm((state.mean - expected.mean)[:, :3], axis=1)
            seen = np.maximum(2.0 * off / (np.sqrt(3.0) * seconds**2), 0.1 * _ACCELERATION)
            mean = (1.0 - _LEARNING) * np.square(acceleration) + _LEARNING * np.square(seen)
            acceleration = np.sqrt(mean)
        if state is None:
            return None
        return self._moved(state, frames[-1], self._question.frame, acceleration, slack)

    def _learned(
        self, slack: FloatArray, start: int, end: int, before: Gaussian, after: Gaussian
    ) -> FloatArray:
        """How far landmarks (n,) move beside the followed body, after one more step."""
        step = self._steps.get((start, end))
        if step is None:
            return slack
        off = np.square((after.mean - before.mean)[:, :3] - step.shift).mean(axis=1)
        off = np.where(np.isfinite(off), np.minimum(off, _SLACK[2] ** 2), np.square(slack))
        learned = np.sqrt((1.0 - _LEARNING) * np.square(slack) + _LEARNING * off)
        return np.maximum(learned, _SLACK[0])

    def _begun(self, clicks: Sequence[Click]) -> Gaussian | None:
        """Before a first frame is taken in; None where no landmark is clicked in two images."""
        rig = self._rig
        mean = np.zeros((len(rig.names), rig.size))
        mean[:, :3] = np.nan
        points = predicted_points(self._question.cameras, clicks, sigma=rig.sigmas)
        for place, name in enumerate(rig.names):
            if name in points:
                mean[place, :3] = points[name].world
        if np.isnan(mean[:, 0]).all():
            return None
        beside = self._beside(mean[:, :3], clicks)
        known = np.isfinite(mean[:, :3])
        mean[:, :3] = np.where(known, mean[:, :3], np.nanmean(mean[:, :3], axis=0))
        spread = np.tile(np.repeat(beside * rig.scale, 2), (len(mean), 1))
        spread = np.hstack(
            [np.where(known, _PLACE, _ANYWHERE), np.full((len(mean), 3), _SPEED), spread]
        )
        return Gaussian(mean, np.diag(np.square(spread).ravel()))

    def _beside(self, places: FloatArray, clicks: Sequence[Click]) -> float:
        """By how many pixels at 480 lines clicks lie beside where they put the places (n, 3)."""
        measured = self._rig.measured(clicks)
        known = np.isfinite(places[measured.landmark]).all(axis=1)
        pixels = np.stack([camera.project(places) for camera in self._rig.cameras])
        off = (measured.pixel - pixels[measured.camera, measured.landmark])[known]
        off = off / self._rig.scale[measured.camera[known], None]
        free = 2 * len(off) - 3 * len(np.unique(measured.landmark[known]))
        if free < _ENOUGH:
            return _OFFSET
        return float(np.clip(np.sqrt(np.square(off).sum() / free), _LEAST_OFFSET, _OFFSET))

    def _moved(
        self, state: Gaussian, start: int, end: int, acceleration: FloatArray, slack: FloatArray
    ) -> Gaussian:
        seconds = (end - start) / self._question.fps
        steps = min(max(round(abs(seconds) / _STEP), 1), _MOST_STEPS)
        moved = state
        for _ in range(steps):
            moved = self._pushed(moved, seconds / steps, acceleration)
        if (seen := self._steps.get((start, end))) is not None:
            whole = np.linalg.matrix_power(self._transition(seconds / steps), steps)
            moved = _stepped(state, moved, whole, seen, slack)
        return moved

    def _transition(self, seconds: float) -> FloatArray:
        """How the state of a landmark (S, S) goes on for a while."""
        faded = np.exp(-abs(seconds) / _FADING)
        step = np.eye(self._rig.size)
        step[:3, 3:6] = 0.5 * seconds * (1.0 + faded) * np.eye(3)
        step[3:6, 3:6] = faded * np.eye(3)
        return step

    def _pushed(self, state: Gaussian, seconds: float, acceleration: FloatArray) -> Gaussian:
        size, count = self._rig.size, len(state.mean)
        step = self._transition(seconds)
        places = state.mean[:, :3]
        apart = np.linalg.norm(places[:, None] - places, axis=-1)
        alike = np.exp(-apart / _ALIKE) * acceleration[:, None] * acceleration
        by_acceleration = np.array([0.5 * seconds**2, seconds])
        pushed = np.zeros((size, size))
        pushed[:6, :6] = np.kron(np.outer(by_acceleration, by_acceleration), np.eye(3))
        drift = np.square(np.repeat(_DRIFT * self._rig.scale, 2)) * abs(seconds)
        whole = np.kron(np.eye(count), step)
        covariance = whole @ state.covariance @ whole.T + np.kron(alike, pushed)
        covariance += np.diag(np.tile(np.concatenate([np.zeros(6), drift]), count))
        return Gaussian(state.mean @ step.T, covariance)


def updated(prior: Gaussian, rig: Rig, measured: Measured) -> Gaussian:
    """The Gaussian after measurements; followed points weigh the less the farther they are off."""
    if not len(measured.camera):
        return prior
    start, covariance, mean = prior.mean.ravel(), prior.covariance, prior.mean
    weight = np.ones(len(measured.camera))
    for _ in range(_ROUNDS):
        H = rig.jacobian(mean, measured.camera, measured.landmark).reshape(-1, start.size)
        off = rig.missed(measured, mean)
        R = np.repeat(np.square(measured.sigma) / weight, 2)
        S = H @ covariance @ H.T + np.diag(R)
        K = np.linalg.solve(S, H @ covariance).T
        mean = (start + K @ (off.ravel() - H @ (start - mean.ravel()))).reshape(prior.mean.shape)
        off = rig.missed(measured, mean)
        distance = np.square(off).sum(axis=1) / np.square(measured.sigma)
        weight = np.where(measured.followed, (_FREEDOM + 2.0) / (_FREEDOM + distance), 1.0)
    return Gaussian(mean, _symmetric(covariance - K @ H @ covariance))


def _stepped(
    state: Gaussian, moved: Gaussian, whole: FloatArray, seen: BodyStep, slack: FloatArray
) -> Gaussian:
    """Prediction corrected by how the body was seen to move; `whole` (S, S) leads to `moved`."""
    known = np.flatnonzero(np.isfinite(seen.shift).all(axis=1))
    if not len(known):
        return moved
    at = (whole.shape[0] * known[:, None] + np.arange(3)).ravel()
    before = np.kron(np.eye(len(state.mean)), whole) @ state.covariance[:, at]
    after = moved.covariance[:, at]
    cross = after - before  # with the difference of the places
    certain = state.covariance[np.ix_(at, at)] + after[at] - before[at] - before[at].T
    innovation = (seen.shift - (moved.mean - state.mean)[:, :3])[known]
    way = np.linalg.norm(seen.shift[known], axis=1)
    own = np.square(slack[known]) + np.square(_ASTRAY * way)
    noise = seen.covariance[known] + own[:, None, None] * np.eye(3)
    weight, each = np.ones(len(known)), np.arange(len(known))
    for _ in range(_ROUNDS):
        blocks = np.zeros((len(known), 3, len(known), 3))
        blocks[each, :, each, :] = noise / weight[:, None, None]
        R = blocks.reshape(certain.shape)
        S = certain + R
        left = (R @ np.linalg.solve(S, innovation.ravel())).reshape(-1, 3)
        distance = np.einsum("ni,ni->n", left, np.linalg.solve(noise, left[..., None])[..., 0])
        weight = (_STEP_FREEDOM + 3.0) / (_STEP_FREEDOM + distance)
    K = np.linalg.solve(S, cross.T).T
    mean = moved.mean + (K @ innovation.ravel()).reshape(moved.mean.shape)
    return Gaussian(mean, _symmetric(moved.covariance - K @ cross.T))


def _symmetric(matrix: FloatArray) -> FloatArray:
    return 0.5 * (matrix + matrix.T)
