"""The empty scene's picture in the light of a later one.

A camera with automatic exposure, a cloud, a lamp or a shadow changes grey values where nothing
has moved. Before a picture is compared with that of the empty scene, the latter is brought into
its light: a tone curve (exposure, gamma, offset), a gain that varies over the image (shade, soft
shadows), a shift (a camera that was touched) and a blur (focus, compression). All are medians or
robust means over many pixels, so that a person who covers a fifth of the image changes none.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray, IntArray

SHRINK = 4
"""Pixels of the image, in both directions, to one of the shrunken picture that light is taken of."""

_BINS = 12
"""Points of the tone curve; each is the median of as many pixels."""

_POWERS = (0.4, 2.5)
"""Least and largest gamma that a tone curve is continued with."""

_HELD = 0.05
"""Weight of a gamma of 1, against the variance of the medians' logarithms."""

_GAIN_SCALE = 0.15
"""Deviation of a logarithmic gain from the plane through all that has a quarter of the weight."""

_NEIGHBOURHOODS = (8.0, 4.0, 3.0)
"""Standard deviations, shrunken pixels, of the surroundings whose gain is taken for a pixel's."""

_FEW = np.float32(0.02)
"""Share of the surroundings below which the plane's gain is taken instead."""

_WINDOW = (5, 5)
_LEAST_CORRELATION = 0.6
"""Of the structure of picture and empty scene, in a window of shrunken pixels, where both are one."""

_FLAT = 0.1
"""Largest deviation of a logarithmic gain where there is no structure to tell light from things."""

_LARGEST_SHIFT = 3.0
"""Pixels; a camera that has moved farther needs a new calibration."""

_LEAST_SHIFT = 0.15
"""Pixels that are not worth a resampling."""

_BLURS = (0.0, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0)
"""Standard deviations, pixels, of blurs that are tried on the empty scene."""

_LEAST_NOISE = 0.5
"""Grey levels of rounding that remain without any noise."""


@dataclass(frozen=True, eq=False)
class EmptyScene:
    """Picture (H, W) of the empty scene, with what its comparison needs of it each time."""

    picture: ImageArray
    small: Float32Array
    """(h, w). Shrunken picture."""
    order: IntArray
    """(h w,). Pixels of the shrunken picture from dark to light."""
    levels: FloatArray
    """(bins,). Median grey level of each bin of them."""


def empty_scene(picture: ImageArray) -> EmptyScene:
    """Prepare a picture (H, W) of the empty scene for comparisons."""
    small = shrunken(picture)
    order = np.argsort(small, axis=None, kind="stable")
    levels = _medians(small.ravel()[order])
    return EmptyScene(picture, small, order, levels)


