"""What a 2-D detector would predict of a recording whose truth is known, with its errors."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_SOURCE = "simulated"
_NAMES = tuple(name.replace("hand", "wrist") for name in LANDMARKS)
_WRIST = AVERAGE.forearm_length / AVERAGE.elbow_to_hand
_TRUNK_RADIUS = 0.11
_HIDDEN_BEHIND = 0.14
"""Metres that a point lies inside the flesh: so far in front of it nothing hides it."""

_ARMS = ("elbow", "wrist")


@dataclass(frozen=True)
class KeypointErrors:
    """How a detector errs."""

    noise: float = 5.0  # pixels, standard deviation of each coordinate
    gross: float = 0.05  # share of keypoints anywhere on the person's part of the picture
    exchanged: float = 0.02  # share of pictures with left for right, half of them of the arms alone
    hidden_missing: float = 0.5  # share of hidden keypoints; the others are guessed
    guess: float = 8.0  # factor on the noise of guessed ones


def simulated_keypoints(
    truth: LandmarkTrajectory,
    cameras: Mapping[str, Camera],
    errors: KeypointErrors | None = None,
    seed: int = 0,
) -> Keypoints:
    """Shoulders, elbows, wrists, hips and head of the truth in the pictures of cameras.

    What the trunk is in front of is hidden, and what the truth does not know is left out. Rows get
    the names by which the cameras are given.
    """
    errors = errors or KeypointErrors()
    rows: list[Row] = []
    for v, (name, camera) in enumerate(cameras.items()):
        rng = np.random.default_rng((seed, v))
        for frame, points in zip(truth.frame.tolist(), truth.points, strict=True):
            rows += _picture(frame, _with_wrists(points), name, camera, errors, rng)
    return keypoints_of(rows)


def _with_wrists(points: FloatArray) -> FloatArray:
    """The landmarks (9, 3) with wrists for hands."""
    result, at = points.copy(), LANDMARKS.index
    for side in ("left", "right"):
        elbow, hand = at(f"{side}_elbow"), at(f"{side}_hand")
        result[hand] = points[elbow] + _WRIST * (points[hand] - points[elbow])
    return result


def _hidden(points: FloatArray, centre: FloatArray) -> BoolArray:
    """Whether the trunk is between each point (9, 3) and an optical centre (3,)."""
    at = LANDMARKS.index
    hips = (points[at("left_hip")] + points[at("right_hip")]) / 2.0
    shoulders = (points[at("left_shoulder")] + points[at("right_shoulder")]) / 2.0
    away = centre - points
    away = away / np.linalg.norm(away, axis=1, keepdims=True)
    low, high = np.broadcast_to(hips, points.shape), np.broadcast_to(shoulders, points.shape)
    begin = points + _HIDDEN_BEHIND * away
    distance = segment_distance(begin, np.broadcast_to(centre, points.shape), low, high)
    result: BoolArray = distance < _TRUNK_RADIUS
    return result


def _picture(
    frame: int,
    points: FloatArray,
    name: str,
    camera: Camera,
    errors: KeypointErrors,
    rng: np.random.Generator,
) -> Iterator[Row]:
    """Rows of one picture; as much is drawn of chance whatever becomes of it."""
    place, count = camera.project(points), len(points)
    hidden = _hidden(points, camera.position_world)
    scale = errors.noise * np.where(hidden, errors.guess, 1.0)
    noise = scale[:, None] * rng.standard_normal((count, 2))
    gross, missing = rng.random(count) < errors.gross, rng.random(count) < errors.hidden_missing
    anywhere, sure = rng.random((count, 2)), rng.uniform(0.6, 1.0, count)
    swapped, whole = rng.random() < errors.exchanged, rng.random() < 0.5
    known = np.isfinite(place).all(axis=1)
    if not known.any():
        return
    low, high = place[known].min(axis=0), place[known].max(axis=0)
    margin = 0.2 * (high - low)
    wrong = low - margin + anywhere * (high - low + 2.0 * margin)
    place = np.where(gross[:, None], wrong, place + noise)
    sure = np.where(hidden & ~gross, 0.5 * sure, sure)
    inside = (place >= 0).all(axis=1) & (place < [camera.width, camera.height]).all(axis=1)
    for k in np.flatnonzero(known & inside & ~(hidden & missing & ~gross)):
        own = _NAMES[k]
        if swapped and (whole or own.split("_")[-1] in _ARMS):
            own = exchanged(own)
        yield frame, name, own, *place[k].tolist(), float(sure[k]), _SOURCE, 0
