"""Keypoints of a 2-D detector as predictions of landmarks, which a person may accept as clicks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.recording.keypoints import Keypoints

_HAND = AVERAGE.elbow_to_hand / AVERAGE.forearm_length
"""How far the hand's landmark is from the elbow, against the wrist."""

_SIGMA = 0.02
"""Standard deviation of a sure keypoint over the person's size in the picture."""

_UNSURE, _MOST_UNSURE = 20.0, 3.0
"""Growth of that deviation by what the installed detector's confidence lacks of 1, and its largest
factor: elbows below 0.95 are off by two to three times as much as those above."""

_LEAST_SURE = 0.1
"""Confidence of other detectors below which a keypoint is as uncertain as with it."""

_EXTENDED = 2.0
"""Factor on the standard deviation of what is extended from other keypoints."""


def landmark_predictions(keypoints: Keypoints, landmarks: Sequence[str]) -> tuple[Prediction, ...]:
    """Predictions of landmarks in every picture, by the detectors' names.

    A hand that is not predicted is extended from elbow and wrist; a head lies between the ears.

    Parameters
    ----------
    keypoints : Keypoints
        Of one person.
    landmarks : sequence of str
        Names of those that are wanted.
    """
    found: list[Prediction] = []
    order = np.lexsort((keypoints.source, keypoints.camera, keypoints.frame))
    sorted_rows = keypoints[order]
    key = np.stack(
        [sorted_rows.frame.astype(np.str_), sorted_rows.camera, sorted_rows.source], axis=1
    )
    changes = np.flatnonzero((key[1:] != key[:-1]).any(axis=1)) + 1
    for first, end in pairwise([0, *changes.tolist(), len(key)] if len(key) else []):
        found += _of_picture(sorted_rows[slice(first, end)], landmarks)
    return tuple(found)


def _of_picture(rows: Keypoints, landmarks: Sequence[str]) -> list[Prediction]:
    """Predictions of one detector in one picture."""
    places = dict(zip(rows.keypoint.tolist(), rows.place, strict=True))
    sure = dict(zip(rows.keypoint.tolist(), rows.confidence.tolist(), strict=True))
    size = float(np.ptp(rows.place, axis=0).max())
    made = []
    for landmark in landmarks:
        place, told = _place_of(landmark, places)
        if place is not None:
            x, y = place.tolist()
            frame, camera, source = int(rows.frame[0]), str(rows.camera[0]), str(rows.source[0])
            sigma = max(1.0, _SIGMA * size) * doubt(min(sure[name] for name in told), source)
            sigma *= 1.0 if told == (landmark,) else _EXTENDED
            made.append(Prediction(frame, camera, landmark, source, (x, y), sigma))
    return made


def doubt(confidence: float, detector: str) -> float:
    """Factor on the standard deviation of a sure keypoint."""
    if detector == DETECTOR_NAME:
        return min(1.0 + _UNSURE * (1.0 - confidence), _MOST_UNSURE)
    return float(max(confidence, _LEAST_SURE) ** -0.5)


def _place_of(
    landmark: str, places: Mapping[str, FloatArray]
) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Pixel (2,) of a landmark and the keypoints that tell it; None where none do."""
    if landmark in places:
        return places[landmark], (landmark,)
    side, _, name = landmark.partition("_")
    arm = (f"{side}_elbow", f"{side}_wrist")
    if name == "hand" and all(one in places for one in arm):
        elbow, wrist = (places[one] for one in arm)
        return elbow + _HAND * (wrist - elbow), arm
    ears = ("left_ear", "right_ear")
    if landmark == "head" and all(one in places for one in ears):
        return (places[ears[0]] + places[ears[1]]) / 2.0, ears
    return None, ()
