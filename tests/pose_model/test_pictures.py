"""Pictures of any camera as photographs."""

import numpy as np

from stereotrack_core.pose_model.pictures import as_rgb, as_uint8, shaded_depth


def test_colours_are_in_the_order_of_networks():
    blue = np.zeros((4, 4, 3), np.uint8)
    blue[..., 0] = 200
    assert as_rgb(blue)[0, 0].tolist() == [0, 0, 200]
    assert as_rgb(blue[..., 0])[0, 0].tolist() == [200, 200, 200]


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
