"""Pictures of more than 8 bits: one white for all pictures and both cameras of a pair."""

import zlib
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from PIL import Image

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import doubts_about
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.readers import with_one_white
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png
from tests.recording.importing.clips import HEIGHT, WIDTH, chosen, clip, frames_of, images, numbered

DARK, GREY, BRIGHT = 200, 1500, 4000  # of 12 bits


def picture(value, channels=1):
    return np.full((HEIGHT, WIDTH, channels), value, np.uint16).squeeze()


def sequence(folder, values, suffix=".png", channels=1):
    folder.mkdir(parents=True)
    for k, value in enumerate(values):
        cv2.imwrite(str(folder / f"{k:04d}{suffix}"), picture(value, channels))


def made(folder, out):
    choices = with_one_white(chosen(folder, fps=10.0))
    return choices, frames_of(make_recording(choices, out))


def as_shown(value, bits=12):
    return round(255 * value / (2**bits - 1))


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
@pytest.mark.parametrize("channels", [1, 3])
def test_a_dark_first_picture_leaves_the_others_as_they_are(tmp_path, suffix, channels):
    sequence(tmp_path / "in" / "left", (DARK, GREY, BRIGHT), suffix, channels)
    sequence(tmp_path / "in" / "right", (DARK, DARK, GREY), suffix, channels)
    choices, frames = made(tmp_path / "in", tmp_path / "out")
    shown = [[int(one["stereo"].left.mean()), int(one["stereo"].image.mean())] for one in frames]
    assert shown == [[as_shown(a), as_shown(b)]
                     for a, b in ((DARK, DARK), (GREY, DARK), (BRIGHT, GREY))]  # fmt: skip
    assert "left has 16 bits" in doubts_about(choices)[0]
    assert "white is 4095" in doubts_about(choices)[0]


def with_significant_bits(content, bits):
    """A PNG of 16 bits with the chunk that states how many of them are significant."""
    chunk = b"sBIT" + bytes([bits])
    chunk = (1).to_bytes(4) + chunk + zlib.crc32(chunk).to_bytes(4)
    return content[:33] + chunk + content[33:]  # behind the header


@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_what_a_file_states_counts_more_than_dim_pictures(tmp_path, suffix):
    for side in ("left", "right"):
        sequence(tmp_path / "in" / side, (900, 900), suffix)
        for path in (tmp_path / "in" / side).iterdir():
            if suffix == ".tif":
                Image.fromarray(picture(900)).save(path, tiffinfo={281: 4095})
            else:
                path.write_bytes(with_significant_bits(path.read_bytes(), 12))
    choices, frames = made(tmp_path / "in", tmp_path / "out")
    assert choices.uses[0].source.white == 4095
    assert frames[0]["stereo"].image.max() == as_shown(900)


@pytest.mark.parametrize(("layout", "values"), [("gray16le", (DARK, GREY)), ("gray12le", (GREY,))])
def test_videos_of_more_than_8_bits(tmp_path, layout, values):
    (tmp_path / "in").mkdir()
    for side in ("left", "right"):
        with av.open(str(tmp_path / "in" / f"{side}.mkv"), "w") as container:
            stream = container.add_stream("ffv1", rate=Fraction(10))
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, layout
            for value in values * 3:
                frame = av.VideoFrame(WIDTH, HEIGHT, layout)
                plane = frame.planes[0]
                plane.update(np.full(plane.buffer_size // 2, value, np.uint16).tobytes())
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
    _, frames = made(tmp_path / "in", tmp_path / "out")
    shown = [float(one["stereo"].image.mean()) for one in frames]
    assert shown == pytest.approx([as_shown(value) for value in values * 3], abs=1.5)


EMPTY = np.tile(np.arange(WIDTH, dtype=np.uint8), (HEIGHT, 1))


def background_of(recording, view):
    with FrameReader(recording, colour=False, read_ahead=0) as reader:
        return reader.background(view)


def test_backgrounds_are_found_by_their_names(tmp_path):
    for name in ("N_left", "N_right", "S"):
        clip(tmp_path / f"{name}.mp4", frames=2)
    write_png(tmp_path / "N_left_background.png", EMPTY)
    write_png(tmp_path / "N_right_background.png", EMPTY + 1)
    (tmp_path / "empty").mkdir()
    write_png(tmp_path / "empty" / "S.png", EMPTY + 2)
    choices = chosen(tmp_path)
    assert len(choices.used()) == 3
    for place in (tmp_path / "elsewhere", tmp_path):
        recording = make_recording(choices, place)
        left, right = background_of(recording, "N")
        assert np.array_equal(left, EMPTY)
        assert np.array_equal(right, EMPTY + 1)
        assert np.array_equal(background_of(recording, "S")[1], EMPTY + 2)


def test_the_background_of_a_side_by_side_video_is_split_with_it(tmp_path):
    clip(tmp_path / "in" / "zed.mp4", lambda k: numbered(k, 2 * WIDTH), frames=2)
    write_png(tmp_path / "in" / "background.png", np.hstack([EMPTY, EMPTY + 100]))
    recording = make_recording(chosen(tmp_path / "in"), tmp_path / "out")
    left, right = background_of(recording, "zed")
    assert np.array_equal(left, EMPTY)
    assert np.array_equal(right, EMPTY + 100)


def test_a_background_of_another_size_is_refused(tmp_path):
    clip(tmp_path / "in" / "A.mp4", frames=2)
    write_png(tmp_path / "in" / "A_background.png", EMPTY[::2, ::2])
    with pytest.raises(InputError, match="the background of A has 32 x 24 pixels"):
        make_recording(chosen(tmp_path / "in"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_depth_in_metres_as_floating_point_numbers(tmp_path):
    folder = tmp_path / "in" / "O_depth"
    folder.mkdir(parents=True)
    for k in range(3):
        depth = np.full((HEIGHT, WIDTH), 2.5 + 0.1 * k, np.float32)
        depth[:, :4], depth[:, 4:8] = np.nan, 0.0
        cv2.imwrite(str(folder / f"{k:04d}.tiff"), depth)
    choices = chosen(tmp_path / "in", fps=10.0)
    assert choices.uses[0].source.unit == 0.0005
    shown = frames_of(make_recording(choices, tmp_path / "out"))[2]["O"].depth
    assert np.allclose(shown[:, 8:], 2.7, atol=0.0003)
    assert np.isnan(shown[:, :8]).all()


def test_a_mask_goes_with_its_depth_map(tmp_path):
    for name in ("O_depth", "O_mask", "P_mask"):
        images(tmp_path / "in" / name, depth=name == "O_depth")
    for path in (tmp_path / "in" / "O_mask").iterdir():
        write_png(path, EMPTY > 20)
    choices = chosen(tmp_path / "in", fps=10.0)
    uses = [(use.role, use.view) for use in choices.uses]
    assert uses == [("depth", "O"), ("mask", "O"), ("unused", "P_mask")]
    shown = frames_of(make_recording(choices, tmp_path / "out"))
    assert np.array_equal(shown[3]["O"].mask, EMPTY > 20)
