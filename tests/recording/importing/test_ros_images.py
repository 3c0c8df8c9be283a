"""Pictures in messages of ROS, in every encoding that is read."""

import struct
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.importing.ros import is_depth, picture_in

HEIGHT, WIDTH = 6, 8
BGR = np.full((HEIGHT, WIDTH, 3), (200, 120, 40), np.uint8)
GREY = np.arange(HEIGHT * WIDTH, dtype=np.uint8).reshape(HEIGHT, WIDTH)


def message(pixels, encoding, *, big=False, padding=0):
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(HEIGHT, -1)
    rows = np.pad(rows, ((0, 0), (0, padding)))
    return SimpleNamespace(
        height=HEIGHT, width=WIDTH, encoding=encoding, is_bigendian=int(big), step=rows.shape[1],
        data=rows.ravel(),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("pixels", "encoding"),
    [
        (BGR, "bgr8"),
        (BGR[..., ::-1], "rgb8"),
        (np.dstack([BGR, np.full((HEIGHT, WIDTH), 255, np.uint8)]), "bgra8"),
        (np.dstack([BGR[..., ::-1], np.full((HEIGHT, WIDTH), 255, np.uint8)]), "rgba8"),
    ],
)
def test_colours(pixels, encoding):
    for padding in (0, 5):
        shown = picture_in(message(pixels, encoding, padding=padding), "colour", 0.001)
        assert np.array_equal(shown, BGR)


def test_grey_bayer_and_luma():
    assert np.array_equal(picture_in(message(GREY, "mono8"), "grey", 0.001), GREY)
    flat = np.full((HEIGHT, WIDTH), 90, np.uint8)
    assert (picture_in(message(flat, "bayer_rggb8"), "colour", 0.001) == 90).all()
    uyvy = np.tile(np.array([128, 100], np.uint8), (HEIGHT, WIDTH))
    shown = picture_in(message(uyvy, "yuv422"), "grey", 0.001)
    assert shown.shape == (HEIGHT, WIDTH)
    assert np.ptp(shown) == 0


@pytest.mark.parametrize("big", [False, True])
def test_depth_in_either_order_of_bytes(big):
    counts = (1000 + GREY.astype(int)).astype(">u2" if big else "<u2")
    shown = picture_in(message(counts, "16UC1", big=big), "depth", 0.001)
    assert shown.dtype == np.uint16
    assert np.array_equal(shown, counts)
    metres = (2.0 + GREY / 100.0).astype(">f4" if big else "<f4")
    metres[0, 0], metres[0, 1] = np.nan, np.inf
    shown = picture_in(message(metres, "32FC1", big=big), "depth", 0.0005)
    assert np.allclose(shown[1:] * 0.0005, metres[1:], atol=0.0003)
    assert shown[0, 0] == shown[0, 1] == 0


def test_compressed_depth_of_floats_is_inverse():
    metres = (1.0 + GREY / 20).astype(np.float32)
    a, b = 5000.0, -10.0
    counts = np.round(a / metres + b).astype(np.uint16)
    counts[0, 0] = 0
    content = struct.pack("<iff", 0, a, b) + cv2.imencode(".png", counts)[1].tobytes()
    data = np.frombuffer(content, np.uint8)
    one = SimpleNamespace(format="32FC1; compressedDepth png", data=data)
    assert is_depth(one)
    shown = picture_in(one, "depth", 0.0005)
    assert np.allclose(shown[1:] * 0.0005, metres[1:], rtol=0.002)
    assert shown[0, 0] == 0


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (message(GREY, "jpeg2000"), "encoding 'jpeg2000' cannot be read"),
        (SimpleNamespace(**{**vars(message(GREY, "mono8")), "step": 3}), "fewer bytes"),
        (SimpleNamespace(format="jpeg", data=np.zeros(9, np.uint8)), "damaged"),
        (SimpleNamespace(format="16UC1; compressedDepth", data=np.zeros(9, np.uint8)), "cut off"),
    ],
)
def test_what_is_no_picture_is_said(broken, words):
    with pytest.raises(DamagedFrame, match=words):
        picture_in(broken, "colour", 0.001)
