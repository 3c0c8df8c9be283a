"""Crops: what a network sees of a picture, and back."""

import cv2
import numpy as np
import pytest

from stereotrack_core.pose_model.crops import (
    Crop,
    crop_around,
    crop_from_body,
    crop_from_circle,
    crop_from_points,
    whole_picture,
)
from tests.tracking.recordings import camera_towards_the_middle

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


def test_a_shrunk_part_is_averaged():
    noise = np.random.default_rng(0).integers(0, 256, (800, 800)).astype(np.uint8)
    seen = Crop(np.array([400.0, 400.0]), 800.0).seen(noise, (100, 100))
    assert seen.std() < 16  # 73 for single pixels, 37 if only neighbours are mixed


def test_a_crop_beside_the_picture_is_black():
    assert not Crop(np.array([-5000.0, 90.0]), 900.0).seen(picture_of_a_spot(), SIZE).any()


def test_a_mask_comes_back_to_the_picture():
    crop = Crop(SPOT, 100.0, 0.5)
    back = crop.mask_in_picture(crop.seen(picture_of_a_spot(), SIZE) / 255.0, (200, 300))
    assert back.shape == (200, 300)
    np.testing.assert_allclose(middle_of_brightness(back), SPOT, atol=0.1)


def test_the_circle_around_the_body_stands_upright():
    hips, top = np.array([100.0, 200.0]), np.array([160.0, 200.0])  # lies, the head to the right
    crop = crop_from_circle(hips, top)
    assert crop.side == pytest.approx(150.0)
    seen = crop.model_from_picture(SIZE)
    middle, above = (seen[:, :2] @ place + seen[:, 2] for place in (hips, top))
    np.testing.assert_allclose(middle, [127.5, 127.5])
    np.testing.assert_allclose(above, [127.5, 127.5 - 256 * 60 / 150], atol=1e-9)


@pytest.mark.parametrize(("turned", "flag"), [(90, cv2.ROTATE_90_CLOCKWISE), (180, 1), (270, 2)])
def test_a_view_on_its_side_is_seen_upright(turned, flag):
    picture = np.random.default_rng(1).integers(0, 256, (64, 64)).astype(np.uint8)
    seen = whole_picture(picture.shape, turned).seen(picture, (64, 64))
    np.testing.assert_allclose(seen.astype(int), cv2.rotate(picture, flag).astype(int), atol=1)


def test_the_whole_picture_is_in_the_middle_of_a_square():
    crop = whole_picture((100, 300))
    np.testing.assert_allclose(crop.in_picture(np.array([-0.5, -0.5]), SIZE), [-0.5, -100.5])
    np.testing.assert_allclose(crop.in_picture(np.array([255.5, 255.5]), SIZE), [299.5, 199.5])


def test_a_box_is_shown_with_the_models_ratio():
    crop = crop_around(np.array([50.0, 60.0]), np.array([30.0, 40.0]), (48, 64))
    corners = crop.in_picture(np.array([[-0.5, -0.5], [47.5, 63.5]]), (48, 64))
    np.testing.assert_allclose(corners, [[35, 40], [65, 80]])


def test_points_that_are_not_known_are_left_out():
    crop = crop_from_points(np.array([[10.0, 20.0], [30.0, 100.0], [np.nan, 0.0]]))
    np.testing.assert_allclose(crop.centre, [20, 60])
    assert crop.side == pytest.approx(100.0)


def test_a_bent_body_has_a_crop_of_the_same_size():
    camera = camera_towards_the_middle("N", np.array([0.0, 3.0, 1.0]))
    hips = np.array([0.0, 0.0, 1.0])
    upright = crop_from_body(camera, hips, hips + [0, 0, 0.5])
    bent = crop_from_body(camera, hips, hips + [0.1, 0.5, 0.0])  # towards the camera
    assert upright.side == pytest.approx(2.5 * camera.focal / 3.0, rel=0.01)
    assert bent.side == pytest.approx(upright.side)
    np.testing.assert_allclose(upright.centre, camera.project(hips))
    assert crop_from_body(camera, np.array([0.0, 9.0, 1.0]), hips) is None  # behind it