def shrunken(picture: ImageArray) -> Float32Array:
    """The picture at a quarter of its size."""
    size = (picture.shape[1] // SHRINK, picture.shape[0] // SHRINK)
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Light:
    """Light of one picture against that of the empty scene."""

    curve: Float32Array
    """(256,). Grey level now of each grey level of the empty scene, at gain 1."""
    log_gain: Float32Array
    """(h, w). Logarithm of the gain that comes to it, on the shrunken image."""
    small: Float32Array
    """(h, w). Shrunken picture."""
    empty_small: Float32Array
    """(h, w). Shrunken empty scene in this light."""
    noise: float
    """Grey levels. Standard deviation of the difference of the shrunken pictures."""


def light_of(picture: ImageArray, scene: EmptyScene) -> Light:
    """Estimate exposure, gamma and a plane of gain for the whole picture (H, W)."""
    now = shrunken(picture)
    curve = _tone_curve(scene.levels, _medians(now.ravel()[scene.order]))
    toned = np.interp(scene.small, np.arange(256), curve).astype(np.float32)
    plane = _robust_plane(_log_ratio(now, toned))
    lit = toned * np.exp(plane)
    return Light(curve, plane, now, lit, _spread(now[::2, ::2] - lit[::2, ::2]))


def relit(
    picture: ImageArray, scene: EmptyScene, light: Light, background: BoolArray
) -> tuple[ImageArray, float]:
    """The empty scene as it would look in the picture, and the noise of the difference.

    Parameters
    ----------
    picture : (H, W) uint8
    background : (H, W) bool
        Pixels that surely show the empty scene, in whatever light: their gain is taken as it is,
        so that soft shadows and wandering shade are no difference.

    Returns
    -------
    (H, W) uint8 and float
        The noise is a standard deviation in grey levels, of a pixel after a blur of 3 x 3.
    """
    height, width = picture.shape
    small = light.small.shape[1], light.small.shape[0]
    known = cv2.resize(background.astype(np.uint8) * 255, small, interpolation=cv2.INTER_AREA)
    local = _local_gain(light, known > 250)
    gain = cv2.resize(
        np.exp(light.log_gain + local), (width, height), interpolation=cv2.INTER_LINEAR
    )
    empty = cv2.multiply(
        cv2.LUT(scene.picture, light.curve), gain, dtype=cv2.CV_8U
    )
    if not __import__("os").environ.get("NOALIGN"): empty = _aligned(picture, empty, background)
    rows = slice(None, None, 4)
    a, b = (cv2.blur(p, (3, 3))[rows, rows].astype(np.float32) for p in (picture, empty))
    return empty, _spread((a - b)[background[rows, rows]])


def _local_gain(light: Light, background: BoolArray) -> Float32Array:
    """Logarithmic gain (h, w) beyond the plane's, smoothed over what shows the empty scene.

    That is where the structure of both pictures correlates in a small window, whatever the light.
    Where the empty scene has no structure, the gain must agree with that of the surroundings.
    """
    a, b = light.small, light.empty_small

    def mean(image: Float32Array) -> Float32Array:
        return cv2.boxFilter(image, cv2.CV_32F, _WINDOW).astype(np.float32, copy=False)

    mean_a, mean_b = mean(a), mean(b)
    var_a, var_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    flat = var_b < (3 * light.noise) ** 2
    alike = mean(a * b) - mean_a * mean_b > _LEAST_CORRELATION * np.sqrt(
        np.maximum(var_a * var_b, 0)
    )
    ratio = np.clip(_log_ratio(a, b), -1, 1)
    local = np.zeros_like(ratio)
    for neighbourhood in _NEIGHBOURHOODS:
        sure = background & np.where(flat, np.abs(ratio - local) < _FLAT, alike)
        weight = sure.astype(np.float32)
        total = cv2.GaussianBlur(weight, (0, 0), neighbourhood)
        local = cv2.GaussianBlur(ratio * weight, (0, 0), neighbourhood) / (total + _FEW)
    return local


def _medians(ordered: Float32Array) -> FloatArray:
    """Medians (bins,) of equal parts of some grey levels."""
    share = len(ordered) // _BINS
    return np.median(ordered[: share * _BINS].reshape(_BINS, share), axis=1).astype(np.float64)


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
    return np.log((now + 1) / (before + 1))


def _robust_plane(log_gain: Float32Array) -> Float32Array:
    """Plane through logarithmic gains (h, w), by iteratively reweighted least squares."""
    height, width = log_gain.shape
    rows, columns = np.arange(height) / height - 0.5, np.arange(width) / width - 0.5
    z = log_gain[2::4, 2::4].astype(np.float64).ravel()
    v, u = (g.ravel() for g in np.meshgrid(rows[2::4], columns[2::4], indexing="ij"))
    a = np.column_stack([np.ones_like(u), u, v])
    x = np.array([np.median(z), 0.0, 0.0])
    held = np.diag([1e-9, 1.0, 1.0])  # a slope needs evidence
    for _ in range(5):
        weight = 1 / (1 + ((z - a @ x) / _GAIN_SCALE) ** 2) ** 2
        weighted = a * weight[:, None]
        x = np.linalg.solve(weighted.T @ a + held, weighted.T @ z)
    return (x[0] + x[1] * columns + x[2] * rows[:, None]).astype(np.float32)


def _spread(difference: Float32Array) -> float:
    """Robust standard deviation of differences in grey levels."""
    if not difference.size:
        return _LEAST_NOISE
    return max(1.4826 * float(np.median(np.abs(difference))), _LEAST_NOISE)


def _aligned(picture: ImageArray, empty: ImageArray, background: BoolArray) -> ImageArray:
    """The empty scene with the picture's shift and blur.

    Both come of the correlation of gradients, which noise does not change.
    """
    rows = slice(1, -1, 3)
    seen = background[rows, 1:-1]
    now, before = picture.astype(np.int16), empty.astype(np.int16)
    gx = (before[rows, 2:] - before[rows, :-2])[seen] * np.float32(0.5)
    gy = (before[2:][::3, 1:-1][: seen.shape[0]] - before[:-2][::3, 1:-1][: seen.shape[0]])[
        seen
    ] * np.float32(0.5)
    r = (now[rows, 1:-1] - before[rows, 1:-1])[seen].astype(np.float32)
    w = 1 / (1 + (r / 20) ** 2)
    a11, a12, a22 = (w * gx * gx).sum(), (w * gx * gy).sum(), (w * gy * gy).sum()
    b1, b2 = (w * gx * r).sum(), (w * gy * r).sum()
    determinant = a11 * a22 - a12 * a12
    if not determinant > 1e-3 * max(a11, 1) * max(a22, 1):
        return empty
    # r = -shift . gradient: the picture shows at x what the empty scene shows at x - shift
    dx, dy = -(a22 * b1 - a12 * b2) / determinant, -(a11 * b2 - a12 * b1) / determinant
    length = float(np.hypot(dx, dy))
    if _LEAST_SHIFT < length < _LARGEST_SHIFT:
        m = np.array([[1, 0, dx], [0, 1, dy]], dtype=np.float64)
        empty = cv2.warpAffine(
            empty, m, empty.shape[::-1], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8, copy=False)
        before = empty.astype(np.int16)
        gx = (before[rows, 2:] - before[rows, :-2])[seen] * np.float32(0.5)
    now_gx = (now[rows, 2:] - now[rows, :-2])[seen] * np.float32(0.5)
    sharpness = float((gx * now_gx).sum() / max((gx * gx).sum(), 1.0))
    if sharpness > 0.9:
        return empty
    best, before_gx = empty, gx
    for sigma in _BLURS[1:]:
        best = cv2.GaussianBlur(empty, (0, 0), sigma).astype(np.uint8, copy=False)
        b = best.astype(np.int16)
        blurred = (b[rows, 2:] - b[rows, :-2])[seen] * np.float32(0.5)
        if float((blurred * before_gx).sum() / max((before_gx * before_gx).sum(), 1.0)) < sharpness:
            break
    return best
