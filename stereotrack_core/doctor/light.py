"""Is a background image its view's own, is the light as it was, and does the camera stand still?

Frames are compared with the picture of the empty scene, after its light has been estimated
(:mod:`depth.light`), which the tracker follows up to a certain size.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray
from stereotrack_core.depth.light import (
    EmptyScene,
    Light,
    empty_scene,
    evened,
    light_of,
    relit,
    sensor_noise,
    shaded,
)
from stereotrack_core.depth.sources import grey
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.images import spread
from stereotrack_core.recording.importing.synchronise import reduced
from stereotrack_core.recording.reader import FrameReader, ViewImages

_SPREAD, _SUCCESSIVE = 12, 48  # frames over the whole recording, and in a row in the middle of it
_GAIN, _MOST_GAIN = 0.05, 0.4  # change of brightness that is told, and from which tracking suffers
_FLICKER, _MOST_FLICKER = 0.02, 0.15
_MOST_SHIFT = 2.0  # pixels in images 640 wide; rounding and people shift by up to 0.2
_CHANGED, _NOISES = 10.0, 5.0  # grey levels, and sigmas of the noise, that a change has


_Seen: TypeAlias = Mapping[str, float]
"""One image beside that of the empty scene: ``gain``, ``noise``, ``clipped`` and ``shadow`` (shares
of the image), ``shift`` (pixels in images 640 wide), ``blur`` (pixels, more than in the empty)."""

_MEASURES = (
    (
        "noise", 1.0, 4.0, 12.0,
        "the images have noise of {:.0f} grey levels",
        "Use more light, a wider aperture or less gain. The tracker filters the images, at the "
        "cost of fine texture.",
    ),
    (
        "clipped", 100.0, 10.0, 40.0,
        "{:.0f} % of the image are black or white, and were not in the empty scene",
        "Nothing is measured there. Change the exposure.",
    ),
    (
        "shadow", 100.0, 2.0, 15.0,
        "shadows or reflections cover {:.0f} % of the image",
        "Use light from several sides. Shadows on walls without texture are taken for the person.",
    ),
    (
        "shift", 1.0, 0.4, _MOST_SHIFT,
        "the camera has moved by {:.1f} px since the picture of the empty scene (in images 640 px "
        "wide)",
        "Calibrate again and record the empty scene again, or fix the tripod.",
    ),
    (
        "blur", 1.0, 1.2, 2.5,
        "the images are blurred by {:.1f} px against that of the empty scene",
        "Focus the lens on the person, or use a shorter exposure.",
    ),
)  # fmt: skip
"""Measures whose median is told: name, scale, least values of notes and warnings, text, remedy."""


def check_light(recording: Recording, reader: FrameReader) -> Iterator[Finding]:
    """Findings about light, flicker, shadows, noise and camera movement against empty scenes."""
    count = reader.frame_count
    some = spread(count, _SPREAD)
    first = max((count - _SUCCESSIVE) // 2, 0)
    row = range(first, min(first + _SUCCESSIVE, count))
    scenes = {}
    for view in recording.views:
        background = reader.background(view.name)
        if background is not None:
            scenes[view.name] = empty_scene(grey(background[1]))
    if not scenes:
        return
    images = {k: reader.frame_set(k).views for k in sorted({*some, *row})}
    for name, scene in scenes.items():
        seen = [_seen(scene, images[k][name]) for k in some if name in images[k]]
        row_of = [grey(images[k][name].image) for k in row if name in images[k]]
        gains = [_gain(light_of(picture, scene), scene) for picture in row_of]
        if seen:
            yield from _of_view(f"view {name}", seen)
            yield from _flicker(f"view {name}", np.array(gains))


def _seen(scene: EmptyScene, images: ViewImages) -> _Seen:
    picture = grey(images.image)
    light = light_of(picture, scene)
    shadow, changed = shaded(light), _changed(light, light.empty_small)
    new = _changed(light, evened(light))
    shift = _shift(light) * 640.0 / picture.shape[1]
    around = cv2.resize(_around(new), picture.shape[::-1], interpolation=cv2.INTER_NEAREST)
    return {
        "gain": _gain(light, scene),
        "noise": sensor_noise(picture),
        "clipped": max(_clipped(picture) - _clipped(scene.picture), 0.0),
        "shadow": float(np.mean(shadow & changed)),
        "shift": shift,
        "blur": relit(picture, scene, light, around == 0).blur if shift < _MOST_SHIFT else 0.0,
    }


def _of_view(where: str, seen: Sequence[_Seen]) -> Iterator[Finding]:
    """Findings about one view, by images spread over the recording."""
    gains = np.array([one["gain"] for one in seen])
    gain, swing = float(np.median(gains)), float(np.ptp(gains)) / 2.0
    lock = "Lock exposure, gain and white balance, and record the empty scene in the same light."
    if abs(gain - 1.0) > _GAIN or swing > _GAIN:
        darker = "darker" if gain < 1.0 else "brighter"
        words = f"the images are {100 * abs(gain - 1):.0f} % {darker} than that of the empty scene"
        if swing > _GAIN:
            words += f", and change by {100 * swing:.0f} % while recording"
        yield _finding(max(abs(np.log(gain)), swing) > _MOST_GAIN, where, words, lock)
    for name, scale, note, warning, text, remedy in _MEASURES:
        value = scale * float(np.median([one[name] for one in seen]))
        if value > note:
            yield _finding(value > warning, where, text.format(value), remedy)
    first, last = (np.median([one["shift"] for one in part]) for part in (seen[:3], seen[-3:]))
    if last - first > _MOST_SHIFT:
        words = f"the camera was moved while recording, by {last - first:.1f} px"
        remedy = "Leave the view out from then on, or calibrate the frames after it on their own."
        yield _finding(True, where, words, remedy)


def _flicker(where: str, gains: FloatArray) -> Iterator[Finding]:
    if len(gains) < _SUCCESSIVE // 2:
        return
    fast = gains[1:-1] - (gains[:-2] + gains[2:]) / 2.0
    # of irregular flicker, that is sqrt(1.5) of its deviation; of the fastest, twice that
    amplitude = float(np.sqrt(2.0) * np.std(fast)) / float(np.sqrt(1.5) * np.median(gains))
    if amplitude < _FLICKER:
        return
    yield _finding(
        amplitude > _MOST_FLICKER,
        where,
        f"the light flickers by {100 * amplitude:.0f} % from frame to frame",
        "Use an exposure time that is a multiple of 1/100 s (50 Hz mains) or 1/120 s (60 Hz), or "
        "lamps that do not flicker.",
    )


def _finding(grave: bool, where: str, what: str, remedy: str) -> Finding:
    return Finding("warning" if grave else "note", where, what, remedy)


def _gain(light: Light, scene: EmptyScene) -> float:
    """Brightness over that of the empty scene, median over the image."""
    return float(np.median((light.small + 1.0) / (scene.small + 1.0)))


def _clipped(picture: ImageArray) -> float:
    few = picture[::4, ::4]
    return float(np.mean((few <= 1) | (few >= 254)))


def _changed(light: Light, empty: Float32Array) -> BoolArray:
    """Where (h, w) a shrunken image is not the empty scene's (h, w)."""
    return np.asarray(np.abs(light.small - empty) > max(_CHANGED, _NOISES * light.noise))


