"""The pretrained pose detector: people in a picture, and the landmarks of each.

Its two networks are BlazePose (see :mod:`.installation`), run by LiteRT on one thread, so that the
same picture always gives the same numbers.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model import blazepose
from stereotrack_core.pose_model.crops import (
    Crop,
    as_rgb,
    as_uint8,
    crop_from_circle,
    whole_picture,
)
from stereotrack_core.pose_model.installation import (
    MODEL_FILES,
    detector_folder,
    installation,
    is_installed,
    landmark_file,
)
from stereotrack_core.recording.keypoint_names import MEDIAPIPE_33

POINT_NAMES = MEDIAPIPE_33  # names of the 33 points, in their order

PERSON_SCORE = 0.5  # score of landmarks from which they are a person's; the next crop may follow
_LEAST_HEIGHT = 60.0  # height in pixels of the smallest person that is looked for in tiles

_FOUND_SHARE = 0.35  # height of a person over the side of the crop from which finding is reliable
_NEAR = 0.4
"""Distance of two persons' hips over the radius of the larger one, below which detections of two
tiles are of the same person."""

_FINDER_OUTPUTS = ("Identity", "Identity_1")
_LANDMARK_OUTPUTS = ("Identity", "Identity_3", "Identity_1", "Identity_2")
"""39 points, their heat maps, score, and mask."""


@dataclass(frozen=True, eq=False)
class PersonBox:
    """A person that the finder sees, by the circle around the body."""

    hips: FloatArray  # (2,). Middle of the hips, pixels of the picture.
    top: FloatArray  # (2,). Point above the head on the circle around the hips.
    score: float  # from 0 to 1

    @property
    def radius(self) -> float:
        """Radius of the circle around the body, pixels; about half the height of a person."""
        return float(np.linalg.norm(self.top - self.hips))

    @property
    def crop(self) -> Crop:
        """Part of the picture that the landmark network needs."""
        return crop_from_circle(self.hips, self.top)


@dataclass(frozen=True, eq=False)
class DetectedPose:
    """Landmarks of a person in one picture; :data:`POINT_NAMES` names them."""

    points: FloatArray  # (33, 2). Pixels of the picture; perhaps beside it.
    visibility: FloatArray  # (33,). Probability that a point is in the picture and not hidden.
    presence: FloatArray  # (33,). Probability that a point is in the picture.
    score: float  # probability that a person is in the crop
    circle: FloatArray  # (2, 2). Hips, and the point above the head on the circle around them.
    mask: FloatArray | None = None  # (H, W). Probability of the person at a pixel, if asked for.


def next_crop(pose: DetectedPose) -> Crop:
    """Crop for the same person in the next picture, as MediaPipe follows a person."""
    return crop_from_circle(*pose.circle)


def load_detector() -> PoseDetector | None:
    """The installed detector, ready to be asked; None if it or its runtime is not installed."""
    return PoseDetector(detector_folder()) if is_installed() else None


def required_detector() -> PoseDetector:
    """The installed detector. Raises InputError saying what to install."""
    state = installation()
    if not state.complete:
        what, remedy = state.problem()
        raise InputError(what, remedy=remedy)
    return PoseDetector(state.folder)


class PoseDetector:
    """The two networks, whose files are in a folder; may be used by several threads, one at a time.

    Raises InputError if the files cannot be run.
    """

    def __init__(self, folder: Path) -> None:
        self._finder = _Network(folder / MODEL_FILES[0].name)
        self._landmarks = _Network(folder / landmark_file(folder))
        self._lock = Lock()

    def find_people(
        self,
        picture: ImageArray | Float32Array,
        *,
        turned: int = 0,
        least_height: float = _LEAST_HEIGHT,
        least_score: float = blazepose.LEAST_SCORE,
    ) -> list[PersonBox]:
        """People in a picture, turned clockwise by degrees to be upright, the surest first.

        The whole picture is looked at; if nobody is there, overlapping tiles of half its side, then
        of a quarter, until a person of `least_height` pixels would be seen. Below a score of 0.5
        most are nobody.
        """
        shown = as_uint8(picture)
        whole = whole_picture(shown.shape, turned)
        found = self._people(shown, whole, least_score)
        side = whole.side
        while not found and side > least_height / _FOUND_SHARE:
            side /= 2.0
            for tile in _tiles(shown.shape, side, whole.angle):
                found += self._people(shown, tile, least_score)
            found = _each_once(found)
        return found

    def _people(self, shown: ImageArray, crop: Crop, least_score: float) -> list[PersonBox]:
        size = (blazepose.FINDER_SIDE, blazepose.FINDER_SIDE)
        seen = as_rgb(crop.seen(shown, size)).astype(np.float32)
        with self._lock:
            raw, logits = self._finder.run(seen / 127.5 - 1.0, *_FINDER_OUTPUTS)
        found = blazepose.suppress(blazepose.decode(raw, logits[:, 0], least_score))
        points = crop.in_picture(found.points, size)
        both = zip(points, found.scores, strict=True)
        return [PersonBox(own[0], own[1], float(score)) for own, score in both]

    def landmarks(
        self, picture: ImageArray | Float32Array, crop: Crop, *, mask: bool = False
    ) -> DetectedPose:
        """Landmarks of the person in the middle of a crop; `mask`: and which pixels show the
        person.
        """
        size = (blazepose.LANDMARK_SIDE, blazepose.LANDMARK_SIDE)
        seen = as_rgb(crop.seen(as_uint8(picture), size)).astype(np.float32)
        with self._lock:
            points, heat, score, person = self._landmarks.run(seen / 255.0, *_LANDMARK_OUTPUTS)
        rows = points.reshape(39, 5).astype(np.float64)  # x, y, z, visibility and presence
        # The network counts from the corner of its input: landmarks of 80 mirrored pictures agree
        # to 0.0 (0.1) pixels then, refined ones to 0.4 (0.2).
        rows[:33, :2] = blazepose.refined(rows[:33, :2], heat)
        places = crop.in_picture(rows[:35, :2] - 0.5, size)
        return DetectedPose(
            places[:33],
            blazepose.sigmoid(rows[:33, 3]),
            blazepose.sigmoid(rows[:33, 4]),
            float(score[0]),
            places[33:],
            crop.mask_in_picture(blazepose.sigmoid(person[..., 0]), picture.shape[:2])
            if mask
            else None,
        )


def _tiles(shape: tuple[int, ...], side: float, angle: float) -> Iterator[Crop]:
    """Squares of a side that cover a picture (H, W, ...) and overlap by half."""
    centres = []
    for length in shape[:2]:
        count = max(int(np.ceil((length - side) / (side / 2.0))), 0) + 1
        ends = (side / 2.0, length - side / 2.0) if length > side else (length / 2.0, length / 2.0)
        centres.append(np.linspace(*ends, count) - 0.5)
    for y, x in product(*centres):
        yield Crop(np.array([x, y]), side, angle)


def _each_once(found: list[PersonBox]) -> list[PersonBox]:
    """People of overlapping tiles, of each the surest detection, the surest first."""
    kept: list[PersonBox] = []
    for one in sorted(found, key=lambda person: -person.score):
        near = (
            np.linalg.norm(one.hips - other.hips) < _NEAR * max(one.radius, other.radius)
            for other in kept
        )
        if not any(near):
            kept.append(one)
    return kept


class _Network:
    """A network file, run by LiteRT on one thread."""

    def __init__(self, path: Path) -> None:
        from ai_edge_litert.interpreter import Interpreter

        try:
            with _without_messages():
                self._interpreter: Any = Interpreter(model_path=str(path), num_threads=1)
                self._interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise InputError(
                f"this is no network that can be run ({error})", where=str(path),
                remedy="Run `stereotrack detector install` again.",
            ) from None  # fmt: skip
        self._input = self._interpreter.get_input_details()[0]["index"]
        outputs = self._interpreter.get_output_details()
        self._outputs = {one["name"]: one["index"] for one in outputs}

    def run(self, seen: Float32Array, *names: str) -> list[Float32Array]:
        """The outputs of these names for a picture (H, W, 3)."""
        self._interpreter.set_tensor(self._input, seen[None])
        self._interpreter.invoke()
        return [self._interpreter.get_tensor(self._outputs[name])[0] for name in names]


@contextmanager
def _without_messages() -> Iterator[None]:
    """Keep LiteRT from telling on the terminal how it runs; it has no setting for that."""
    try:
        kept = os.dup(2)
    except OSError:  # a program without a terminal
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(nowhere)
        os.close(kept)
