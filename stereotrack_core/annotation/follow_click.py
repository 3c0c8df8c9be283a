"""Follow a click through the pictures of a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import cv2
import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.follow import Followed, FollowSettings, follow_patch
from stereotrack_core.arrays import ImageArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.reader import FrameReader


@dataclass(frozen=True, eq=False)
class FollowedClick:
    """A click followed through a recording.

    Attributes
    ----------
    click : Click
    frame : (F,) int64
        Frames of the rows, descending where it was followed backward.
    followed : Followed
    """

    click: Click
    frame: IntArray
    followed: Followed

    def words(self) -> str:
        """``left elbow in N_right: followed to frame 231; then it leaves the image``."""
        last = int(self.frame[self.followed.reliable_until - 1])
        what = f"{self.click.landmark.replace('_', ' ')} in {self.click.camera}"
        return f"{what}: followed to frame {last}; stopped because {self.followed.reason}"


def follow_click(
    reader: FrameReader,
    click: Click,
    *,
    backwards: bool = False,
    settings: FollowSettings | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> FollowedClick:
    """Follow a click through the recording, forward or backward.

    A reader that was opened for the camera's view alone decodes the least.

    Raises
    ------
    InputError
        Where the camera shows no image of the recording, or the click's own picture cannot be read.
    ValueError
        Where the click has no position.
    """
    if click.position is None:
        raise ValueError("a landmark outside the image cannot be followed")
    end, step = (-1, -1) if backwards else (reader.frame_count, 1)
    frames = range(click.frame, end, step)
    pictures = pictures_of(reader, click.camera, frames)
    first = next(pictures, None)
    if first is None:
        raise InputError(
            f"the image of {click.camera} at frame {click.frame} cannot be read",
            where=reader.recording.name,
            remedy="Start from another frame.",
        )
    followed = follow_patch(
        chain([first], pictures), np.array(click.position), settings, cancelled=cancelled
    )
    return FollowedClick(click, np.array(frames[: len(followed.pixels)]), followed)


def pictures_of(
    reader: FrameReader, camera: str, frames: Iterable[int]
) -> Iterator[ImageArray | None]:
    """Grey pictures (H, W) of a camera, one by one; None for one that cannot be read.

    Raises
    ------
    InputError
        Where none of the reader's views shows this camera.
    """
    for view in reader.views:
        if view.image.camera == camera or (view.left is not None and view.left.camera == camera):
            break
    else:
        raise InputError(
            f"no stream of the recording uses the camera {camera!r}",
            where=reader.recording.name,
            remedy="Choose a camera of one of the views.",
        )
    for frame in frames:
        images = reader.frame_set(frame).views.get(view.name)
        picture = None
        if images is not None:
            picture = images.image if view.image.camera == camera else images.left
        if picture is not None and picture.ndim == 3:
            picture = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        yield picture
