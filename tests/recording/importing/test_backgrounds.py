"""Pictures and videos of the empty scene beside the streams, and images of more than 8 bits."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png
from tests.recording.importing.clips import HEIGHT, WIDTH, clip, images, numbered

EMPTY = np.tile(np.arange(WIDTH, dtype=np.uint8), (HEIGHT, 1))


def chosen(*paths, **changes):
    return replace(propose(look_at(paths)), **changes)


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
    recording = make_recording(choices, tmp_path / "out")
    with FrameReader(recording, colour=False, read_ahead=0) as reader:
        shown = reader.frame_set(2).views["O"].depth
    assert np.allclose(shown[:, 8:], 2.7, atol=0.0003)
    assert np.isnan(shown[:, :8]).all()


def test_a_mask_goes_with_its_depth_map(tmp_path):
    for name in ("O_depth", "O_mask", "P_mask"):
        images(tmp_path / "in" / name, depth=name == "O_depth")
    for path in (tmp_path / "in" / "O_mask").iterdir():
        write_png(path, EMPTY > 20)
    choices = chosen(tmp_path / "in", fps=10.0)
    assert [(use.role, use.view) for use in choices.uses] == [
        ("depth", "O"),
        ("mask", "O"),
        ("unused", "P_mask"),
    ]
    recording = make_recording(choices, tmp_path / "out")
    with FrameReader(recording, colour=False, read_ahead=0) as reader:
        assert np.array_equal(reader.frame_set(3).views["O"].mask, EMPTY > 20)
