"""Files of other tools keep which clicks were accepted and which were made by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.recording.description import Recording, Stream, View


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    camera = Camera("S", 64, 48, np.eye(3), np.zeros(5), False, RigidTransform.identity())
    view = View("S", "mono", Stream("S", "S/%d.png"))
    return Recording(tmp_path_factory.mktemp("r"), "walk", 10.0, (view,), {"S": camera})


MIXED = (
    Click(3, "S", "head", (5.0, 6.0)),
    Click(3, "S", "left_hand", (7.25, 8.0), Visibility.GUESSED, origin="accepted"),
    Click(3, "S", "left_elbow", (9.0, 8.0), origin="accepted"),
)


def test_coco_tells_accepted_from_clicked(recording, tmp_path):
    path = tmp_path / "labels.json"
    outside = Click(3, "S", "right_hand", None, Visibility.OUTSIDE, origin="accepted")
    write_coco(path, (*MIXED, outside), recording, NINE)
    (annotation,) = json.loads(path.read_text())["annotations"]
    assert annotation["sources"][NINE.names.index("left_hand")] == "accepted"
    assert set(read_labels(LabelSource(path, recording, NINE.names)).clicks) == {*MIXED, outside}


def test_sleap_tells_accepted_from_clicked(recording, tmp_path):
    sleap = pytest.importorskip("sleap_io")
    path = tmp_path / "labels.slp"
    write_sleap(path, MIXED, recording, NINE)
    (labelled,) = sleap.load_slp(str(path), open_videos=False).labeled_frames
    (user,) = labelled.user_instances
    assert [user.from_predicted] == labelled.predicted_instances
    known = np.isfinite(user.from_predicted.numpy()).all(axis=1)
    assert known.tolist() == [name in ("left_hand", "left_elbow") for name in NINE.names]
    assert np.isfinite(user.points["xy"]).all(axis=1).sum() == 3, "SLEAP trains on all of them"
    found = read_labels(LabelSource(path, recording, NINE.names))
    origins = {one.landmark: one.origin for one in found.clicks}
    assert origins == {"head": "imported", "left_hand": "accepted", "left_elbow": "accepted"}
