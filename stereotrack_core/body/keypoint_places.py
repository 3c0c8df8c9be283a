"""Where on the body the keypoints of 2-D detectors are, and how exactly that is meant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.skeleton import FOREARMS, HEAD, SHANKS, THIGHS, TORSO, UPPER_ARMS

_SIDES = ("left", "right")


@dataclass(frozen=True, eq=False)
class KeypointPlace:
    """A point of the body that a keypoint measures."""

    part: int
    point: FloatArray
    """(3,), metres. In the frame of the part."""
    slack: float
    """Metres. How far the point that detectors mean may lie from it, as a standard deviation."""


def keypoint_places(body: BodyModel) -> Mapping[str, KeypointPlace]:
    """Places by the keypoints' names; what is not here tells nothing about this body.

    The head has no turn about its own axis, so ears and nose only tell where it is.
    """
    p, lengths, middle = body.skeleton.proportions, body.skeleton.lengths, np.zeros(3)
    top = np.array([0.0, 0.0, lengths[HEAD]])
    places = {
        "mid_hip": KeypointPlace(TORSO, middle, 0.03),
        "neck": KeypointPlace(TORSO, np.array([0.0, 0.0, p.torso_length]), 0.03),
        "head": KeypointPlace(HEAD, top, 0.03),
        "nose": KeypointPlace(HEAD, top, 0.12),
        "left_ear": KeypointPlace(HEAD, top, 0.09),
        "right_ear": KeypointPlace(HEAD, top, 0.09),
    }
    for side, upper_arm, forearm in zip(_SIDES, UPPER_ARMS, FOREARMS, strict=True):
        wrist = np.array([0.0, 0.0, p.forearm_length])
        hand = np.array([0.0, 0.0, p.elbow_to_hand])
        places |= {
            f"{side}_shoulder": KeypointPlace(upper_arm, middle, 0.02),
            f"{side}_elbow": KeypointPlace(forearm, middle, 0.015),
            f"{side}_wrist": KeypointPlace(forearm, wrist, 0.02),
            f"{side}_hand": KeypointPlace(forearm, hand, 0.02),
        }
    for side, thigh, shank in zip(_SIDES, THIGHS, SHANKS, strict=True):
        hip = np.array([(-0.5 if side == "left" else 0.5) * p.hip_width, 0.0, 0.0])
        places[f"{side}_hip"] = KeypointPlace(TORSO, hip, 0.03)
        if thigh in body.joints:
            places[f"{side}_knee"] = KeypointPlace(shank, middle, 0.04)
            ankle = np.array([0.0, 0.0, 0.9 * lengths[shank]])
            places[f"{side}_ankle"] = KeypointPlace(shank, ankle, 0.06)
    return places
