"""Detected landmarks as measurements of the pose, at a frame's instant and between frames.

Single constraint at a time (Welch & Bishop 1997, DOI 10.1145/258734.258876): one between two frames
corrects the pose by itself as far as it can, with the process noise since the last one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import DETECTION, PIXEL, Rows, jacobian, rows_of
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, orthonormal
from stereotrack_core.body.skeleton import HEAD, LEFT_FOREARM, RIGHT_FOREARM
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording import detections as kinds
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.correction import gathered, solved
from stereotrack_core.tracking.residuals.reprojection import pinhole, pixel_gradients, undistorted
from stereotrack_core.tracking.state import Belief, Setup, State

# Parts at whose ends a detected landmark may be.
_PARTS_OF = {
    kinds.HEAD: (HEAD,),
    kinds.LEFT_HAND: (LEFT_FOREARM,),
    kinds.RIGHT_HAND: (RIGHT_FOREARM,),
    kinds.HAND: (LEFT_FOREARM, RIGHT_FOREARM),
}
_SURE = 3.0  # standard deviations at which a detection has lost three quarters of its weight
_ITERATIONS = 3
_PROBABLE = 0.999  # share of right detections inside the gate by the pose's uncertainty


@dataclass(frozen=True, eq=False)
class DetectionResidual:
    """Place of a point of the body in space, or in the picture of a camera without distortion."""

    part: int
    point: FloatArray  # (3,). In the frame of the part.
    measured: FloatArray  # (3,) world, metres; or (2,) pixels, see :func:`undistorted`
    variance: FloatArray  # (3,) or (2,)
    camera: Camera | None = None

    def predicted(self, frames: PartFrames) -> FloatArray:
        """The point (S, 3), or its pixel (S, 2), for stacked poses."""
        world = _placed(frames, self.part, self.point)
        return world if self.camera is None else _pinhole(self.camera, world)

    def rows(self, frames: PartFrames) -> Rows:
        """Three rows in space or two of a pixel, linearised at one pose."""
        world = _placed(frames, self.part, self.point)
        along = np.eye(3)
        if self.camera is not None:
            move, focal = self.camera.camera_from_world, float(self.camera.matrix[0, 0])
            along = pixel_gradients(move.rotation, move.apply(world), focal)
        off = self.measured - self.predicted(frames), self.variance
        part = np.full(len(along), self.part, dtype=np.int64)
        kind = DETECTION if self.camera is None else PIXEL
        return rows_of(kind, part, np.tile(world, (len(along), 1)), along, off)


@dataclass(frozen=True)
class DetectionObservation:
    """Detections of one instant; given anew to the points of the body at every pose."""

    detections: tuple[Detection, ...]
    gate: float  # metres; farther from the point, a detection means something else

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[DetectionResidual, ...]:
        """Give every detection to the point of the body that it fits best, or to none.

        A point is given to one detection of each source at most: two hands whose side is not known
        are two hands. Weights are w = (g^2 / (g^2 + e^2))^2 with g = 3 sigma, as of the cloud's
        data.
        """
        frames, groups = body.frames(pose), dict[str, list[Detection]]()
        for one in self.detections:
            groups.setdefault("" if one.camera is None else one.camera.name, []).append(one)
        return tuple(
            residual_at(detection, part, _end_of(body, part), frames)
            for group in groups.values()
            for detection, part in _assigned(group, body, frames, self.gate)
        )


def residual_at(
    detection: Detection, part: int, point: FloatArray, frames: PartFrames, widened: float = 0.0
) -> DetectionResidual:
    """Residual of a point (3,) of a part, weighed at one pose; `widened` is added in quadrature."""
    measured, own = _undistorted(detection)
    sigma = float(np.hypot(own, widened))
    plain = DetectionResidual(part, point, measured, np.empty(0), detection.camera)
    off = measured - plain.predicted(frames)
    squared = (_SURE * sigma) ** 2
    weight = (squared / (squared + float(off @ off))) ** 2
    variance = np.full(len(measured), sigma**2 / (detection.confidence * max(weight, 1e-6)))
    return replace(plain, variance=variance)


def _end_of(body: BodyModel, part: int) -> FloatArray:
    """Landmark of hand or head (3,) in the frame of its part."""
    return np.array([0.0, 0.0, body.skeleton.lengths[part]])


def _distance_from(detection: Detection, part: int, body: BodyModel, frames: PartFrames) -> float:
    """Metres between a detection and the end of a part; across the line of sight for a pixel."""
    world = _placed(frames, part, _end_of(body, part))
    measured, _ = _undistorted(detection)
    camera = detection.camera
    if camera is None:
        return float(np.linalg.norm(world - measured))
    pixel = _pinhole(camera, world)
    if not np.isfinite(pixel).all():
        return float("inf")
    depth = float(camera.camera_from_world.apply(world)[2])
    return float(np.linalg.norm(pixel - measured)) * depth / float(camera.matrix[0, 0])


def _assigned(
    detections: list[Detection], body: BodyModel, frames: PartFrames, gate: float
) -> list[tuple[Detection, int]]:
    """Pairs with the least sum of squared distances; beyond the gate none costs less."""
    parts = (HEAD, LEFT_FOREARM, RIGHT_FOREARM)
    cost = np.full((len(detections), len(parts) + len(detections)), gate**2)
    for i, detection in enumerate(detections):
        for k, part in enumerate(parts):
            allowed = part in _PARTS_OF[detection.kind]
            off = _distance_from(detection, part, body, frames) if allowed else np.inf
            cost[i, k] = min(off**2, 1e6)
    rows, chosen = scipy.optimize.linear_sum_assignment(cost)
    pairs = zip(rows, chosen, strict=True)
    return [(detections[i], parts[k]) for i, k in pairs if k < len(parts) and cost[i, k] < gate**2]


def _undistorted(detection: Detection) -> tuple[FloatArray, float]:
    """Place or undistorted pixel of a detection, and its standard deviation in the same unit."""
    if detection.camera is None:
        return detection.position, detection.sigma
    focal = float(detection.camera.matrix[0, 0])
    raw = float(np.mean(np.diagonal(detection.camera.matrix)[:2]))
    return undistorted(detection.camera, detection.position), detection.sigma * focal / raw


def _placed(frames: PartFrames, part: int, point: FloatArray) -> FloatArray:
    return frames.rotations[..., part, :, :] @ point + frames.origins[..., part, :]


def _pinhole(camera: Camera, world: FloatArray) -> FloatArray:
    """Undistorted pixels (..., 2), seen from the principal point; NaN behind the camera."""
    return pinhole(camera.camera_from_world.apply(world), float(camera.matrix[0, 0]))


def predicted_by_detections(
    setup: Setup, state: State, since: float, time: float, due: Sequence[Detection]
) -> Belief:
    """Predict up to a time, frames; each detection due on the way is one correction of its own."""
    belief: Belief = state
    for detection in sorted(due, key=lambda each: each.time):
        belief = setup.predicted(belief, since, detection.time)
        belief, since = corrected_by(detection, setup, belief), detection.time
    return setup.predicted(belief, since, time)


def corrected_by(detection: Detection, setup: Setup, prior: Belief) -> Belief:
    """Correct a pose, predicted for the detection's time, by one detection.

    A hand whose side is not known is the hand that fits better. Farther than the gate from where it
    could belong, or improbable, a detection changes nothing.
    """
    part = _best_part(detection, setup, prior)
    if part is None:
        return prior
    body, at = setup.body, prior
    for _ in range(_ITERATIONS):
        frames = body.frames(at.pose)
        rows = residual_at(detection, part, _end_of(body, part), frames).rows(frames)
        found = gathered((rows,), frames, setup.columns)
        at, _ = solved(setup.joints, prior, at.pose, found)
    return Belief(orthonormal(at.pose), at.P)


def _best_part(detection: Detection, setup: Setup, prior: Belief) -> int | None:
    """Part to whose end the detection fits best by the pose's uncertainty; None beyond the gate."""
    body, columns = setup.body, setup.columns
    frames, gate = body.frames(prior.pose), setup.parameters.detection_gate
    best, least = None, np.inf
    for part in _PARTS_OF[detection.kind]:
        if not _distance_from(detection, part, body, frames) < gate:
            continue
        rows = residual_at(detection, part, _end_of(body, part), frames).rows(frames)
        nu, J = rows["innovation"], jacobian(rows, frames, columns)
        variance = _undistorted(detection)[1] ** 2 / detection.confidence
        S = J @ prior.P @ J.T + np.eye(len(nu)) * variance
        squared = float(nu @ np.linalg.solve(S, nu))
        if squared < min(least, 2.0 * float(scipy.special.gammaincinv(0.5 * len(nu), _PROBABLE))):
            best, least = part, squared
    return best
