"""The empty scene's picture in the light of a later one.

A camera with automatic exposure, a cloud, a lamp or a shadow changes grey values where nothing
has moved. Before a picture is compared with that of the empty scene, the latter is brought into
its light: a tone curve (exposure, gamma, offset), a gain that varies over the image (shade, soft
shadows), a shift (a camera that was touched) and a blur (focus, compression). All are medians or
robust means over many pixels, so that a person who covers a fifth of the image changes none.
"""

import math
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray, IntArray

SHRINK = 4  # pixels of the image, each way, to one of the picture in which light is estimated
_BINS = 12  # points of the tone curve; each is the median of as many pixels
_POWERS = (0.4, 2.5)  # least and largest gamma that a tone curve is continued with
_HELD = 0.05  # weight of a gamma of 1, against the variance of the medians' logarithms
_GAIN_SCALE = 0.15  # deviation of a log gain from the plane that weighs a quarter
_NEIGHBOURHOODS = (25, 13, 9)  # shrunken pixels around one whose gain is taken for its own
_FEW = np.float32(0.02)  # share of the surroundings below which the plane's gain is taken instead
_WINDOW = (5, 5)
_LEAST_CORRELATION = 0.6  # of picture and empty scene, in a window that shows the same
_SHADE, _SHADED = 4.0, 0.02  # grey levels, and share of the background, for a local gain
_FLAT = 0.1  # largest deviation of a log gain where no structure tells light from things
_QUIET = 2.0  # grey levels of noise up to which picture and empty scene agree as they are
_LARGEST_SHIFT = 3.0  # pixels; a camera that has moved farther needs a new calibration
_LEAST_SHIFT = 0.15  # pixels that are not worth a resampling
_BLURS = (0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0)  # pixels, tried on the empty scene
_SHARP = 0.9  # share of the empty scene's slopes from which a picture is as sharp
_GREY = 20.0  # grey levels of a difference that loses half of its weight when a shift is estimated
_RUN = 32  # pixels of a row over which noise is averaged
_QUIETEST = 0.1  # quantile of these averages that has no texture to speak of
_LEAST_NOISE = 0.5  # grey levels of rounding that remain without any noise


@dataclass(frozen=True, eq=False)
class EmptyScene:
    """Picture (H, W) of the empty scene, with what its comparison needs of it each time."""

    picture: ImageArray
    small: ImageArray  # (h, w). Shrunken picture.
    order: IntArray  # (n,). Every second pixel of every second row of it, from dark to light.
    levels: FloatArray  # (bins,). Median grey level of each bin of them.


def empty_scene(picture: ImageArray) -> EmptyScene:
    """Prepare a picture (H, W) of the empty scene for comparisons."""
    small = shrunken(picture)
    few = small[::2, ::2].ravel()
    order = np.argsort(few, kind="stable")
    return EmptyScene(picture, small, order, _medians(few[order]))


