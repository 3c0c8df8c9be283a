"""Silhouettes of a person in mono views: where a picture differs from that of the empty scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.depth.light import EmptyScene, empty_scene
from stereotrack_core.depth.outline import outline_without_depth
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import Rectification, depth_rectification
from stereotrack_core.depth.sources import grey
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameSet, ViewImages

_LARGEST_SHARE = 0.5
"""Largest share of a picture that a person covers."""

Background: TypeAlias = Callable[[str], tuple[ImageArray | None, ImageArray] | None]
"""Gives a view's empty scene as (None, image) for a mono view, or None where there is none."""


class MonoSilhouettes:
    """Silhouettes of the mono views of a recording that state a picture of the empty scene.

    Parameters
    ----------
    views : sequence of str
        Names of mono views; those without a picture of the empty scene give nothing.
    """

    def __init__(
        self, recording: Recording, parameters: DepthParameters, views: Sequence[str]
    ) -> None:
        wanted = parameters.silhouettes and parameters.background_empty_scene
        self._views = {
            name: depth_rectification(recording.reference_camera(recording.view(name)))
            for name in (views if wanted else ())
            if recording.view(name).image.background is not None
        }
        self._empty: dict[str, EmptyScene] = {}
        self._unknown: dict[str, tuple[Float32Array, BoolArray]] = {}

    def __bool__(self) -> bool:
        return bool(self._views)

    def learn(self, background: Background) -> None:
        """Take the pictures of the empty scene, by the view's name; what it raises is passed on."""
        for name, rectification in self._views.items():
            found = background(name)
            if found is not None:
                empty = _undistorted(rectification, found[1])
                self._empty[name] = empty_scene(empty)
                nowhere = np.full(empty.shape, np.nan, dtype=np.float32)
                self._unknown[name] = nowhere, np.zeros(empty.shape, dtype=np.bool_)

    def of(self, frame_set: FrameSet) -> tuple[Mapping[str, ViewDepth], Mapping[str, str]]:
        """The views of an instant, by name: their outlines, without any range; and problems.

        A view without a picture is absent. So is one that has changed nearly everywhere, for which
        a sentence says so.
        """
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
        return ViewDepth(rectification.geometry, None, nowhere, nothing, None, outline)


def _undistorted(rectification: Rectification, image: ImageArray) -> ImageArray:
    return np.ascontiguousarray(rectification.rectified(grey(image)))
