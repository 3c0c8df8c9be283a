"""The same person in picture after picture of a view."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.pose_model.blazepose import LEAST_SCORE
from stereotrack_core.pose_model.crops import Crop, crop_from_points
from stereotrack_core.pose_model.detector import (
    PERSON_SCORE,
    DetectedPose,
    PersonBox,
    PoseDetector,
    next_crop,
)
from stereotrack_core.recording.camera_checks import common_centre
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.person_boxes import Box

_MOST_PEOPLE = 3
"""People whose landmarks are looked at before a picture counts as one without the person."""

_DOUBTFUL = 0.05
"""Score of the finder from which a person is believed if the landmarks agree: of simulated people
without a face some have no more, and what is nobody's was refused in some 50 pictures."""

_CERTAIN = 0.9  # score of landmarks from which they make up for that

_AGREED = 0.3
"""Distance between two findings of the circle, over its radius, below which they agree."""


@dataclass(frozen=True, eq=False)
class Whereabouts:
    """Where a view probably shows the person, before anybody was found."""

    expected: FloatArray  # (2,). Pixel of the place at which the cameras look.
    moving: Crop | None = None  # surroundings of all that moves in the recording
    turned: int = 0  # degrees by which the picture is turned clockwise to be upright


def whereabouts(recording: Recording, view: View, moving: Box | None = None) -> Whereabouts:
    """Where a view shows the person: what cameras look at, and where it is `moving`
    (:func:`person_boxes`).
    """
    camera = recording.reference_camera(view)
    expected = np.array([camera.width - 1.0, camera.height - 1.0]) / 2.0
    cameras = {one.name: recording.reference_camera(one) for one in recording.views}
    if len(cameras) > 1:
        watched = camera.project(common_centre(cameras))
        if (np.abs(watched - expected) <= expected).all():  # it may be behind a wrong camera
            expected = watched
    turned = view.display_rotation
    around = None if moving is None else crop_from_points(np.reshape(moving, (2, 2)), turned)
    return Whereabouts(expected, around, turned)


def detect_person(
    detector: PoseDetector,
    picture: ImageArray | Float32Array,
    last: DetectedPose | None,
    where: Whereabouts,
    *,
    tiles: bool = True,
) -> DetectedPose | None:
    """Landmarks of the person in a picture, None if nobody is found.

    The person is looked for where `last` was, a pose shortly before or after, then in the whole
    picture, then where something moves, then in `tiles` of it, which take a second. Of several
    people the one nearest to `last`, or to the expected place, is taken.
    """
    if last is not None:
        pose = detector.landmarks(picture, next_crop(last))
        if pose.score >= PERSON_SCORE:
            return pose
    place = where.expected if last is None else last.circle[0]
    people = detector.find_people(
        picture, turned=where.turned, least_height=np.inf, least_score=_DOUBTFUL
    )
    found = _nearest(detector, picture, people, place)
    if found is not None:
        return found
    if where.moving is not None:
        pose = detector.landmarks(picture, where.moving)
        if pose.score >= PERSON_SCORE:  # a crop around the whole body shows more of it
            return detector.landmarks(picture, next_crop(pose))
    if not tiles:
        return None
    people = detector.find_people(picture, turned=where.turned)
    return _nearest(detector, picture, people, place)


def _nearest(
    detector: PoseDetector,
    picture: ImageArray | Float32Array,
    people: list[PersonBox],
    place: FloatArray,
) -> DetectedPose | None:
    """Landmarks of whose hips are nearest to a pixel; doubtful people come last."""
    order = sorted(people, key=lambda one: (one.score < LEAST_SCORE, _distance(one, place)))
    for person in order[:_MOST_PEOPLE]:
        pose = detector.landmarks(picture, person.crop)
        if person.score < LEAST_SCORE:
            if _is_certain(detector, picture, person, pose):
                return pose
        elif pose.score >= PERSON_SCORE:
            return pose
    return None


def _is_certain(
    detector: PoseDetector,
    picture: ImageArray | Float32Array,
    person: PersonBox,
    pose: DetectedPose,
) -> bool:
    """Whether landmarks confirm a doubtful person, and those of the crop that follows from them."""
    if pose.score < _CERTAIN:
        return False
    again = detector.landmarks(picture, next_crop(pose))
    circles = np.stack([np.stack([person.hips, person.top]), pose.circle, again.circle])
    apart = np.linalg.norm(circles - pose.circle, axis=2).max()
    return again.score >= _CERTAIN and float(apart) < _AGREED * person.radius


def _distance(person: PersonBox, place: FloatArray) -> float:
    return float(np.linalg.norm(person.hips - place)) / max(person.radius, 1.0)
