"""Run a pose model over a recording: in every picture around where the person was before."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.crops import crop_around
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.keypoint_layouts import unnamed, with_layouts
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.person_boxes import person_boxes
from stereotrack_core.recording.reader import FrameReader

_AROUND = 1.25
"""Size of what the model sees over that of the person's box, as these models are trained."""

_SURE = 0.3
"""Confidence from which a keypoint tells where the person is, and the least that is kept."""

_FEWEST = 5
"""Sure keypoints without which the person is looked for in the whole box again."""

_LEAST_SIZE = 0.3
"""Share of where anything moves in the recording that the model sees at least."""

_MARGIN = 0.1
"""Share by which a person reaches beyond the keypoints."""


def detect_keypoints(
    recording: Recording,
    model: PoseModel,
    frames: range,
    *,
    views: Sequence[str] | None = None,
    layout: str | None = None,
    on_frame: Callable[[int], object] = lambda _done: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Keypoints:
    """Keypoints of one person in the reference pictures of views.

    At first the person is where anything moves in the recording, afterwards where the keypoints of
    the picture before were. Raises InputError where a stream cannot be read, or the model has a
    number of points that no usual layout has and `layout` does not name one.

    Parameters
    ----------
    views : sequence of str, optional
        All where it is not given.
    layout : str, optional
        Name in ``LAYOUTS`` of the order of the model's points.
    on_frame : callable
        Is told how many frames are done.
    cancelled : callable
        Whether to stop; what was found until then is returned.
    """
    chosen = [view for view in recording.views if views is None or view.name in views]
    boxes, rows = person_boxes(recording), list[Row]()
    followers = [_Follower(view, recording, model, boxes.get(view.name)) for view in chosen]
    with FrameReader(recording, views=[view.name for view in chosen]) as reader:
        for done, frame in enumerate(frames, start=1):
            if cancelled():
                break
            images = reader.frame_set(frame).views
            for own in followers:
                if own.view.name in images:
                    rows += own.rows(images[own.view.name].image, frame, layout)
            on_frame(done)
    if not rows:
        raise InputError(
            "the model has found no keypoint",
            where=str(model.path),
            remedy="Check that it is a pose model for people, and that the person is visible.",
        )
    return keypoints_of(with_layouts(rows, layout)[0])


class _Follower:
    """Looks at the person in one view, picture after picture."""

    def __init__(
        self,
        view: View,
        recording: Recording,
        model: PoseModel,
        box: tuple[float, float, float, float] | None,
    ) -> None:
        self.view, self._model = view, model
        camera = recording.reference_camera(view)
        left, top, right, bottom = box or (0.0, 0.0, float(camera.width), float(camera.height))
        self._whole = np.array([[left, top], [right, bottom]])
        self._box = self._whole

    def rows(self, picture: ImageArray, frame: int, layout: str | None) -> list[Row]:
        """Keypoints of the next picture that are sure enough to tell anything."""
        low, high = self._box
        centre, reach = (low + high) / 2.0, _AROUND * (high - low)
        crop = crop_around(centre, reach, self._model.size, self.view.display_rotation)
        places, sure = self._model.keypoints(picture, crop)
        self._box = self._next(places[sure >= _SURE])
        names = unnamed(len(places), str(self._model.path), stated=layout)
        camera, name = self.view.image.camera, self._model.path.stem
        return [
            (frame, camera, names[k], *places[k].tolist(), float(sure[k]), name, 0)
            for k in np.flatnonzero(sure >= _SURE).tolist()
        ]

    def _next(self, places: FloatArray) -> FloatArray:
        """The box (2, 2) around the person in the picture after this one."""
        if len(places) < _FEWEST:
            return self._whole
        low, high = places.min(axis=0), places.max(axis=0)
        whole = self._whole[1] - self._whole[0]
        short = np.maximum(_LEAST_SIZE * whole - (high - low), 0.0) / 2.0
        more = _MARGIN * float((high - low).max()) + short
        return np.array([low - more, high + more])
