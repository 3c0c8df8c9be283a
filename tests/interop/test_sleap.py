"""SLEAP's labels of numbered pictures, and of several videos."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.sleap import read_sleap, write_sleap
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png


@pytest.fixture
def recording(tmp_path):
    lens = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    cameras = {
        name: Camera(name, 64, 48, lens, np.zeros(5), False, RigidTransform.identity())
        for name in ("N", "S")
    }
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in cameras)
    return Recording(tmp_path, "walk", 10.0, views, cameras)


@pytest.mark.parametrize("pictures", [False, True])
def test_sleap_shows_the_clicked_picture_behind_a_missing_number(recording, tmp_path, pictures):
    sio = pytest.importorskip("sleap_io")
    (tmp_path / "S").mkdir()
    for number in (3, 4, 6, 7):
        write_png(tmp_path / "S" / f"{number}.png", np.full((48, 64), number, dtype=np.uint8))
    click = Click(3, "S", "head", (5.0, 6.0), origin="imported")
    path = tmp_path / "a.slp"
    write_sleap(path, [click], recording, NINE, pictures=pictures)
    stored = sio.load_slp(str(path))
    assert stored.labeled_frames[0].image.max() == 6
    assert read_sleap(LabelSource(path, recording, NINE.names)).clicks == (click,)
    gone = replace(click, frame=2)
    with pytest.raises(InputError, match="the picture of frame 2 in S is missing"):
        write_sleap(path, [click, gone], recording, NINE)
