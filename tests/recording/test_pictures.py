"""Grey values are those of ffmpeg's conversion, whatever the range and the pixel format."""

import av
import cv2
import numpy as np
import pytest

from stereotrack_core.recording.images import (
    DamagedFrame,
    NumberedImages,
    numbered_files,
    picture_of,
)

FULL, LIMITED = 2, 1


def frame_of(pixels, colour_range):
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 256, (46, 62, 3), dtype=np.uint8)
    frame = av.VideoFrame.from_ndarray(colour, format="bgr24").reformat(format=pixels)
    frame.color_range = colour_range
    return frame


@pytest.mark.parametrize("colour_range", [0, LIMITED, FULL])
@pytest.mark.parametrize("pixels", ["yuv420p", "yuvj420p", "nv12", "gray", "yuv420p10le", "bgr24"])
def test_grey_is_that_of_ffmpeg(pixels, colour_range):
    frame = frame_of(pixels, colour_range)
    found = picture_of(frame, "grey")
    assert found.shape == (46, 62)
    assert found.dtype == np.uint8
    expected = frame.to_ndarray(format="gray").astype(int)
    assert np.abs(found - expected).max() <= 1


def test_colour_is_blue_green_red_and_grey_stays_grey():
    colour = np.zeros((8, 8, 3), np.uint8)
    colour[..., 0] = 200
    frame = av.VideoFrame.from_ndarray(colour, format="bgr24").reformat(format="yuv444p")
    assert np.abs(picture_of(frame, "colour").astype(int) - colour).max() <= 3
    assert picture_of(frame_of("gray", 0), "colour").shape == (46, 62)


def test_depth_keeps_its_sixteen_bits():
    counts = np.arange(48, dtype=np.uint16).reshape(6, 8) * 1000
    frame = av.VideoFrame.from_ndarray(counts, format="gray16le")
    assert np.array_equal(picture_of(frame, "depth"), counts)
    with pytest.raises(DamagedFrame, match="no depth"):
        picture_of(frame_of("gray", 0), "depth")


@pytest.mark.parametrize("channels", [1, 3])
def test_numbered_images_of_12_bits_have_one_white(tmp_path, channels):
    for k, value in enumerate((200, 1500, 4000)):
        picture = np.full((8, 8, channels), value, np.uint16).squeeze()
        cv2.imwrite(str(tmp_path / f"{k}.png"), picture)
    images = NumberedImages(numbered_files(tmp_path, "%d.png"), "%d.png", "grey")
    shown = [int(images.read(k, lambda *_: None).mean()) for k in range(3)]
    assert shown == [round(255 * value / 4095) for value in (200, 1500, 4000)]
