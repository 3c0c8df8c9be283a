"""Where on the body the keypoints of 2-D detectors are, and how exactly that is meant."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import REST
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    FOREARMS,
    HEAD,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
)

_SIDES = ("left", "right")


@dataclass(frozen=True, eq=False)
class KeypointPlace:
    """A point of the body that a keypoint measures."""

    part: int
    point: FloatArray  # (3,), metres. In the frame of the part.
    slack: float  # metres. Standard deviation of the detectors' point from it


def keypoint_places(body: BodyModel) -> Mapping[str, KeypointPlace]:
    """Places by the keypoints' names; ears and nose only tell where the head is."""
    p, lengths, s = body.skeleton.proportions, body.skeleton.lengths, body.shape
    top = np.array([0.0, 0.0, lengths[HEAD]])
    head = top + REST[HEAD].T @ [0.0, s.keypoint_head_front, s.keypoint_head_up]
    places = {
        "mid_hip": KeypointPlace(TORSO, np.zeros(3), 0.03),
        "neck": KeypointPlace(TORSO, np.array([0.0, 0.0, p.torso_length]), 0.03),
        "head": KeypointPlace(HEAD, head, 0.03),
        "nose": KeypointPlace(HEAD, top, 0.12),
        "left_ear": KeypointPlace(HEAD, top, 0.09),
        "right_ear": KeypointPlace(HEAD, top, 0.09),
    }
    for side, out in zip(_SIDES, (-1.0, 1.0), strict=True):
        places |= _of_one_side(body, side, out)
    return places


def _of_one_side(body: BodyModel, side: str, out: float) -> dict[str, KeypointPlace]:
    """Keypoints of arm, hip and leg; `out` is the sign of x on that side."""
    p, lengths, s, k = body.skeleton.proportions, body.skeleton.lengths, body.shape, int(out > 0.0)
    clavicle, upper_arm, forearm = CLAVICLES[k], UPPER_ARMS[k], FOREARMS[k]
    off = [out * s.keypoint_shoulder_out, s.keypoint_shoulder_front, s.keypoint_shoulder_up]
    hip = [out * (0.5 * p.hip_width + s.keypoint_hip_out), s.keypoint_hip_front, s.keypoint_hip_up]
    elbow, wrist = p.upper_arm_length, p.forearm_length
    shoulder = _along(lengths[clavicle]) + REST[clavicle].T @ off
    places = {
        "shoulder": KeypointPlace(clavicle, shoulder, 0.02),
        "elbow": KeypointPlace(upper_arm, _along(elbow + s.keypoint_elbow_along), 0.015),
        "wrist": KeypointPlace(forearm, _along(wrist + s.keypoint_wrist_along), 0.02),
        "hand": KeypointPlace(forearm, _along(p.elbow_to_hand), 0.02),
        "hip": KeypointPlace(TORSO, np.array(hip), 0.03),
    }
    if THIGHS[k] in body.joints:
        ankle = _along(0.9 * lengths[SHANKS[k]])
        places["knee"] = KeypointPlace(SHANKS[k], np.zeros(3), 0.04)
        places["ankle"] = KeypointPlace(SHANKS[k], ankle, 0.06)
    return {f"{side}_{name}": place for name, place in places.items()}


def _along(length: float) -> FloatArray:
    """The point (3,) so far along a part."""
    return np.array([0.0, 0.0, length])
