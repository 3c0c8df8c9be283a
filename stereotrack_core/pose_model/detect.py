"""Run a pose model over a recording: the keypoints of one person in every picture."""

from collections.abc import Callable, Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.crops import crop_around
from stereotrack_core.pose_model.detector import POINT_NAMES, DetectedPose, PoseDetector
from stereotrack_core.pose_model.following import Whereabouts, detect_person, whereabouts
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.keypoint_names import unnamed, with_layouts
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.person_boxes import Box, person_boxes
from stereotrack_core.recording.reader import FrameReader

DETECTOR_NAME = "blazepose"  # source of the installed detector's keypoints
LEAST_CONFIDENCE = 0.3  # confidence below which keypoints are left out

_AROUND = 1.25
"""Size of what a model of the user sees over that of the person's box, as they are trained."""

_FEWEST = 5  # keypoints without which the person is looked for in the whole box again
_LEAST_SIZE = 0.3  # share of where anything moves in the recording that the model sees at least
_MARGIN = 0.1  # share by which a person reaches beyond the keypoints
_TILES_AGAIN = 15  # pictures after which a person who is not found is looked for in tiles again


def detect_keypoints(
    recording: Recording,
    model: PoseModel | PoseDetector,
    frames: range,
    *,
    views: Sequence[str] | None = None,
    layout: str | None = None,
    on_frame: Callable[[int], object] = lambda _done: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Keypoints:
    """Keypoints of one person in the reference pictures of views, all if none are named.

    At first the person is looked for, by a model of the user where anything moves in the recording,
    afterwards followed from picture to picture. `layout` names in ``LAYOUTS`` the order of the
    points of such a model. `on_frame` is told how many frames are done; once `cancelled` says so,
    what was found is returned. Raises InputError where a stream cannot be read, or the order is
    unknown.
    """
    chosen = [view for view in recording.views if views is None or view.name in views]
    boxes = person_boxes(recording)
    source = DETECTOR_NAME if isinstance(model, PoseDetector) else model.path.stem
    followers = {
        view.name: _DetectorFollower(model, whereabouts(recording, view, boxes.get(view.name)))
        if isinstance(model, PoseDetector)
        else _ModelFollower(model, recording, view, boxes.get(view.name))
        for view in chosen
    }
    rows: list[Row] = []
    with FrameReader(recording, views=list(followers)) as reader:
        for done, frame in enumerate(frames, start=1):
            if cancelled():
                break
            images = reader.frame_set(frame).views
            for view in chosen:
                if view.name not in images:
                    continue
                places, sure = followers[view.name].keypoints(images[view.name].image)
                names = _names(model, len(places), layout)
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


def _names(model: PoseModel | PoseDetector, count: int, layout: str | None) -> Sequence[str]:
    if isinstance(model, PoseDetector):
        return POINT_NAMES
    return unnamed(count, str(model.path), stated=layout)


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
