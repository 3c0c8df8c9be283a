"""Run a pose model over a recording: the same person in picture after picture of every view."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.blazepose import LEAST_SCORE
from stereotrack_core.pose_model.crops import Crop, crop_around, crop_from_points
from stereotrack_core.pose_model.detector import (
    PERSON_SCORE,
    POINT_NAMES,
    DetectedPose,
    PersonBox,
    PoseDetector,
    next_crop,
)
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.camera_checks import common_centre
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.keypoint_names import unnamed, with_layouts
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.person_boxes import Box, person_boxes
from stereotrack_core.recording.reader import FrameReader

_MOST_PEOPLE = 3  # people whose landmarks are looked at before the person counts as absent
_DOUBTFUL = 0.05
"""Score of the finder from which a person is believed if the landmarks agree: of simulated people
without a face some have no more, and what is nobody's was refused in some 50 pictures."""

_CERTAIN = 0.9  # score of landmarks from which they make up for that

_AGREED = 0.3  # distance between two circles, over the radius, up to which they agree


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


DETECTOR_NAME = "blazepose"  # source of the installed detector's keypoints
LEAST_CONFIDENCE = 0.3  # confidence below which keypoints are left out

_AROUND = 1.25  # size of what a user's model sees over the person's box, as they are trained
_FEWEST = 5  # keypoints without which the person is looked for in the whole box again
_LEAST_SIZE = 0.3  # share of where anything moves in the recording that the model sees at least
_MARGIN = 0.1  # share by which a person reaches beyond the keypoints
_TILES_AGAIN = 15  # pictures after which a person who is not found is looked for in tiles again


def detect_keypoints(
    reader: FrameReader,
    model: PoseModel | PoseDetector,
    frames: Iterable[int],
    *,
    boxes: Mapping[str, Box] | None = None,
    on_frame: Callable[[int], object] = lambda _done: None,
) -> Keypoints:
    """Keypoints of one person in the pictures of all views of a reader.

    At first the person is looked for, by a model of the user where anything moves in the recording,
    afterwards followed from picture to picture. `boxes` are those of :func:`person_boxes` where
    they are known; `on_frame` is told how many frames are done. Raises InputError where a stream
    cannot be read, nobody is found, or the order of the model's points is unknown.
    """
    recording, chosen = reader.recording, reader.views
    boxes = person_boxes(recording) if boxes is None else boxes
    source = DETECTOR_NAME if isinstance(model, PoseDetector) else model.path.stem
    followers = {
        view.name: _DetectorFollower(model, whereabouts(recording, view, boxes.get(view.name)))
        if isinstance(model, PoseDetector)
        else _ModelFollower(model, recording, view, boxes.get(view.name))
        for view in chosen
    }
    layout = None if isinstance(model, PoseDetector) else model.layout
    rows: list[Row] = []
    for done, frame in enumerate(frames, start=1):
        images = reader.frame_set(frame).views
        for view in chosen:
            if view.name not in images:
                continue
            places, sure = followers[view.name].keypoints(images[view.name].image)
            names: Sequence[str] = POINT_NAMES
            if not isinstance(model, PoseDetector):
                names = unnamed(len(places), str(model.path), stated=layout)
            rows += [
                (frame, view.image.camera, names[k], *places[k].tolist(), float(sure[k]),
                 source, 0)
                for k in np.flatnonzero(sure >= LEAST_CONFIDENCE).tolist()
            ]  # fmt: skip
        on_frame(done)
    if not rows:
        raise InputError(
            "no keypoint was found",
            where=str(recording.folder if isinstance(model, PoseDetector) else model.path),
            remedy="Check that the person is visible, and that a model of your own is of people.",
        )
    return keypoints_of(with_layouts(rows, layout)[0])


class _DetectorFollower:
    """Follows the person in one view with the installed detector."""

    def __init__(self, detector: PoseDetector, where: Whereabouts) -> None:
        self._detector, self._where = detector, where
        self._pose: DetectedPose | None = None
        self._missed = 0

    def keypoints(self, picture: ImageArray) -> tuple[FloatArray, FloatArray]:
        """Places (K, 2) and confidences (K,) in the next picture of the view."""
        tiles = self._missed % _TILES_AGAIN == 0
        pose = detect_person(self._detector, picture, self._pose, self._where, tiles=tiles)
        if pose is None:
            self._missed += 1
            return np.empty((0, 2)), np.empty(0)
        self._pose, self._missed = pose, 0
        return pose.points, confidence(pose, picture.shape)


def confidence(pose: DetectedPose, shape: tuple[int, ...]) -> FloatArray:
    """Confidences (33,) of landmarks; 0 for those beside a picture of the shape (H, W, ...)."""
    end = np.array([shape[1], shape[0]]) - 0.5
    inside = ((pose.points >= -0.5) & (pose.points <= end)).all(axis=1)
    return np.where(inside, np.minimum(pose.visibility, pose.presence), 0.0)


class _ModelFollower:
    """Follows the person in one view with a model of the user."""

    def __init__(self, model: PoseModel, recording: Recording, view: View, box: Box | None) -> None:
        self._model, self._turned = model, view.display_rotation
        camera = recording.reference_camera(view)
        left, top, right, bottom = box or (0.0, 0.0, float(camera.width), float(camera.height))
        self._whole = np.array([[left, top], [right, bottom]])
        self._box = self._whole

    def keypoints(self, picture: ImageArray) -> tuple[FloatArray, FloatArray]:
        low, high = self._box
        centre, reach = (low + high) / 2.0, _AROUND * (high - low)
        crop = crop_around(centre, reach, self._model.size, self._turned)
        places, sure = self._model.keypoints(picture, crop)
        self._box = self._next(places[sure >= LEAST_CONFIDENCE])
        return places, sure

    def _next(self, places: FloatArray) -> FloatArray:
        """The box (2, 2) around the person in the picture after this one."""
        if len(places) < _FEWEST:
            return self._whole
        low, high = places.min(axis=0), places.max(axis=0)
        whole = self._whole[1] - self._whole[0]
        short = np.maximum(_LEAST_SIZE * whole - (high - low), 0.0) / 2.0
        more = _MARGIN * float((high - low).max()) + short
        return np.array([low - more, high + more])
