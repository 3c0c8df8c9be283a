"""Checks of the images themselves; decodes all of them."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import stretches_of
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader, ViewImages

_DARK_SHARE = 0.35  # of what is usual in the view
_DARK_LEVEL = 40.0  # grey value that 98 % of a dark image do not reach; empty borders do not count
_BRIGHT_LEVEL = 250.0  # mean grey value of an image that shows nothing any more
_FROZEN_FRAMES = 5
_GAIN_RATIO = 1.2
STEP = 4  # only every so many pixels in each direction are looked at


@dataclass
class _Watched:
    """Measurements of one stream over the frames."""

    frames: list[int] = field(default_factory=list)
    brightness: list[float] = field(default_factory=list)
    highlights: list[float] = field(default_factory=list)
    repeated: list[bool] = field(default_factory=list)
    depth_share: list[float] = field(default_factory=list)
    last: NDArray[Any] | None = None

    def add(self, k: int, image: NDArray[Any]) -> None:
        small = image[::STEP, ::STEP]
        same = self.last is not None and np.array_equal(small, self.last)
        self.frames.append(k)
        self.brightness.append(float(small.mean()))
        self.highlights.append(float(np.percentile(small, 98)))
        self.repeated.append(bool(same))
        self.last = small.copy()


def check_images(recording: Recording) -> Iterator[Finding]:
    """Damaged frames, dark or frozen stretches, and stretches without depth."""
    watched: dict[tuple[str, str], _Watched] = {}
    problems: dict[str, list[str]] = {}
    with FrameReader(recording, colour=False, cache_bytes=64 * 1024 * 1024) as reader:
        for k in range(reader.frame_count):
            frame_set = reader.frame_set(k)
            for view, problem in frame_set.problems.items():
                problems.setdefault(view, []).append(problem)
            for view, images in frame_set.views.items():
                _watch(watched, view, images, k)
    for view, sentences in problems.items():
        first = sentences[0].rstrip(".")
        what = f"{len(sentences)} frames cannot be decoded; the first: {first}"
        otherwise = "Otherwise the view has no image in these frames."
        remedy = f"Copy the file again from the source. {otherwise}"
        yield Finding("error", f"view {view}", what, remedy)
    for (view, key), one in watched.items():
        yield from _check_darkness(f"view {view}, {key}", one)
    yield from _check_frozen(watched)
    yield from _check_gain(watched)
    for (view, _), one in watched.items():
        share = np.array(one.depth_share)
        for part in stretches_of(share == 0) if share.size == len(one.frames) else ():
            what = f"there is no depth from frame {one.frames[part[0]]} to {one.frames[part[-1]]}"
            remedy = "Check the depth files: 0 means no value."
            yield Finding("warning", f"view {view}, depth", what, remedy)


def _watch(watched: dict[tuple[str, str], _Watched], view: str, images: ViewImages, k: int) -> None:
    if images.left is not None:
        watched.setdefault((view, "left"), _Watched()).add(k, images.left)
    key = "image" if images.left is None else "right"
    one = watched.setdefault((view, key), _Watched())
    one.add(k, images.image)
    if images.depth is not None:
        one.depth_share.append(float(np.isfinite(images.depth[::STEP, ::STEP]).mean()))


def _check_darkness(where: str, one: _Watched) -> Iterator[Finding]:
    brightness = np.array(one.highlights)
    usual = float(np.median(brightness))
    if usual < _DARK_LEVEL:
        what = f"the images are dark (98 percent of the pixels are at most {usual:.0f} of 255)"
        remedy = "Use a longer exposure or a wider aperture. The matcher needs contrast."
        yield Finding("warning", where, what, remedy)
        return
    if np.median(one.brightness) > _BRIGHT_LEVEL:
        what = "the images are overexposed and show nothing"
        yield Finding("warning", where, what, "Use a shorter exposure or a smaller aperture.")
        return
    dark = (brightness < _DARK_SHARE * usual) & (brightness < _DARK_LEVEL)
    for part in stretches_of(dark):
        what = f"the view is dark from frame {one.frames[part[0]]} to {one.frames[part[-1]]}"
        yield Finding("warning", where, what, "Exclude these frames or this view.")


def _check_frozen(watched: dict[tuple[str, str], _Watched]) -> Iterator[Finding]:
    """Streams that repeat an image while another stream goes on (a still scene freezes all)."""
    for (view, key), one in watched.items():
        others = [w for place, w in watched.items() if place != (view, key)]
        frames = (zip(w.frames, w.repeated, strict=True) for w in others)
        moving = {k for own in frames for k, same in own if not same}
        # what is dark or white is told as such
        seen = np.array(one.highlights) >= _DARK_LEVEL
        seen &= np.array(one.brightness) <= _BRIGHT_LEVEL
        flags = np.array(one.repeated) & np.array([k in moving for k in one.frames]) & seen
        for part in stretches_of(flags):
            first, last = one.frames[part[0]], one.frames[part[-1]]
            if last - first + 1 >= _FROZEN_FRAMES:
                what = f"the image is frozen from frame {first - 1} to {last} while other views"
                remedy = "The camera dropped frames. Check whether it is late afterwards."
                yield Finding("warning", f"view {view}, {key}", f"{what} continue", remedy)


def _check_gain(watched: dict[tuple[str, str], _Watched]) -> Iterator[Finding]:
    for (view, key), left in watched.items():
        right = watched.get((view, "right"))
        if key != "left" or right is None:
            continue
        levels = [float(np.median(w.brightness)) for w in (left, right)]
        if min(levels) > 0 and max(levels) / min(levels) > _GAIN_RATIO:
            darker = "left" if levels[0] < levels[1] else "right"
            what = f"the {darker} image is darker by a factor of {max(levels) / min(levels):.2f}"
            better = "equal gain and exposure are better"
            remedy = f"The matcher's low-pass filter compensates for this, but {better}."
            yield Finding("note", f"view {view}", what, remedy)