def shrunken(picture: ImageArray) -> ImageArray:
    """The picture at a quarter of its size."""
    size = (picture.shape[1] // SHRINK, picture.shape[0] // SHRINK)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def sensor_noise(picture: ImageArray) -> float:
    """Standard deviation of a picture's (H, W) noise in grey levels, where it is quietest.

    Noise is everywhere and texture is not: second differences along short stretches of rows are at
    least those of the noise. Clipped stretches are left out.
    """
    runs = picture[4::12, : picture.shape[1] // _RUN * _RUN].reshape(-1, _RUN).T.astype(np.int16)
    runs = runs[:, (runs.min(axis=0) > 0) & (runs.max(axis=0) < 255)]
    if runs.shape[1] < _RUN:
        return 0.0
    second = np.abs(runs[:-2] + runs[2:] - 2 * runs[1:-1]).sum(axis=0)
    quiet = np.partition(second, rank := int(_QUIETEST * len(second)))[rank] / (_RUN - 2)
    # |n1 - 2 n2 + n3| of normal noise is sqrt(6) * 0.798 sigma on average.
    return float(quiet) / (math.sqrt(6.0) * 0.798)


@dataclass(frozen=True, eq=False)
class Light:
    """Light of one picture against that of the empty scene."""

    curve: Float32Array  # (256,). Grey level now of each grey level of the empty scene, at gain 1.
    log_gain: Float32Array  # (h, w). Logarithm of the gain that comes to it, on the shrunken image.
    small: Float32Array  # (h, w). Shrunken picture.
    empty_small: Float32Array  # (h, w). Shrunken empty scene in this light.
    noise: float  # Grey levels. Standard deviation of the difference of the shrunken pictures.


def light_of(picture: ImageArray, scene: EmptyScene) -> Light:
    """Estimate exposure, gamma and a plane of gain for the whole picture (H, W)."""
    small = shrunken(picture)
    curve = _tone_curve(scene.levels, _medians(small[::2, ::2].ravel()[scene.order]))
    now = small.astype(np.float32)
    toned = cv2.LUT(scene.small, curve).astype(np.float32, copy=False)
    plane = _robust_plane(_log_ratio(now[3::6, 3::6], toned[3::6, 3::6]), toned.shape)
    lit = toned * np.exp(plane)
    return Light(curve, plane, now, lit, _spread(now[::3, ::3] - lit[::3, ::3]))


@dataclass(frozen=True, eq=False)
class Relit:
    """The empty scene in the light of a picture."""

    picture: ImageArray  # (h, w)
    noise: float  # grey levels, of the difference of a pixel after a 3 x 3 blur
    blur: float  # pixels of blur that the picture has more than the empty scene


def evened(light: Light) -> Float32Array:
    """The shrunken empty scene (h, w) in the light that is measured around each pixel."""
    everywhere = np.ones(light.small.shape, dtype=bool)
    return light.empty_small * np.exp(_local_gain(light, everywhere))


def shaded(light: Light) -> BoolArray:
    """Where (h, w) a shrunken picture shows the empty scene's structure, but darker or brighter."""
    ratio = cv2.blur(_log_ratio(light.small, light.empty_small), _WINDOW)
    alike, _ = _alike(light)
    return np.asarray(alike & (np.abs(ratio) > _FLAT))


def relit(
    picture: ImageArray,
    scene: EmptyScene,
    light: Light,
    background: BoolArray,
    part: tuple[slice, slice] = np.s_[:, :],
) -> Relit:
    """The empty scene as it would look in a part (h, w) of the picture (H, W).

    Pixels of `background` (h, w) surely show it, and so do all beside the part: their gain is taken
    as it is, so that soft shadows are no difference.
    """
    everywhere = np.ones(picture.shape, dtype=bool)
    everywhere[part] = background
    small = light.small.shape[1], light.small.shape[0]
    known = cv2.resize(everywhere.view(np.uint8) * 255, small, interpolation=cv2.INTER_AREA) > 250
    log_gain = light.log_gain
    apart = np.abs(light.small - light.empty_small)[known]
    if np.count_nonzero(apart > _SHADE) > _SHADED * apart.size:
        log_gain = log_gain + _local_gain(light, known)
    gain = cv2.resize(np.exp(log_gain), picture.shape[::-1], interpolation=cv2.INTER_LINEAR)

    def lit(part: tuple[slice, slice]) -> ImageArray:
        toned = cv2.LUT(scene.picture[part], light.curve)
        return np.asarray(cv2.multiply(toned, gain[part], dtype=cv2.CV_8U), dtype=np.uint8)

    empty = lit(part)
    noise, blur = _noise(picture[part], empty, background), 0.0
    if noise > _QUIET:  # shift and blur are told by all of the background
        whole = lit(np.s_[:, :])
        if _noise(picture, whole, everywhere) > _QUIET:
            whole, blur = _aligned(picture, whole, everywhere)
        noise, empty = _noise(picture, whole, everywhere), whole[part]
    return Relit(empty, noise, blur)


def _noise(picture: ImageArray, empty: ImageArray, background: BoolArray) -> float:
    """Spread of the background's difference after a blur of 3 x 3 pixels."""
    a, b = (cv2.blur(one, (3, 3))[::4, ::4].astype(np.float32) for one in (picture, empty))
    return _spread((a - b)[background[::4, ::4]])


def _local_gain(light: Light, background: BoolArray) -> Float32Array:
    """Logarithmic gain (h, w) beyond the plane's, smoothed over what shows the empty scene.

    That is where both pictures' structure correlates in a small window; where the empty scene has
    none, the gain must agree with that of the surroundings.
    """
    alike, flat = _alike(light)
    ratio = np.clip(_log_ratio(light.small, light.empty_small), -1, 1)
    local = np.zeros_like(ratio)
    for neighbourhood in _NEIGHBOURHOODS:
        sure = background & np.where(flat, np.abs(ratio - local) < _FLAT, alike)
        weight = sure.astype(np.float32)
        around = (neighbourhood, neighbourhood)
        local = cv2.blur(ratio * weight, around) / (cv2.blur(weight, around) + _FEW)
    return local


def _alike(light: Light) -> tuple[BoolArray, BoolArray]:
    """Where (h, w) both pictures have the same structure, and where the empty scene has none."""
    a, b = light.small, light.empty_small

    def mean(image: Float32Array) -> Float32Array:
        return cv2.boxFilter(image, cv2.CV_32F, _WINDOW).astype(np.float32, copy=False)

    mean_a, mean_b = mean(a), mean(b)
    var_a, var_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    least = _LEAST_CORRELATION * np.sqrt(np.maximum(var_a * var_b, 0))
    flat = var_b < (3 * light.noise) ** 2
    return ~flat & (mean(a * b) - mean_a * mean_b > least), flat


def _medians(ordered: ImageArray) -> FloatArray:
    """Medians (bins,) of equal parts of some grey levels."""
    share = len(ordered) // _BINS
    parts = np.sort(ordered[: share * _BINS].reshape(_BINS, share), axis=1).astype(np.float64)
    return 0.5 * (parts[:, (share - 1) // 2] + parts[:, share // 2])


def _tone_curve(before: FloatArray, now: FloatArray) -> Float32Array:
    """Curve (256,) through medians before and now; a power law leads on beyond both ends."""
    x, y = np.maximum(before, 1.0), np.maximum(np.maximum.accumulate(now), 1.0)
    kept = np.r_[True, np.diff(x) > 0.5]
    x, y = x[kept], y[kept]
    log_x, log_y = np.log(x), np.log(y)
    middle = log_x - log_x.mean()
    known = float(middle @ middle)
    # One grey level of a wall says nothing about gamma: then exposure alone has changed.
    power = (middle @ log_y + _HELD) / (known + _HELD)
    power = min(max(float(power), _POWERS[0]), _POWERS[1])
    low, high = np.linspace(1, x[0], 8), np.linspace(x[-1], 255, 8)
    xs = np.r_[0.0, low[:-1], x, high[1:]]
    ys = np.r_[0.0, y[0] * (low[:-1] / x[0]) ** power, y, y[-1] * (high[1:] / x[-1]) ** power]
    return np.interp(np.arange(256), xs, ys).astype(np.float32)


def _log_ratio(now: Float32Array, before: Float32Array) -> Float32Array:
    return np.asarray(np.log((now + 1) / (before + 1)))


def _robust_plane(log_gain: Float32Array, shape: tuple[int, ...]) -> Float32Array:
    """Plane (h, w) through the log gains of every sixth pixel, by reweighted least squares."""
    rows, columns, a, products = _plane_basis(*shape)
    z = log_gain.astype(np.float64).ravel()
    x = np.array([np.median(z), 0.0, 0.0])
    held = np.diag([1e-9, 1.0, 1.0])  # a slope needs evidence
    for _ in range(4):
        apart = (z - x @ a) * (1 / _GAIN_SCALE)
        weight = 1 / (1 + apart * apart) ** 2
        x = np.linalg.solve((products @ weight).reshape(3, 3) + held, a @ (weight * z))
    plane: Float32Array = (x[0] + x[1] * columns + x[2] * rows).astype(np.float32)
    return plane


@cache
def _plane_basis(height: int, width: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Rows and columns from -0.5 to 0.5; terms (3, n) at every sixth; their products (9, n)."""
    rows, columns = np.arange(height) / height - 0.5, np.arange(width) / width - 0.5
    v, u = (g.ravel() for g in np.meshgrid(rows[3::6], columns[3::6], indexing="ij"))
    a = np.stack([np.ones_like(u), u, v])
    return rows[:, None], columns, a, (a[:, None] * a).reshape(9, -1)


def _spread(difference: Float32Array) -> float:
    """Robust standard deviation of differences in grey levels."""
    if not difference.size:
        return _LEAST_NOISE
    size = np.abs(difference).ravel()
    middle = np.partition(size, size.size // 2)[size.size // 2]
    return max(1.4826 * float(middle), _LEAST_NOISE)


def _aligned(
    picture: ImageArray, empty: ImageArray, background: BoolArray
) -> tuple[ImageArray, float]:
    """The empty scene with the picture's shift and blur, by the background; the blur, pixels."""
    dx, dy = shift_of(picture, empty, background)
    if _LEAST_SHIFT < np.hypot(dx, dy) < _LARGEST_SHIFT:
        moved = np.array([[1.0, 0.0, dx], [0.0, 1.0, dy]])
        size = empty.shape[1], empty.shape[0]
        empty = cv2.warpAffine(
            empty, moved, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8, copy=False)
    own = _slopes(empty, background)
    energy = max(float(own @ own), 1.0)
    sharpness = float(own @ _slopes(picture, background)) / energy
    blurred, sigma = empty, 0.0
    if sharpness > _SHARP:
        return empty, sigma
    for sigma in _BLURS:
        blurred = cv2.GaussianBlur(empty, (0, 0), sigma).astype(np.uint8, copy=False)
        if float(own @ _slopes(blurred, background)) / energy < sharpness:
            break
    return blurred, sigma


def _slopes(image: ImageArray, background: BoolArray) -> Float32Array:
    """Horizontal slopes (n,) of the background in every third row, grey levels.

    Their correlation with the empty scene's own tells the blur: noise does not change it.
    """
    rows = image[1:-1:3]
    slopes = (rows[:, 2:].astype(np.float32) - rows[:, :-2]) * np.float32(0.5)
    return np.where(background[1:-1:3, 1:-1], slopes, np.float32(0)).ravel()


def shift_of(picture: ImageArray, empty: ImageArray, background: BoolArray) -> tuple[float, float]:
    """Pixels to the right and down by which the picture is shifted: one step of least squares."""
    gx = _slopes(empty, background)
    above, here, below = empty[:-2:3], empty[1:-1:3], empty[2::3]
    gy = ((below.astype(np.float32) - above) * np.float32(0.5))[:, 1:-1].ravel()
    r = (picture[1:-1:3].astype(np.float32) - here)[:, 1:-1].ravel()
    w = background[1:-1:3, 1:-1].ravel() / (1 + (r / _GREY) ** 2)
    xx, xy, yy = float(w @ (gx * gx)), float(w @ (gx * gy)), float(w @ (gy * gy))
    xr, yr = float(w @ (gx * r)), float(w @ (gy * r))
    determinant = xx * yy - xy * xy
    if not determinant > 1e-3 * max(xx, 1.0) * max(yy, 1.0):
        return 0.0, 0.0  # stripes, or no texture at all
    return -(yy * xr - xy * yr) / determinant, -(xx * yr - xy * xr) / determinant