def _around(changed: BoolArray) -> ImageArray:
    """Changed pixels (h, w), widened by 16 pixels of the image, as 1."""
    kernel = np.ones((9, 9), np.uint8)
    return np.asarray(cv2.dilate(changed.astype(np.uint8), kernel), dtype=np.uint8)


def _shift(light: Light) -> float:
    """Pixels of the image by which the camera has moved, by the phases of both pictures."""
    around = _around(_changed(light, light.empty_small)) > 0
    now = np.where(around, light.empty_small, light.small)
    window = cv2.createHanningWindow((now.shape[1], now.shape[0]), cv2.CV_32F)
    # OpenCV multiplies its inputs with the window in place
    (dx, dy), _ = cv2.phaseCorrelate(light.empty_small.copy(), now.astype(np.float32), window)
    return float(np.hypot(dx, dy)) * 4.0


_FRAMES = 4
_FOREIGN = 40.0  # median difference in grey levels to a picture of another scene
_OTHER, _LEAST_BETTER = 0.6, 2.0
"""Share of the difference to a view's own background, and grey levels, by which that of another
view has to fit better."""


def check_pictures(
    recording: Recording, reader: FrameReader, frames: int = _FRAMES
) -> Iterator[Finding]:
    """Findings about views whose background image is another's, or of another scene."""
    sets = [reader.frame_set(k) for k in spread(reader.frame_count, frames)]
    shown: dict[str, list[FloatArray]] = {}
    empty: dict[str, FloatArray] = {}
    for view in recording.views:
        seen = [s.views[view.name] for s in sets if view.name in s.views]
        background = reader.background(view.name)
        if background is not None and seen:
            shown[view.name] = [reduced(one.image) for one in seen]
            empty[view.name] = reduced(background[1])
    yield from check_backgrounds(shown, empty)


def check_backgrounds(
    shown: Mapping[str, Sequence[FloatArray]], empty: Mapping[str, FloatArray]
) -> Iterator[Finding]:
    """Backgrounds of another view, or of no view, by reduced images and backgrounds (H, W)."""
    for view, other in permutations(shown, 2):
        own = _apart(shown[view], empty[view])
        same = float(np.abs(empty[view] - empty[other]).mean()) < 1.0
        rival = _apart(shown[other], empty[view]) if same else _apart(shown[view], empty[other])
        if own - rival > _LEAST_BETTER and rival < _OTHER * own:
            yield Finding(
                "error",
                f"view {view}, background",
                f"it is that of view {other}: it differs by {own:.0f} grey levels from the images "
                f"of view {view}, and by {rival:.0f} from those of view {other}"
                if same
                else f"that of view {other} fits the images better: they differ by {own:.0f} grey "
                f"levels from the view's own background, and by {rival:.0f} from the other one",
                "Use an image of the empty scene by this very camera.",
            )
            return
    for view, images in shown.items():
        if _apart(images, empty[view]) > _FOREIGN:
            what = "the background image does not match the scene of the images"
            remedy = "Take it with this camera, from the same position and with the same exposure."
            yield Finding("warning", f"view {view}, background", what, remedy)


def _apart(images: Sequence[FloatArray], background: FloatArray) -> float:
    """Difference in grey levels of most pixels, which the person does not cover."""
    return float(np.median([np.median(np.abs(image - background)) for image in images]))
