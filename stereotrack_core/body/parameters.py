"""Parameters of the body's shape; lengths come from the subject."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Body"


@dataclass(frozen=True)
class BodyParameters(ParameterGroup):
    """Shape of the cones, for a person of average size; they grow with the proportions."""

    proportions: str = parameter(
        "individual", _GROUP, choices=("individual", "average", "sequence"), thesis="individual"
    )(
        "Segment lengths: of the recording's subject file, average lengths, or estimated from "
        "the sequence (its first part is then tracked twice). Without a subject file, individual "
        "lengths are average ones for the height that the first frames show."
    )
    legs: bool = parameter(True, _GROUP, thesis=False)(
        "Add cones for the legs, so that leg points are not assigned to other parts."
    )
    girdle: bool = parameter(True, _GROUP, thesis=False, fast=False)(
        "Let the shoulders be raised, protracted and retracted. Otherwise they are fixed to the "
        "torso."
    )
    torso_radius_low: float = parameter(0.165, _GROUP, (0.05, 0.4), unit="m")(
        "Radius of the torso at the hips."
    )
    torso_radius_high: float = parameter(0.175, _GROUP, (0.05, 0.4), unit="m")(
        "Radius of the torso at the shoulders."
    )
    torso_flatness: float = parameter(0.62, _GROUP, (0.3, 1.0))(
        "Depth of the torso relative to its width."
    )
    torso_forward_low: float = parameter(0.03, _GROUP, (-0.2, 0.2), unit="m", thesis=0.0)(
        "Forward offset of the torso centre at the hips."
    )
    torso_forward_high: float = parameter(0.015, _GROUP, (-0.2, 0.2), unit="m", thesis=0.0)(
        "Forward offset of the torso centre at the shoulders."
    )
    head_forward: float = parameter(0.015, _GROUP, (-0.2, 0.2), unit="m", thesis=0.0)(
        "Forward offset of the head centre at the neck."
    )
    arm_radius_factor: float = parameter(1.0, _GROUP, (0.3, 3.0))(
        "Scale of the radii of arms and hands."
    )


def _margin(what: str) -> float:
    text = f"Distance of the contour from the surface, outwards: {what}."
    margin: float = parameter(-0.008, "Body contour", (-0.1, 0.1), unit="m")(text)
    return margin


def _keypoint(where: str) -> float:
    text = f"Distance of a detector's keypoint from the landmark of its name: {where}."
    offset: float = parameter(0.0, "Keypoints", (-0.1, 0.1), unit="m")(text)
    return offset


@dataclass(frozen=True)
class BodyShape(BodyParameters):
    """Shape of one person: also what nobody sets, as it is fitted to the first frames.

    The margins say how far contours in the images lie off the surface of the clouds, and the
    keypoints' offsets where a 2-D detector sees joints, which are not where the landmarks are.
    """

    shoulder_rise: float = parameter(0.0, _GROUP, (-0.2, 0.2), unit="m")(
        "Height of the shoulder cones above the shoulder joints."
    )
    shoulder_radius_factor: float = parameter(1.0, _GROUP, (0.3, 3.0))(
        "Scale of the shoulder radii."
    )
    head_rise: float = parameter(0.0, _GROUP, (-0.2, 0.2), unit="m")(
        "Height of the widest point of the head above the head landmark."
    )
    head_radius_factor: float = parameter(1.0, _GROUP, (0.3, 3.0))("Scale of the head radii.")
    leg_forward: float = parameter(0.015, _GROUP, (-0.2, 0.2), unit="m")(
        "Forward offset of the leg centre at hips and knees."
    )
    leg_length_factor: float = parameter(1.0, _GROUP, (0.7, 1.4))(
        "Length of the legs relative to what the length from the hips to the head lets expect."
    )
    leg_radius_factor: float = parameter(1.0, _GROUP, (0.3, 3.0))("Scale of the leg radii.")
    contour_torso_side: float = _margin("torso, lateral")
    contour_torso_front: float = _margin("torso, front and back")
    contour_shoulder_top: float = _margin("shoulders, top")
    contour_shoulder_front: float = _margin("shoulders, front and back")
    contour_jaw_side: float = _margin("lower head, lateral")
    contour_jaw_front: float = _margin("lower head, front and back")
    contour_head_side: float = _margin("upper head, lateral")
    contour_head_front: float = _margin("upper head, front and back")
    contour_upper_arm: float = _margin("upper arms")
    contour_forearm: float = _margin("forearms")
    contour_hand: float = _margin("hands")
    keypoint_shoulder_out: float = _keypoint("shoulders, away from the middle")
    keypoint_shoulder_front: float = _keypoint("shoulders, forward")
    keypoint_shoulder_up: float = _keypoint("shoulders, upward")
    keypoint_hip_out: float = _keypoint("hips, away from the middle")
    keypoint_hip_front: float = _keypoint("hips, forward")
    keypoint_hip_up: float = _keypoint("hips, upward")
    keypoint_elbow_along: float = _keypoint("elbows, along the upper arm")
    keypoint_wrist_along: float = _keypoint("wrists, along the forearm")
    keypoint_head_front: float = _keypoint("head, forward")
    keypoint_head_up: float = _keypoint("head, upward")

    @staticmethod
    def of(parameters: BodyParameters) -> BodyShape:
        """The shape that parameters state, average where they say nothing."""
        if isinstance(parameters, BodyShape):
            return parameters
        return BodyShape().replaced(**parameters.values())
