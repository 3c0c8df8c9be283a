"""ROS bags become recordings with the right frames and depths."""

import sys

import numpy as np
import pytest

pytest.importorskip("rosbags")

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import problems_of
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.ros import read_topics
from stereotrack_core.recording.importing.sources import is_unmade, look_at
from stereotrack_core.recording.importing.synchronise import at_one_rate
from tests.recording.importing.bags import BEGIN, KINDS, Bag, depth_bag, stereo_bag
from tests.recording.importing.clips import HEIGHT, WIDTH, chosen, frames_of, numbered


def made(path, out):
    choices = at_one_rate(chosen(path))
    assert not list(problems_of(choices))
    return make_recording(choices, out)


@pytest.mark.parametrize("kind", KINDS)
def test_a_stereo_camera(tmp_path, kind):
    path = stereo_bag(tmp_path / ("walk.bag" if kind == "rosbag1" else "walk"), kind)
    assert is_unmade(path)
    recording = made(path, tmp_path / "out")
    (view,) = recording.views
    assert (view.kind, view.name, recording.fps, recording.guessed) == ("stereo", "stereo", 20, 1)
    shown = frames_of(recording)[7]["stereo"]
    assert shown.left[0, 0] == pytest.approx(numbered(7)[0, 0], abs=1)
    assert shown.image[0, 0] == pytest.approx(numbered(7)[0, 0] + 5, abs=2)


@pytest.mark.parametrize("metres", [False, True])
def test_a_depth_camera_with_its_image(tmp_path, metres):
    recording = made(depth_bag(tmp_path / "walk", metres=metres), tmp_path / "out")
    (view,) = recording.views
    assert (view.kind, recording.fps) == ("depth", 30)
    shown = frames_of(recording)[4][view.name]
    assert np.allclose(shown.depth[:, 8:], 1.96, atol=1e-6)
    assert np.isnan(shown.depth[:, :8]).all()
    assert shown.image[0, 0] == pytest.approx(numbered(4)[0, 0], abs=1)


def test_topics_of_the_viewer_of_a_realsense_camera(tmp_path):
    with Bag(tmp_path / "walk.bag", "rosbag1") as bag:
        for name, focal in (("Depth_0", 42.0), ("Color_0", 61.0)):
            bag.info(f"/device_0/sensor_0/{name}/info/camera_info", "0", focal=focal)
        for k in range(3):
            at = BEGIN + k * 33_333_333
            counts = np.full((HEIGHT, WIDTH), 2000, np.uint16)
            bag.image("/device_0/sensor_0/Depth_0/image/data", counts, "mono16", at, "0")
            colour = np.repeat(numbered(k)[..., None], 3, axis=2)
            bag.image("/device_0/sensor_0/Color_0/image/data", colour, "rgb8", at, "0")
    choices = chosen(tmp_path / "walk.bag")
    assert {use.source.name: (use.role, use.view) for use in choices.uses} == {
        "depth": ("depth", "depth"),
        "color": ("image", "depth"),
    }
    assert "focal lengths of 42 and 61 pixels" in next(problems_of(choices)).what


def test_a_bag_without_images_names_its_topics(tmp_path):
    with Bag(tmp_path / "walk.bag", "rosbag1") as bag:
        bag.info("/left/camera_info", "left")
    with pytest.raises(InputError, match=r"no images; its topics are /left/camera_info"):
        look_at([tmp_path / "walk.bag"])


def test_a_bag_that_was_cut_off_is_refused_in_a_sentence(tmp_path):
    whole = stereo_bag(tmp_path / "walk.bag").read_bytes()
    path = tmp_path / "cut.bag"
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="the bag cannot be read"):
        look_at([path])


def test_without_the_library_it_is_said_what_to_install(tmp_path, monkeypatch):
    path = stereo_bag(tmp_path / "walk.bag")
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(InputError, match=r"pip install 'stereotrack\[ros\]'"):
        read_topics(path)
