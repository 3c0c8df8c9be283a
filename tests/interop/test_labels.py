"""Labels of other tools come back as they were written, or are refused in words."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.coco import read_coco, write_coco
from stereotrack_core.interop.deeplabcut import file_of_camera, read_deeplabcut, write_deeplabcut
from stereotrack_core.interop.label_source import LabelSource, frame_of, map_names
from stereotrack_core.interop.labels import read_labels, write_clicks
from stereotrack_core.interop.sleap import read_sleap, write_sleap
from stereotrack_core.recording.writing import write_png
from tests.interop.coco_files import coco_file
from tests.recording.small import filmless

CAMERAS = ("N_left", "N_right", "S")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return filmless(tmp_path_factory.mktemp("r"), *CAMERAS)


numbers = st.floats(-0.5, 47.5).map(lambda value: round(value, 3) + 0.0)
keys = st.tuples(st.integers(0, 300), st.sampled_from(CAMERAS), st.sampled_from(NINE.names))
clicks = st.dictionaries(
    keys,
    st.one_of(st.none(), st.tuples(numbers, numbers, st.sampled_from((1, 2)))),
    min_size=1,
    max_size=30,
).map(
    lambda found: [
        Click(*key, None, Visibility.OUTSIDE, origin="imported")
        if value is None
        else Click(*key, value[:2], Visibility(value[2]), origin="imported")
        for key, value in sorted(found.items())
    ]
)
several = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@several
@given(written=clicks)
def test_coco_round_trip(recording, tmp_path, written):
    path = tmp_path / "labels.json"
    write_coco(path, written, recording, NINE)
    found = read_labels(LabelSource(path, recording, NINE.names), 301)
    assert not found.problems
    assert sorted(found.clicks, key=lambda one: one.key) == written
    assert found.left_out == ()


@several
@given(written=clicks, camera=st.sampled_from(CAMERAS))
def test_deeplabcut_round_trip(recording, tmp_path, written, camera):
    path = tmp_path / "labels.csv"
    own = [one for one in written if one.camera == camera]
    write_deeplabcut(path, own, NINE.names)
    found = read_labels(LabelSource(path, recording, NINE.names))
    places = {one.key: one.position for one in own if one.position is not None}
    assert not found.problems
    assert {one.key: one.position for one in found.clicks} == places


def test_sleap_round_trip(recording, tmp_path):
    pytest.importorskip("sleap_io")
    rng, path = np.random.default_rng(6), tmp_path / "labels.slp"
    written = [
        Click(
            frame, camera, name, tuple(rng.uniform(-0.5, 47.5, 2).round(3).tolist()),
            Visibility(int(rng.integers(1, 3))), origin="imported",
        )
        for frame in (0, 7, 300)
        for camera in CAMERAS
        for name in NINE.names
        if rng.random() < 0.8
    ]  # fmt: skip
    write_sleap(path, written, recording, NINE)  # in a process of its own
    found = read_labels(LabelSource(path, recording, NINE.names), 301)
    assert not found.problems
    assert sorted(found.clicks, key=lambda one: one.key) == sorted(written, key=lambda one: one.key)


def test_sleap_needs_its_library(recording, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "sleap_io", None)
    path = tmp_path / "a.slp"
    with pytest.raises(InputError, match="sleap-io, which is not installed"):
        write_sleap(path, [], recording, NINE)
    with pytest.raises(InputError, match="sleap-io, which is not installed"):
        read_labels(LabelSource(path, recording, NINE.names))


def test_streams_that_begin_later_keep_their_frames_in_sleap(recording, tmp_path):
    pytest.importorskip("sleap_io")
    view = recording.view("S")
    later = replace(view, image=replace(view.image, frames="S_cam.mp4", first_frame=4))
    shifted = replace(recording, views=(recording.views[0], later))
    click = Click(3, "S", "head", (5.0, 6.0), origin="imported")
    path = tmp_path / "a.slp"
    write_sleap(path, [click], shifted, NINE)
    assert read_sleap(LabelSource(path, shifted, NINE.names)).clicks == (click,)
    early = read_sleap(LabelSource(path, recording, NINE.names, camera="S"))
    assert [one.frame for one in early.clicks] == [7]
    (tmp_path / "bad.slp").write_bytes(b"no labels")
    with pytest.raises(InputError, match="not a SLEAP labels file"):
        read_sleap(LabelSource(tmp_path / "bad.slp", recording, NINE.names))


def test_labels_with_confidences_are_refused_as_predictions(recording, tmp_path):
    path = coco_file(tmp_path / "a.json", ["left_elbow", "head"], [1, 2, 1.0, 3, 4, 0.99])
    with pytest.raises(InputError, match=r"confidences \(0.99\).*import predictions"):
        read_labels(LabelSource(path, recording, NINE.names))


@several
@given(written=clicks)
def test_clicks_file_round_trip(recording, tmp_path, written):
    path = tmp_path / "clicks.csv"
    write_clicks(path, written, recording)
    found = read_labels(LabelSource(path, recording, NINE.names))
    assert not found.problems
    assert sorted(found.clicks, key=lambda one: one.key) == written


def test_deeplabcut_predictions_are_of_the_camera_that_is_said(recording, tmp_path):
    path = tmp_path / "walkDLC_resnet50.csv"
    path.write_text(
        "scorer,net,net,net,net,net,net\n"
        "bodyparts,LElbow,LElbow,LElbow,nose,nose,nose\n"
        "coords,x,y,likelihood,x,y,likelihood\n"
        "0,10.5,20.25,0.99,1,2,0.9\n"
        "1,11.5,20.25,0.2,1,2,0.9\n"
        "2,12.5,20.25,0.8,1,2,0.9\n"
    )
    found = read_labels(LabelSource(path, recording, NINE.names, camera="N"))
    places = {one.frame: one.position for one in found.clicks}
    assert places == {0: (10.5, 20.25), 2: (12.5, 20.25)}
    assert {one.camera for one in found.clicks} == {"N_right"}
    assert found.left_out == ("nose",)
    names = {"nose": "head"}
    named = read_labels(LabelSource(path, recording, NINE.names, camera="S", names=names))
    assert {one.landmark for one in named.clicks} == {"left_elbow", "head"}
    assert named.left_out == ()
    unsaid = read_labels(LabelSource(path, recording, NINE.names))
    assert "the camera of" in str(unsaid.problems[0])
    with pytest.raises(InputError, match="the camera of"):
        unsaid.checked()


def test_deeplabcut_with_three_columns_of_paths(recording, tmp_path):
    path = tmp_path / "CollectedData_A.csv"
    path.write_text(
        "scorer,,,A,A\nbodyparts,,,Head,Head\ncoords,,,x,y\n"
        "labeled-data,S,img0007.png,3.5,4.5\nlabeled-data,S,img0008.png,,\n"
        "labeled-data,S,img0009.png,90.5,4.5\nlabeled-data,X,img0009.png,9.5,4.5\n"
        "labeled-data,S,img0010.png,a,4.5\n"
    )
    found = read_labels(LabelSource(path, recording, NINE.names), 9)
    assert [one.key for one in found.clicks] == [ClickKey(7, "S", "head")]
    said = " ".join(map(str, found.problems))
    assert "the camera of" in said
    assert "head is 'a'" in said.lower()
    assert "the last frame is 8" in said


def test_several_people_are_refused(recording, tmp_path):
    path = tmp_path / "many.csv"
    path.write_text("scorer,a,a\nindividuals,p1,p2\nbodyparts,head,head\ncoords,x,y\n0,1,2\n")
    with pytest.raises(InputError, match="several individuals"):
        read_deeplabcut(LabelSource(path, recording, NINE.names, camera="S"))
    path = tmp_path / "many.json"
    write_coco(path, [Click(0, "S", "head", (1.0, 2.0))], recording, NINE)
    content = json.loads(path.read_text())
    content["annotations"].append({**content["annotations"][0], "id": 9})
    path.write_text(json.dumps(content))
    found = read_coco(LabelSource(path, recording, NINE.names))
    assert len(found.clicks) == 1
    assert "second person" in str(found.problems[0])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"images": [], "annotations": [], "categories": [{"id": 1, "name": "cat"}]}',
        '{"images": [], "annotations": [], "categories": [{"id": [1], "keypoints": ["head"]}]}',
    ],
)
def test_what_is_no_coco_file_is_refused(recording, tmp_path, text):
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"COCO|keypoints"):
        read_labels(LabelSource(path, recording, NINE.names))


def test_foreign_coco_is_told_by_its_file_names(recording, tmp_path):
    path = tmp_path / "cvat.json"
    keypoints = {"id": 3, "name": "person", "keypoints": ["left shoulder", "left_wrist"]}
    people = [
        {"id": 1, "image_id": 5, "category_id": 3, "keypoints": [1.5, 2.5, 2, 9, 9, 2]},
        {"id": 2, "image_id": 6, "category_id": 3, "keypoints": [1.5, 2.5, 1, 0, 0, 0]},
        {"id": 3, "image_id": 6, "category_id": 3, "keypoints": [1.5]},
        {"id": 4, "image_id": 99, "category_id": 3, "keypoints": [0] * 6},
        {"id": 5, "image_id": 5, "bbox": [0, 0, 1, 1]},
    ]
    images = [{"id": 5, "file_name": "N_left_0012.jpg"}, {"id": 6, "file_name": "data/N/13.png"}]
    content = {"images": images, "annotations": people, "categories": [keypoints]}
    path.write_text(json.dumps(content))
    found = read_labels(LabelSource(path, recording, NINE.names))
    first, second = found.clicks
    assert first.key == (12, "N_left", "left_shoulder")
    assert second.key == (13, "N_right", "left_shoulder")
    assert second.visibility == Visibility.GUESSED
    assert found.left_out == ("left_wrist",)  # a wrist is not the middle of a hand
    assert len(found.problems) == 2


def test_names_are_matched_where_they_mean_the_same():
    theirs = ("LShoulder", "Elbow_R", "left-hand", "Head", "RHip")
    ours = ("left_shoulder", "right_elbow", "left_hand", "head", "right_hip")
    known = map_names([*theirs, "pelvis"], NINE.names)
    assert known == dict(zip(theirs, ours, strict=True))
    stated = map_names(["left_wrist", "head"], NINE.names, {"left_wrist": "left_hand"})
    assert stated["left_wrist"] == "left_hand"
    for names, said, words in (
        (["nose"], {}, "none of its landmarks"),
        (["L_hip", "left_hip"], {}, "both correspond to left_hip"),
        (["head"], {"nose": "head"}, "no landmark 'nose'"),
        (["head"], {"head": "nose"}, "unknown landmark 'nose'"),
    ):
        with pytest.raises(InputError, match=words):
            map_names(names, NINE.names, said)


def test_cameras_and_frames_are_told_from_names(recording):
    def camera_of(name, said=None):
        return LabelSource(Path("f"), recording, camera=said).camera_of(name, "f")

    assert camera_of("x/N_left/7.png") == "N_left"
    assert camera_of("x\\N\\7.png") == "N_right"
    assert camera_of("walk_N_left-12.png") == "N_left"
    assert camera_of("anything", "S") == "S"
    assert camera_of("trial_S.h5") == "S"
    others = [("walk.png", None), ("S_N_left.png", None), ("a.png", "X"), ("trial_S1.h5", None)]
    for name, said in (*others, ("S12.png", None), ("1S.png", None)):
        with pytest.raises(InputError):
            camera_of(name, said)
    numbered = "cam2/img_0012.png cam02.0012.json 0012_cam1.png 0012-c3.png cam12.h5"
    for name in numbered.split():
        assert frame_of(name, ["c3"], where="f") == 12
    assert frame_of("frame_0012_png.rf.8f3a9.jpg", where="f") == 12
    assert frame_of("1a" * 200_000 + "7.png", where="f") == 7  # not in the square of its length
    with pytest.raises(InputError, match="contains no number"):
        frame_of("picture.png", where="f")


@pytest.mark.parametrize("name", ["a/b", "..", "a\0b"])
def test_a_camera_whose_name_leads_elsewhere_is_not_written(recording, tmp_path, name):
    folder = tmp_path / "out"
    folder.mkdir()
    click = Click(0, name, "head", (5.0, 6.0), origin="imported")
    with pytest.raises(InputError, match="cannot be used as a folder name") as refusal:
        write_deeplabcut(folder / "a.csv", [click], NINE.names)
    assert refusal.value.where == str(folder / "a.csv")
    with pytest.raises(InputError, match="cannot be used as a folder name"):
        file_of_camera(folder / "a.csv", name)
    assert [each.name for each in tmp_path.rglob("*")] == ["out"]
    assert file_of_camera(folder / "a.csv", "cam 1.b") == folder / "a_cam 1.b.csv"


def test_clicks_of_a_camera_that_the_recording_does_not_have(recording, tmp_path):
    click = Click(0, "X", "head", (5.0, 6.0), origin="imported")
    with pytest.raises(InputError, match="no camera 'X'") as refusal:
        write_coco(tmp_path / "a.json", [click], recording, NINE)
    assert "N_left, N_right, S" in refusal.value.remedy
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"keypoints": [1, "2", 2]}, "1 triples of x, y and v"),
        ({"image": {"camera": "X"}}, "no camera 'X'"),
        ({"image": {"frame": -1}}, "is not a frame number"),
        ({"image": {"file_name": "S/" + "9" * 5000 + ".png"}}, "inf is not a frame number"),
        ({"image": {"id": 2}}, "image of this annotation is not in the file"),
    ],
)
def test_a_wrong_annotation_is_a_problem_of_its_own(recording, tmp_path, changes, words):
    path = coco_file(tmp_path / "a.json", ["head"], **{"keypoints": [1, 2, 2], **changes})
    found = read_labels(LabelSource(path, recording, NINE.names))
    assert len(found.problems) == 1
    assert re.search(words, str(found.problems[0]))
    assert found.problems[0].remedy
    assert not found.clicks


def test_sleap_shows_the_clicked_picture_behind_a_missing_number(recording, tmp_path):
    sio = pytest.importorskip("sleap_io")
    there = replace(recording, folder=tmp_path)
    (tmp_path / "S").mkdir()
    for number in (3, 4, 6, 7):
        write_png(tmp_path / "S" / f"{number}.png", np.full((48, 64), number, dtype=np.uint8))
    click = Click(3, "S", "head", (5.0, 6.0), origin="imported")
    path = tmp_path / "a.slp"
    write_sleap(path, [click], there, NINE)
    stored = sio.load_slp(str(path))
    assert stored.labeled_frames[0].image.max() == 6
    assert read_sleap(LabelSource(path, there, NINE.names)).clicks == (click,)
    gone = replace(click, frame=2)
    with pytest.raises(InputError, match="the picture of frame 2 in S is missing"):
        write_sleap(path, [click, gone], there, NINE)


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
