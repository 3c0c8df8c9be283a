"""Crops: what a network sees of a picture, and back."""

import cv2
import numpy as np
import pytest

from stereotrack_core.pose_model.crops import Crop, as_rgb, as_uint8, shaded_depth, whole_picture

SIZE = (256, 256)
SPOT = np.array([140.0, 90.0])


def picture_of_a_spot(shape=(200, 300)) -> np.ndarray:
    """A soft bright spot around SPOT."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    near = np.exp(-((columns - SPOT[0]) ** 2 + (rows - SPOT[1]) ** 2) / (2 * 6.0**2))
    return (250 * near).astype(np.uint8)


def middle_of_brightness(picture: np.ndarray) -> np.ndarray:
    rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]]
    weights = picture / picture.sum(dtype=float)
    return np.array([(columns * weights).sum(), (rows * weights).sum()])


@pytest.mark.parametrize("side", [64.0, 170.0, 1000.0])
@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2, 3.0])
@pytest.mark.parametrize("size", [SIZE, (48, 64)])
def test_what_is_seen_leads_back_to_the_pixel(side, angle, size):
    crop = Crop(SPOT + [4.0, -3.0], side, angle)
    seen = crop.seen(picture_of_a_spot(), size)
    assert seen.shape == size[::-1]
    place = crop.in_picture(middle_of_brightness(seen), size)
    # half a pixel of what is seen: at 1000 pixels the spot has five of its pixels
    assert np.linalg.norm(place - SPOT) < max(0.1, 0.1 * side / max(size))


@pytest.mark.parametrize(("turned", "flag"), [(90, cv2.ROTATE_90_CLOCKWISE), (180, 1), (270, 2)])
def test_a_view_on_its_side_is_seen_upright(turned, flag):
    picture = np.random.default_rng(1).integers(0, 256, (64, 64)).astype(np.uint8)
    seen = whole_picture(picture.shape, turned).seen(picture, (64, 64))
    np.testing.assert_allclose(seen.astype(int), cv2.rotate(picture, flag).astype(int), atol=1)


def test_a_dark_picture_gets_contrast_and_a_bright_one_stays():
    ramp = np.tile(np.arange(256, dtype=np.uint8), (16, 1))
    np.testing.assert_array_equal(as_rgb(ramp)[..., 0], ramp)
    dark = as_rgb(ramp // 8)
    assert 180 < dark.max() <= 255
    assert (np.diff(dark[0, :, 0].astype(int)) >= 0).all()
    assert not as_rgb(np.zeros((8, 8), np.uint8)).any()


def test_depth_is_shaded_by_its_slope():
    columns = np.mgrid[:80, :80][1]
    depth = np.where(columns < 40, 2.0, 2.0 + 0.05 * (columns - 40)).astype(np.float32)
    depth[:10] = np.nan
    shaded = shaded_depth(depth)
    assert not shaded[:7].any()
    facing, turned = shaded[20:70, 10:30], shaded[20:70, 50:70]
    assert facing.min() > 200
    assert 0 < turned.max() < 150
    np.testing.assert_array_equal(as_uint8(depth), shaded)
    assert as_uint8(shaded) is shaded
