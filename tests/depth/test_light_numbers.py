"""The light of a picture against the same estimates in plain NumPy and SciPy."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from stereotrack_core.depth import light
from stereotrack_core.depth.light import (
    Light,
    empty_scene,
    evened,
    light_of,
    relit,
    sensor_noise,
    shaded,
    shift_of,
)
from tests.depth.scenes import texture

EMPTY = (40 + 0.6 * texture(240, 320, seed=1)).clip(0, 255).astype(np.uint8)
ROWS, COLUMNS = np.mgrid[:240, :320]
EVERYWHERE = np.ones(EMPTY.shape, dtype=bool)


def _lit(gamma=1.0, gain=1.0, slope=0.0, offset=0.0, noise=0.0):
    """The empty scene in another light, in which somebody stands."""
    scene = 255.0 * gain * (EMPTY / 255.0) ** gamma * (1.0 + slope * (COLUMNS / 320 - ROWS / 480))
    scene[60:200, 130:190] = texture(240, 320, seed=3)[60:200, 130:190]
    grain = noise * np.random.default_rng(0).normal(size=scene.shape)
    return (scene + offset + grain).clip(0, 255).astype(np.uint8)


PICTURES = {
    "same": _lit(),
    "dark": _lit(0.8, 0.5, 0.2),
    "bright": _lit(1.5, 1.4, -0.3, noise=3.0),
    "steep": _lit(4.0, 2.0),
    "flat": _lit(0.2, 0.7, offset=20.0, noise=1.0),
}


def _small(picture):
    return np.rint(picture.reshape(60, 4, 80, 4).mean(axis=(1, 3)) - 1e-6)


def _curve(before, now):
    """Levels now of levels 0 to 255: straight between medians, and a power law beyond them."""
    x, y = np.maximum(before, 1.0), np.maximum.accumulate(np.maximum(now, 1.0))
    kept = [0] + [k + 1 for k, (a, b) in enumerate(pairwise(x)) if b - a > 0.5]
    x, y = x[kept], y[kept]
    off = np.log(x) - np.log(x).mean()
    power = np.clip((off @ np.log(y) + 0.05) / (off @ off + 0.05), 0.4, 2.5)
    below, above = np.linspace(1, x[0], 8)[:-1], np.linspace(x[-1], 255, 8)[1:]
    nodes = [(0.0, 0.0), *((p, y[0] * (p / x[0]) ** power) for p in below), *zip(x, y, strict=True)]
    nodes += [(p, y[-1] * (p / x[-1]) ** power) for p in above]
    return np.interp(np.arange(256), *np.transpose(nodes))


def _plane(log_gain):
    """Plane through some log gains by four rounds of weighted least squares; steep ones cost."""
    rows, columns = (g.ravel() for g in np.mgrid[3:60:6, 3:80:6])
    terms = np.stack([np.ones(len(rows)), columns / 80 - 0.5, rows / 60 - 0.5], axis=1)
    x = np.array([np.median(log_gain), 0.0, 0.0])
    for _ in range(4):
        weight = (0.15**2 / (0.15**2 + (log_gain - terms @ x) ** 2)) ** 2
        held = np.sqrt([1e-9, 1.0, 1.0])
        stacked = np.vstack([np.sqrt(weight)[:, None] * terms, np.diag(held)])
        x = np.linalg.lstsq(stacked, np.r_[np.sqrt(weight) * log_gain, np.zeros(3)], rcond=None)[0]
    v, u = np.mgrid[:60, :80]
    return x[0] + x[1] * (u / 80 - 0.5) + x[2] * (v / 60 - 0.5)


def _deviation(difference):
    return max(1.4826 * np.sort(np.abs(difference).ravel())[difference.size // 2], 0.5)


@pytest.mark.parametrize("darker", [0, 70])
@pytest.mark.parametrize("name", PICTURES)
def test_light_is_a_tone_curve_and_a_plane_of_gain(name, darker):
    picture = cv2.subtract(PICTURES[name], darker)
    scene = empty_scene(dark := cv2.subtract(EMPTY, darker))
    found = light_of(picture, scene)
    np.testing.assert_array_less(np.abs(found.small - _small(picture)), 1.01)
    np.testing.assert_array_less(np.abs(scene.small - _small(dark)), 1.01)
    few = scene.small[::2, ::2].ravel()
    order = np.argsort(few, kind="stable")
    before, now = (
        np.median(levels[: len(few) // 12 * 12].reshape(12, -1), axis=1)
        for levels in (few[order], found.small[::2, ::2].ravel()[order])
    )
    np.testing.assert_array_equal(scene.levels, before)
    curve = _curve(before, now)
    np.testing.assert_allclose(found.curve, curve, rtol=1e-5)
    toned = found.curve[scene.small]
    sixth = np.s_[3::6, 3::6]
    plane = _plane(np.log((found.small[sixth] + 1.0) / (toned[sixth] + 1.0)).ravel())
    np.testing.assert_allclose(found.log_gain, plane, atol=1e-5)
    np.testing.assert_allclose(found.empty_small, toned * np.exp(plane), rtol=1e-4)
    third = np.s_[::3, ::3]
    assert found.noise == pytest.approx(_deviation((found.small - found.empty_small)[third]))


def test_noise_is_told_by_the_quietest_stretches_that_are_not_clipped(rng):
    for spread in (2.0, 6.0):
        picture = rng.normal(128.0, spread * np.linspace(0.2, 3.0, 330), (240, 330))
        picture[::24] += 115.0
        picture[4::36] -= 120.0
        picture = picture.clip(0, 255).astype(np.uint8)
        runs = picture[4::12, :320].reshape(-1, 32).astype(float)
        runs = runs[((runs > 0) & (runs < 255)).all(axis=1)]
        found = np.abs(runs[:, :-2] - 2.0 * runs[:, 1:-1] + runs[:, 2:]).mean(axis=1)
        expected = np.sort(found)[int(0.1 * len(found))] / (np.sqrt(6.0) * 0.798)
        assert sensor_noise(picture) == pytest.approx(expected)
    assert sensor_noise(np.full((240, 320), 255, np.uint8)) == 0.0
    assert sensor_noise(EMPTY[:36]) == 0.0, "too few stretches"


def _mean(image, size):
    return uniform_filter(image.astype(float), size, mode="mirror")


def _structure(now, before, noise):
    """Where both are alike, and where there is nothing that could be."""
    mean = [_mean(one, 5) for one in (now, before)]
    variance = [
        _mean(one.astype(float) ** 2, 5) - m**2 for one, m in zip((now, before), mean, strict=True)
    ]
    common = _mean(now.astype(float) * before, 5) - mean[0] * mean[1]
    flat = variance[1] < 9.0 * noise**2
    return ~flat & (common > 0.6 * np.sqrt(np.maximum(variance[0] * variance[1], 0.0))), flat


def _gain(now, before, noise, background):
    alike, flat = _structure(now, before, noise)
    ratio = np.clip(np.log((now + 1.0) / (before + 1.0)), -1.0, 1.0)
    local = np.zeros_like(ratio)
    for size in (25, 13, 9):
        sure = background & np.where(flat, np.abs(ratio - local) < 0.1, alike)
        local = _mean(ratio * sure, size) / (_mean(sure, size) + 0.02)
    return local


@pytest.fixture(scope="module")
def patchy():
    """Shrunken pictures with structure, flat walls, shade and somebody in front."""
    before = _small(EMPTY)
    before[:, 50:] = 90.0 + 0.3 * (before[:, 50:] - 90.0)
    now = before * (1.0 - 0.5 / (1.0 + np.exp(-(np.arange(80) - 40.0) / 6.0)))
    now[:20] *= 1.6
    now[30:50, 20:34] = _small(texture(240, 320, seed=5))[30:50, 20:34]
    now += np.random.default_rng(0).normal(0.0, 1.0, now.shape)
    small = [one.astype(np.float32) for one in (now, before)]
    return Light(np.arange(256, dtype=np.float32), np.zeros((60, 80), np.float32), *small, 1.7)


def test_shade_keeps_the_structure_and_changes_the_level(patchy):
    now, before = patchy.small, patchy.empty_small
    alike, flat = _structure(now, before, patchy.noise)
    assert 0.1 < flat.mean() < 0.5
    level = np.abs(_mean(np.log((now + 1.0) / (before + 1.0)), 5))
    assert (shaded(patchy) != (alike & (level > 0.1))).mean() < 0.001
    gain = _gain(now, before, patchy.noise, np.True_)
    np.testing.assert_allclose(evened(patchy), before * np.exp(gain), rtol=2e-3)


@pytest.mark.parametrize(("width", "local"), [(0, False), (20, False), (100, True)])
def test_local_gain_is_taken_where_more_than_a_fiftieth_is_shaded(width, local):
    scene = empty_scene(EMPTY)
    picture = EMPTY.astype(np.float64)
    picture[:width, :width] *= 0.6
    picture = (picture + np.random.default_rng(0).normal(0.0, 1.0, picture.shape)).clip(0, 255)
    seen = light_of(picture.astype(np.uint8), scene)
    part = np.s_[40:200, 20:300]
    background = np.ones((160, 280), dtype=bool)
    background[50:90, 100:150] = False
    known = EVERYWHERE.copy()
    known[part] = background
    known = known.reshape(60, 4, 80, 4).mean(axis=(1, 3)) > 250 / 255
    gain = seen.log_gain
    if local:
        gain = gain + _gain(seen.small, seen.empty_small, seen.noise, known)
    gain = cv2.resize(np.exp(gain), (320, 240), interpolation=cv2.INTER_LINEAR)
    expected = seen.curve[EMPTY] * gain
    found = relit(picture.astype(np.uint8), scene, seen, background, part)
    np.testing.assert_allclose(found.picture, expected[part].clip(0, 255), atol=0.7)
    off = [_mean(one, 3)[::4, ::4] for one in (picture.astype(np.uint8)[part], found.picture)]
    apart = (np.rint(off[0]) - np.rint(off[1]))[background[::4, ::4]]
    assert found.noise == pytest.approx(_deviation(apart), abs=0.01)
    assert found.blur == 0.0


@pytest.mark.parametrize(
    ("by", "followed"), [(0.14, False), (0.16, True), (2.9, True), (3.1, False)]
)
def test_shifts_are_followed_unless_they_are_none_or_of_another_rig(by, followed, monkeypatch):
    monkeypatch.setattr(light, "shift_of", lambda *_: (0.6 * by, -0.8 * by))
    at = np.float32(COLUMNS - 0.6 * by), np.float32(ROWS + 0.8 * by)
    moved = cv2.remap(EMPTY, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    found, _ = light._aligned(moved if followed else EMPTY, EMPTY, EVERYWHERE)
    assert np.abs(found - (moved if followed else EMPTY).astype(float)).mean() < 0.5
    assert (found == EMPTY).all() != followed


@pytest.mark.parametrize("blur", [0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0])
def test_the_least_blur_that_is_more_than_the_pictures_is_taken(blur):
    seen = cv2.GaussianBlur(EMPTY, (0, 0), 0.97 * blur)
    found, sigma = light._aligned(seen, EMPTY, EVERYWHERE)
    assert sigma == blur
    np.testing.assert_array_equal(found, cv2.GaussianBlur(EMPTY, (0, 0), blur))


@pytest.mark.parametrize(("contrast", "sharp"), [(0.87, False), (0.93, True)])
def test_a_picture_with_nine_tenths_of_the_slopes_is_sharp(contrast, sharp):
    seen = np.rint(127 + contrast * (EMPTY - 127.0)).astype(np.uint8)
    assert (light._aligned(seen, EMPTY, EVERYWHERE)[1] == 0.0) == sharp


@pytest.mark.parametrize("by", [(0.4, -0.3), (-0.2, 0.5)])
def test_a_shift_is_one_step_of_weighted_least_squares(by, rng):
    moved = np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]]])
    seen = cv2.warpAffine(EMPTY, moved, (320, 240), borderMode=cv2.BORDER_REPLICATE)
    seen[80:150, 100:200] = 220
    background = rng.random(EMPTY.shape) < 0.8
    rows = slice(1, -1, 3), slice(1, -1)
    e = EMPTY.astype(float)
    gx = 0.5 * (np.roll(e, -1, axis=1) - np.roll(e, 1, axis=1))[rows]
    gy = 0.5 * (np.roll(e, -1, axis=0) - np.roll(e, 1, axis=0))[rows]
    gx = np.where(background[rows], gx, 0.0)
    r = (seen - e)[rows]
    w = np.sqrt(background[rows] / (1.0 + (r / 20.0) ** 2)).ravel()
    slopes = w[:, None] * np.stack([gx.ravel(), gy.ravel()], axis=1)
    expected = -np.linalg.lstsq(slopes, w * r.ravel(), rcond=None)[0]
    np.testing.assert_allclose(shift_of(seen, EMPTY, background), expected, rtol=1e-4)
    np.testing.assert_allclose(expected, by, rtol=0.3)
    stripes = np.broadcast_to(EMPTY[:1], EMPTY.shape)
    assert shift_of(stripes, np.roll(stripes, 1, axis=1), background) == (0.0, 0.0)
