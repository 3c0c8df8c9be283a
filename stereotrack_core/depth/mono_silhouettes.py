"""Silhouettes of a person in mono views: where a picture differs from that of the empty scene."""

from collections.abc import Iterable, Mapping, Sequence, Set

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.depth.light import EmptyScene, empty_scene
from stereotrack_core.depth.outline import outline_without_depth
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import Rectification, depth_rectification
from stereotrack_core.depth.sources import grey
from stereotrack_core.pose_model.detect import Whereabouts, detect_person, whereabouts
from stereotrack_core.pose_model.detector import PoseDetector, load_detector, next_crop
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.person_boxes import person_boxes
from stereotrack_core.recording.reader import FrameReader, FrameSet, ViewImages

_LARGEST_SHARE = 0.5  # largest share of a picture that a person covers
_FRAMES = 16  # frames from which the empty scene is made where no picture of it is stated


def silhouette_views(
    recording: Recording, views: Sequence[str], *, detector: bool
) -> tuple[str, ...]:
    """Mono views that can have silhouettes; without a detector, those with a stated empty scene."""
    mono = [recording.view(name) for name in views if recording.view(name).kind == "mono"]
    return tuple(view.name for view in mono if detector or view.image.background is not None)


class MonoSilhouettes:
    """Silhouettes of the mono views of a recording.

    A view without a stated picture of the empty scene needs the installed pose detector, which
    tells the scene from the person in some frames; without it the view gives nothing. `made` are
    the views whose empty scene was made so.
    """

    def __init__(
        self, recording: Recording, parameters: DepthParameters, views: Sequence[str]
    ) -> None:
        wanted = parameters.silhouettes and parameters.background_empty_scene
        stated = silhouette_views(recording, views, detector=False)
        self.made: tuple[str, ...] = ()
        self._recording = recording
        self._detector = load_detector() if wanted and len(stated) < len(views) else None
        self._views = {
            name: depth_rectification(recording.reference_camera(recording.view(name)))
            for name in (views if self._detector else stated if wanted else ())
        }
        self._empty: dict[str, EmptyScene] = {}
        self._unknown: dict[str, tuple[Float32Array, BoolArray]] = {}

    def __bool__(self) -> bool:
        return bool(self._views)

    def learn(self, pictures: FrameReader, frames: range) -> None:
        """Take the pictures of the empty scene, or make them from some of the frames."""
        stated = {name: pictures.background(name) for name in self._views}
        empty = {n: _undistorted(self._views[n], one[1]) for n, one in stated.items() if one}
        if self._detector is not None and len(empty) < len(stated):
            made = self._scenes(self._detector, stated.keys() - empty.keys(), pictures, frames)
            empty, self.made = empty | made, tuple(made)
        for name, picture in empty.items():
            self._empty[name] = empty_scene(picture)
            nowhere = np.full(picture.shape, np.nan, dtype=np.float32)
            self._unknown[name] = nowhere, np.zeros(picture.shape, dtype=np.bool_)

    def _scenes(
        self, detector: PoseDetector, names: Set[str], pictures: FrameReader, frames: range
    ) -> dict[str, ImageArray]:
        """Pictures of the empty scene, without those views that show hardly anybody."""
        shown: dict[str, list[ImageArray]] = {name: [] for name in self._views if name in names}
        for k in np.linspace(frames[0], frames[-1], _FRAMES).astype(int).tolist():
            seen = pictures.frame_set(k).views
            for name in shown.keys() & seen.keys():
                shown[name].append(_undistorted(self._views[name], seen[name].image))
        boxes = person_boxes(self._recording)
        plates = {}
        for name, some in shown.items():
            where = whereabouts(self._recording, self._recording.view(name), boxes.get(name))
            plates[name] = clean_plate(detector, some, where)
        return {name: plate for name, plate in plates.items() if plate is not None}

    def of(self, frame_set: FrameSet) -> tuple[Mapping[str, ViewDepth], Mapping[str, str]]:
        """Outlines of an instant's views by name, without ranges; and problems as sentences."""
        found: dict[str, ViewDepth] = {}
        problems = {n: text for n, text in frame_set.problems.items() if n in self._empty}
        for name in self._empty:
            images = frame_set.views.get(name)
            if images is None:
                continue
            seen = self._seen(name, images)
            if seen is None:
                problems[name] = (
                    f"View {name} provides no silhouette: more than half of its image differs "
                    "from the picture of the empty scene."
                )
            else:
                found[name] = seen
        return found, problems

    def _seen(self, name: str, images: ViewImages) -> ViewDepth | None:
        rectification = self._views[name]
        picture = _undistorted(rectification, images.image)
        nowhere, nothing = self._unknown[name]  # the same for all frames, which may be many
        outline = outline_without_depth(picture, self._empty[name])
        if outline is None:
            return None
        if rectification.image_map is not None:
            outline &= ~rectification.image_map.outside
        if outline.mean() > _LARGEST_SHARE:
            return None
        return ViewDepth(rectification.geometry, nowhere, nothing, None, outline)


def _undistorted(rectification: Rectification, image: ImageArray) -> ImageArray:
    return np.ascontiguousarray(rectification.rectified(grey(image)))


_PERSON = 0.5  # probability of the network from which a pixel shows the person
# Pixels around the person that are left out too. With 8, places beside a person who hardly moves
# have to be filled: silhouettes of a mesh overlap with the true ones by 0.68, with 2 by 0.9.
_BESIDE = 2
_FEWEST = 5  # pictures with the person without which the scene is not known
_FILLED = 5.0  # pixels from which a place that is always covered is filled


def clean_plate(
    detector: PoseDetector, pictures: Iterable[ImageArray], where: Whereabouts
) -> ImageArray | None:
    """What pictures (H, W) show without the person; None where few of them show a person.

    The median of the pictures in which the network sees no person at a pixel. What the person
    always covers is filled from its surroundings, from which the clothes mostly differ.
    """
    shown, hidden, pose = [], [], None
    around = np.ones((2 * _BESIDE + 1, 2 * _BESIDE + 1), dtype=np.uint8)
    for picture in pictures:
        pose = detect_person(detector, picture, pose, where)
        if pose is not None:
            mask = detector.landmarks(picture, next_crop(pose), mask=True).mask
            assert mask is not None  # noqa: S101 - it was asked for
            shown.append(picture)
            hidden.append(cv2.dilate((mask > _PERSON).astype(np.uint8), around) > 0)
    if len(shown) < _FEWEST:
        return None
    covered = np.stack(hidden)
    values = np.sort(np.where(covered, np.int16(256), np.stack(shown)), axis=0)  # covered ones last
    always = np.asarray(covered.all(axis=0), dtype=np.uint8)
    middle = (~covered).sum(axis=0, keepdims=True) // 2
    plate = np.take_along_axis(values, middle, axis=0).reshape(always.shape).astype(np.uint8)
    return np.asarray(cv2.inpaint(plate, always, _FILLED, cv2.INPAINT_TELEA), dtype=np.uint8)
