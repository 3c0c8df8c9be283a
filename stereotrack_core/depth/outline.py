"""The person's outline: where a picture differs from the empty scene in the same light."""

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.depth.light import EmptyScene, Relit, light_of, relit
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.sources import StereoFrame

_HALO_CONTRAST = 6  # grey levels by which a person differs from the background image

_NEAR = 7  # neighbourhood whose strongest difference says what half of a difference is
_SHARE, _LEAST = 0.4, 10.0  # share of the strongest difference nearby, and grey levels, if new
_AROUND = (31, 31)  # pixels over which the pictures of a pair are brought to one brightness
_WINDOW = (5, 5)  # neighbourhood, pixels, in which structure is compared
_SAME = 4.0  # grey levels by which both pictures of a pair may show the same place differently
_NOISES = 4.0  # standard deviations of the measured noise that a pixel must differ by, at least
_INSIDE = 9  # side, pixels, of the neighbourhood that is surely inside, or surely beside the person
_CLOSED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
_OPENED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
_SMALL_HOLE = 60  # pixels of a hole that is taken for a place where the person looks like the wall


def difference_of(picture: ImageArray, empty: ImageArray) -> ImageArray:
    """Differences (H, W) in grey levels of two pictures, after a blur of 3 x 3 pixels."""
    blurred = (cv2.GaussianBlur(one, (3, 3), 0) for one in (picture, empty))
    return np.asarray(cv2.absdiff(*blurred), dtype=np.uint8)


def sharp_outline(
    difference: ImageArray,
    foreground: BoolArray,
    noise: float = 0.0,
    behind: BoolArray | None = None,
) -> BoolArray:
    """Where a picture is not the empty scene's (H, W), with edges at half their height.

    `difference` is :func:`difference_of` both. Lenses blur: with a fixed threshold strong edges
    would lie a pixel or two too far outside. `foreground`, by disparities, counts well inside its
    edge, as block matching widens it by up to half its window.

    A strongest difference looked for farther away in blurred pictures was tried: arms join with
    what is beside them, and 24 % of them were lost instead of 1 % (mesh-P4, `fast`, blur of 2 px).
    """
    least = max(_LEAST, _NOISES * noise)
    near, inside = (np.ones((side, side), np.uint8) for side in (_NEAR, _INSIDE))
    limits = np.arange(256, dtype=np.float32) * _SHARE  # whole levels are compared
    limits = np.maximum(limits, least).clip(max=255).astype(np.uint8)
    limit = cv2.LUT(cv2.dilate(difference, near), limits)
    new = (difference > limit).astype(np.uint8)
    if behind is not None:
        new[behind] = 0
    new |= np.asarray(cv2.erode(foreground.astype(np.uint8), inside), dtype=np.uint8)
    closed = cv2.morphologyEx(new, cv2.MORPH_CLOSE, _CLOSED)
    cv2.filterSpeckles(closed, 1, _SMALL_HOLE - 1, 0)  # whatever is 0 and small becomes 1
    return cv2.morphologyEx(closed, cv2.MORPH_OPEN, _OPENED).astype(bool)


# Grey levels of noise in the difference to the empty scene from which most of a picture has
# changed: a dark room has 4 after the blur.
_UNLIKE = 8.0


def outline_without_depth(picture: ImageArray, scene: EmptyScene) -> BoolArray | None:
    """Where a picture (H, W) is not the empty scene's, in any light; None if most has changed."""
    light, nothing = light_of(picture, scene), np.zeros(picture.shape, dtype=bool)
    empty = relit(picture, scene, light, ~nothing)
    first = sharp_outline(difference_of(picture, empty.picture), nothing, empty.noise)
    empty = relit(picture, scene, light, beside(first))
    if empty.noise > _UNLIKE:
        return None
    return sharp_outline(difference_of(picture, empty.picture), nothing, empty.noise)


def seen_at(frame: StereoFrame, disparity: Float32Array, region: Region) -> BoolArray:
    """Where (h, w) both pictures of a pair show one surface at these disparities of a region.

    A shadow, a reflection or a lamp changes grey values, and not where a surface is. The matcher
    alone does not tell: its window gives a thin limb the disparity of the pattern beside it. After
    Ivanov, Bobick and Liu (doi:10.1023/A:1008107805263), who warp one picture into the other.
    """
    there, here = frame.left_at(disparity, region), frame.picture[region.slices]
    apart = _apart_but_for_gain(here, there, _AROUND)  # cameras and lenses differ in brightness
    noise = 1.4826 * float(np.median(apart[::3, ::3]))
    return np.asarray(apart < max(_SAME, _NOISES * noise))


def new_pixels(difference: ImageArray, noise: float) -> BoolArray:
    """Where (h, w) a picture clearly differs from the empty scene in its light."""
    return np.asarray(difference > max(_LEAST, _NOISES * noise))


def beside(foreground: BoolArray) -> BoolArray:
    """Where (h, w) no foreground is near."""
    near = cv2.dilate(foreground.astype(np.uint8), np.ones((_INSIDE,) * 2, np.uint8))
    return np.asarray(near == 0)


def same_structure(now: ImageArray, before: ImageArray, noise: float) -> BoolArray:
    """Where (h, w) a picture is the empty scene's but for a gain: in shadows and reflections."""
    return np.asarray(_apart_but_for_gain(now, before, _WINDOW) < max(_SAME, 2 * noise))


def _apart_but_for_gain(
    one: ImageArray, other: ImageArray, neighbourhood: tuple[int, int]
) -> Float32Array:
    """Mean difference (h, w) around each pixel after the gain between two neighbourhoods."""
    a, b = (cv2.blur(image, (3, 3)).astype(np.float32) for image in (one, other))
    gain = (cv2.blur(a, neighbourhood) + 1) / (cv2.blur(b, neighbourhood) + 1)
    return np.asarray(cv2.blur(np.abs(a - gain * b), _WINDOW).astype(np.float32, copy=False))


@dataclass(frozen=True, eq=False)
class Compared:
    """A region of a picture beside the empty scene in the same light."""

    picture: ImageArray
    before: ImageArray
    difference: ImageArray  # :func:`difference_of` both
    empty: Relit
    window: int  # Pixels. Side of the matcher's window.
    behind: BoolArray  # (h, w). At the empty scene's disparity, in whatever light

    def changed(self) -> BoolArray:
        """Where the picture differs, with gaps closed over the matcher's window."""
        difference = cv2.absdiff(
            cv2.GaussianBlur(self.picture, (5, 5), 0), cv2.GaussianBlur(self.before, (5, 5), 0)
        )
        limit = max(_HALO_CONTRAST, 3.0 * self.empty.noise)
        differs = ((difference > limit) & ~self.behind).astype(np.uint8)
        size = (self.window // 2) | 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        closed = cv2.morphologyEx(differs, cv2.MORPH_CLOSE, kernel)
        return closed.astype(bool)

    def outline(self, foreground: BoolArray) -> BoolArray:
        """The person's sharp outline."""
        return sharp_outline(self.difference, foreground, self.empty.noise, self.behind)
