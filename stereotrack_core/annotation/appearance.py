"""Clicks whose image patch is another one than around the clicks before and after.

What is around a click is followed through the images to the next clicked frame, from both sides. A
click is doubted if both come to the same other place, unless the other views say that it is right.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey
from stereotrack_core.annotation.doubts import Doubt, angle_of_residual
from stereotrack_core.annotation.follow import MOST_FRAMES, follow_points, pictures_of
from stereotrack_core.annotation.predict import pixel_scale, predicted_point
from stereotrack_core.arrays import FloatArray
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.work import NO_WORK, Work

_OFF = 10.0  # pixels at 480 lines by which a click has to miss what was followed
_SURE = 4.0  # standard deviations, likewise
_AGREES = 2.5  # usual sigmas within which the other views say that a click is right
_OUTLIER = 0.7  # how probably a doubted click is wrong: mesh-P2, two views besides, 6 % wrong
_Ends = dict[ClickKey, list[FloatArray | None]]
"""Where clicks before and after were followed to, (2,) pixels; None where the click is right."""


def unlike_the_others(
    recording: Recording, clicks: Iterable[Click], work: Work = NO_WORK
) -> dict[ClickKey, Doubt]:
    """Clicks in the views' reference images that show something else than those around them.

    Raises Cancelled; InputError for a recording that cannot be read.
    """
    placed = [click for click in clicks if click.position is not None and not click.deleted]
    ends: _Ends = defaultdict(list)
    for count, view in enumerate(recording.views):
        here = [click for click in placed if click.camera == view.image.camera]
        with FrameReader(recording, views=[view.name], colour=False) as reader:
            part = work.part(count / len(recording.views), (count + 1) / len(recording.views))
            _follow(reader, view.image.camera, here, ends, part)
    near: dict[tuple[int, str], list[Click]] = defaultdict(list)
    for click in placed:
        near[click.frame, click.landmark].append(click)
    doubts = {}
    for key, both in ends.items():
        places = [place for place in both if place is not None]
        own, camera = near[key.frame, key.landmark], recording.cameras[key.camera]
        if len(places) < 2 or _fits(key, own, recording.cameras):
            continue
        (click,) = (one for one in own if one.camera == key.camera)
        off = float(np.linalg.norm(np.mean(places, axis=0) - np.array(click.position)))
        apart = float(np.linalg.norm(places[1] - places[0]))
        if apart < min(_OFF * pixel_scale(camera), 0.5 * off):
            words = f"the clicks before and after lead to another place, {off:.0f} px away"
            doubts[key] = Doubt(_OUTLIER, angle_of_residual(off, camera), words, "appearance")
    return doubts


def _follow(
    reader: FrameReader, camera: str, clicks: Sequence[Click], ends: _Ends, work: Work
) -> None:
    """Note for each click where what is followed from its neighbours comes to."""
    by_frame: dict[int, dict[str, Click]] = defaultdict(dict)
    for click in clicks:
        by_frame[click.frame][click.landmark] = click
    scale = pixel_scale(reader.recording.cameras[camera])
    frames = sorted(by_frame)
    for place, (first, last) in enumerate(pairwise(frames)):
        work.step(place / len(frames), f"frame {first}")
        names = [name for name in by_frame[first] if name in by_frame[last]]
        if not names or last - first > MOST_FRAMES:
            continue
        pictures = list(pictures_of(reader, camera, range(first, last + 1)))
        if any(picture is None for picture in pictures):
            continue
        for start, end, way in ((first, last, pictures), (last, first, pictures[::-1])):
            begun = np.array([by_frame[start][name].position for name in names])
            *_, (pixels, spreads) = follow_points(way, begun, cancelled=work.stopped)
            for name, pixel, spread in zip(names, pixels, spreads, strict=True):
                click = by_frame[end][name]
                if np.isfinite(spread):
                    off = float(np.linalg.norm(pixel - np.array(click.position)))
                    far = off > max(_OFF * scale, _SURE * spread)
                    ends[click.key].append(pixel if far else None)


def _fits(key: ClickKey, clicks: Sequence[Click], cameras: Cameras) -> bool:
    """Whether a click lies where two other views or more say that the landmark is."""
    own = next(click for click in clicks if click.camera == key.camera)
    point = predicted_point(cameras, [one for one in clicks if one is not own])
    if point is None or point.outliers or key.camera not in point.pixel:
        return False
    off = float(np.linalg.norm(point.pixel[key.camera] - np.array(own.position)))
    return off < _AGREES * USUAL_SIGMA * pixel_scale(cameras[key.camera])
