"""Keypoints from the files of the usual detectors."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.reading import read_keypoints, write_table
from stereotrack_core.interop.keypoints.source import KeypointSource, Who, identified
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import COCO_17, LAYOUTS, MEDIAPIPE_33
from stereotrack_core.recording.keypoints import (
    changes_of_surest,
    keypoints_of,
    of_one_person,
    rows_of,
)
from tests.interop.coco_files import coco_file
from tests.recording.small import filmless


@pytest.fixture
def recording(tmp_path):
    return filmless(tmp_path, "cam1", "cam2", size=(640, 480))


def read(path: Path, recording: Recording, frames=None, **said):
    return read_keypoints(KeypointSource(path, recording, **said), frames)


def plain(found) -> list:
    return [row[:6] for row in rows_of(found.keypoints)]


def point(i: int) -> tuple[float, float]:
    return 100.0 + i, 200.0 + 2 * i


def test_openpose_folders_of_each_camera(recording, tmp_path):
    for camera in ("cam1", "cam2"):
        folder = tmp_path / "json" / camera
        folder.mkdir(parents=True)
        for frame in (3, 4):
            values = [v for i in range(25) for v in (*point(i), 0.0 if i == 8 else 0.5)]
            people = [{"person_id": [-1], "pose_keypoints_2d": values}] if frame == 3 else []
            path = folder / f"video_{frame:012d}_keypoints.json"
            path.write_text(json.dumps({"version": 1.3, "people": people}))
    found = read(tmp_path / "json", recording)
    assert len(found.keypoints) == 48
    assert found.left_out == {"without confidence": 2}
    where = LAYOUTS["body25"].index("left_wrist")
    assert (3, "cam2", "left_wrist", *point(where), 0.5) in plain(found)
    one = read(tmp_path / "json" / "cam1", recording)
    assert one.keypoints.cameras == ("cam1",)


def test_results_of_coco_come_back(recording, tmp_path):
    rows = []
    for k, camera in ((0, "cam1"), (0, "cam2"), (2, "cam1"), (2, "cam2")):
        sure = 0.25 + 0.125 * k
        rows += [(k, camera, n, *point(i), sure, "rtm", 0) for i, n in enumerate(COCO_17)]
    keypoints = keypoints_of([*rows, (0, "cam1", "neck", 1.0, 1.0, 1.0, "rtm", 0)])
    path = tmp_path / "results.json"
    assert write_results(path, keypoints, recording) == 1
    assert sorted(rows_of(read(path, recording).keypoints)) == sorted(rows)


def test_results_with_numbers_for_images_need_the_camera(recording, tmp_path):
    path = tmp_path / "results.json"
    values = [v for i in range(17) for v in (*point(i), 0.9)]
    entry = {"image_id": 7, "category_id": 1, "keypoints": values, "score": 0.9}
    path.write_text(json.dumps([entry, entry]))
    with pytest.raises(InputError, match=r"camera of .* cannot be determined"):
        read(path, recording)
    found = read(path, recording, camera="cam2")
    assert set(found.keypoints.frame.tolist()) == {7}
    assert set(found.keypoints.person.tolist()) == {0, 1}


def test_annotations_of_coco(recording, tmp_path):
    names, values = ["left_wrist", "nose", "left_eye"], [1, 2, 2, 3, 4, 1, 0, 0, 0]
    path = coco_file(tmp_path / "a.json", names, values, {"file_name": "cam1/000012.png"})
    found = read(path, recording)
    wrist, nose = plain(found)
    assert wrist == (12, "cam1", "left_wrist", 1.0, 2.0, 1.0)
    assert nose == (12, "cam1", "nose", 3.0, 4.0, 0.5)
    assert found.left_out == {"without confidence": 1}


def test_confidences_of_coco_are_told_by_the_whole_file(recording, tmp_path):
    values = [1, 2, 1.0, 3, 4, 0.99]
    image = {"file_name": "cam1/000012.png"}
    path = coco_file(tmp_path / "annotations.json", ["left_wrist", "nose"], values, image)
    assert [row[5] for row in plain(read(path, recording))] == [1.0, 0.99]
    results = tmp_path / "results.json"
    values = [v for i in range(17) for v in (*point(i), 2 if i % 2 else 1)]
    results.write_text(json.dumps([{"image_id": "cam1/000007.png", "keypoints": values}]))
    assert set(read(results, recording).keypoints.confidence.tolist()) == {0.5, 1.0}


@pytest.mark.parametrize("named", ["cam1.0003.json", "walk_000000000003.json"])
def test_openpose_is_known_by_what_its_files_hold(recording, tmp_path, named):
    folder = tmp_path / "cam1_json"
    folder.mkdir()
    values = [v for i in range(25) for v in (*point(i), 0.5)]
    people = [{"person_id": [k], "pose_keypoints_2d": values} for k in (7, 2)]
    (folder / named).write_text(json.dumps({"version": 1.3, "people": people}))
    (folder / "settings.json").write_text("{}")
    found = read(folder, recording)
    assert found.keypoints.cameras == ("cam1",)
    assert set(found.keypoints.frame.tolist()) == {3}
    assert set(found.people.values()) == {"2", "7"}
    assert len(read(folder / named, recording).keypoints) == len(found.keypoints)


@pytest.mark.parametrize("several", [False, True])
def test_mediapipe_as_json(recording, tmp_path, several):
    path = tmp_path / "cam1.json"
    marks = [{"x": 0.25 + i / 100, "y": 0.5, "z": 0, "visibility": 0.75} for i in range(33)]
    entry = {"frame": 4, "landmarks": [marks, marks] if several else marks}
    path.write_text(json.dumps([{"frame": 3, "landmarks": []}, entry]))
    found = read(path, recording)
    where = MEDIAPIPE_33.index("left_wrist")
    x = 640 * (0.25 + where / 100) - 0.5
    assert (4, "cam1", "left_wrist", pytest.approx(x), 239.5, 0.75) in plain(found)
    assert len(found.keypoints) == (66 if several else 33)


def test_frames_that_seem_to_be_counted_from_one_are_told(recording, tmp_path):
    path = tmp_path / "table.csv"
    rows = [(k, "cam1", "nose", 1.0, 2.0, 1.0, "d", 0) for k in (1, 2, 3)]
    write_table(path, keypoints_of(rows), recording)
    assert "run from 1 to 3 without a gap" in read(path, recording).notes[0]


def test_an_analysis_of_sleap(recording, tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "labels.000_cam2.analysis.h5"
    places = np.full((2, 2, 2, 4), np.nan)  # track, x y, node, frame
    places[0, :, 1, 3], places[1, :, 0, 2] = (5.0, 6.0), (7.0, 8.0)
    scores = np.full((2, 2, 4), 0.25)
    with h5py.File(path, "w") as stored:
        stored["tracks"], stored["point_scores"] = places, scores
        stored["node_names"], stored["track_names"] = [b"nose", b"left_wrist"], [b"me", b"you"]
    found = read(path, recording)
    nose, wrist = plain(found)
    assert nose == (2, "cam2", "nose", 7.0, 8.0, 0.25)
    assert wrist == (3, "cam2", "left_wrist", 5.0, 6.0, 0.25)
    assert [found.people[k] for k in found.keypoints.person.tolist()] == ["you", "me"]


def test_labels_of_deeplabcut_in_fixed_hdf5(recording, tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "CollectedData.h5"
    with h5py.File(path, "w") as stored:
        group = stored.create_group("df_with_missing")
        pictures = [f"labeled-data/cam2/img{k:03d}.png".encode() for k in (5, 20)]
        group["axis1"] = np.array(pictures)
        for axis in ("axis0", "block0_items"):
            levels = ([b"scorer"], [0, 0]), ([b"left_wrist"], [0, 0]), ([b"x", b"y"], [0, 1])
            for level, (names, codes) in enumerate(levels):
                group[f"{axis}_level{level}"] = np.array(names)
                group[f"{axis}_label{level}"] = np.array(codes, dtype=np.int8)
        group["block0_values"] = np.array([[1.0, 2.0], [np.nan, np.nan]])
    assert plain(read(path, recording)) == [(5, "cam2", "left_wrist", 1.0, 2.0, 1.0)]
    (label,) = read_labels(LabelSource(path, recording, ("left_wrist",))).clicks
    assert (label.frame, label.camera, label.position) == (5, "cam2", (1.0, 2.0))


@pytest.mark.parametrize("demo", [False, True])
def test_mmpose(recording, tmp_path, demo):
    path = tmp_path / "cam1.json"
    points = [list(point(i)) for i in range(26)]
    instance = {"keypoints": points, "keypoint_scores": [0.5] * 26, "bbox": [[0, 0, 1, 1]]}
    frames = [{"frame_id": k + demo, "instances": [instance]} for k in range(2)]
    content = {"meta_info": {"dataset_name": "halpe26"}, "instance_info": frames}
    path.write_text(json.dumps(content if demo else frames))
    found = read(path, recording)
    assert set(found.keypoints.frame.tolist()) == {0, 1}
    assert (1, "cam1", "head_top", *point(17), 0.5) in plain(found)


def test_an_array_of_freemocap(recording, tmp_path):
    array = np.full((2, 3, 75, 3), np.nan)
    array[1, 2, :, :2] = [point(i) for i in range(75)]
    np.save(tmp_path / "mediapipe_2d.npy", array)
    found = read(tmp_path / "mediapipe_2d.npy", recording)
    assert len(found.keypoints) == 33
    where = MEDIAPIPE_33.index("right_wrist")
    assert (2, "cam2", "right_wrist", *point(where), 1.0) in plain(found)
    assert sum(found.left_out.values()) == 42
    np.save(tmp_path / "three.npy", np.zeros((3, 3, 33, 2)))
    with pytest.raises(InputError, match="the array has 3 cameras, the recording 2"):
        read(tmp_path / "three.npy", recording)


def test_a_wide_table_with_shares_of_the_image(recording, tmp_path):
    path = tmp_path / "cam1.csv"
    header = "frame,left_wrist_x,left_wrist_y,left_wrist_visibility,LEFT_ELBOW_x,LEFT_ELBOW_y"
    path.write_text(f"{header}\n4,0.5,0.25,0.75,,\n5,0.5,0.5,0.5,0.25,0.5\n")
    found = read(path, recording)
    assert plain(found) == [
        (4, "cam1", "left_wrist", 319.5, 119.5, 0.75),
        (5, "cam1", "left_elbow", 159.5, 239.5, 1.0),
        (5, "cam1", "left_wrist", 319.5, 239.5, 0.5),
    ]
    assert found.left_out == {"without a place": 1}


def test_deeplabcut_with_individuals(recording, tmp_path):
    path = tmp_path / "cam2DLC_resnet50.csv"
    path.write_text(
        "scorer,a,a,a,a,a,a\nindividuals,one,one,one,two,two,two\n"
        "bodyparts,LWrist,LWrist,LWrist,LWrist,LWrist,LWrist\n"
        "coords,x,y,likelihood,x,y,likelihood\n0,1,2,0.25,3,4,0.75\n1,,,,5,6,1\n"
    )
    found = read(path, recording)
    assert plain(found)[0] == (0, "cam2", "left_wrist", 1.0, 2.0, 0.25)
    assert found.keypoints.person.tolist() == [0, 1, 1]
    assert plain_of(of_one_person(found.keypoints)) == [3.0, 5.0]


def plain_of(keypoints) -> list[float]:
    return keypoints.place[:, 0].tolist()


def test_deeplabcut_in_hdf5(recording, tmp_path):
    h5py = pytest.importorskip("h5py")
    import pickle

    path = tmp_path / "cam1DLC.h5"
    columns = [("scorer", "left_wrist", name) for name in ("x", "y", "likelihood")]
    kinds = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (3,))])
    with h5py.File(path, "w") as stored:
        rows = np.array([(0, (1.0, 2.0, 0.5)), (3, (4.0, 5.0, 0.75))], dtype=kinds)
        table = stored.create_group("df_with_missing").create_dataset("table", data=rows)
        table.attrs["values_block_0_kind"] = np.void(pickle.dumps(columns, 0))
    first, second = plain(read(path, recording))
    assert first == (0, "cam1", "left_wrist", 1.0, 2.0, 0.5)
    assert second == (3, "cam1", "left_wrist", 4.0, 5.0, 0.75)
    with h5py.File(path, "a") as stored:
        table = stored["df_with_missing"]["table"]
        table.attrs["values_block_0_kind"] = np.void(pickle.dumps(print, 0))
    with pytest.raises(InputError, match="not a DeepLabCut file"):
        read(path, recording)


def test_the_own_table_comes_back_and_counts_what_is_left_out(recording, tmp_path):
    path = tmp_path / "table.csv"
    rows = [
        (0, "cam1", "left_wrist", 1.25, 2.5, 0.75, "rtm", 0),
        (1, "cam2", "nose", 3.0, 4.0, 1.0, "rtm", 1),
        (9, "cam2", "nose", 3.0, 4.0, 1.0, "rtm", 1),
        (1, "cam2", "tail", 3.0, 4.0, 1.0, "rtm", 1),
    ]
    write_table(path, keypoints_of(rows), recording)
    found = read(path, recording, 5)
    assert list(rows_of(found.keypoints)) == rows[:2]
    late = "of frames that the recording does not have (0:5)"
    assert found.left_out == {late: 1, "of keypoints that are no part of the body's layouts": 1}
    named = read(path, recording, 5, names={"tail": "left_hand"}, detector="own")
    assert "left_hand" in named.keypoints.keypoint
    assert set(named.keypoints.source.tolist()) == {"own"}


@pytest.mark.parametrize("wide", [True, False])
@pytest.mark.parametrize(("fps", "late"), [(10.0, 2.0), (50.0, 0.0)])
def test_times_of_a_table_go_before_its_frame_numbers(recording, tmp_path, wide, fps, late):
    path, lines = tmp_path / "cam1.csv", []
    for k in range(40):
        x, time = 100 + k, f"{late + k / fps:.4f}"
        lines.append(f"{k + 1},{time},{x},50" if wide else f"{k + 1},{time},cam1,nose,{x},50")
    header = "frame,time,nose_x,nose_y" if wide else "frame,time,view,keypoint,x,y"
    path.write_text("\n".join([header, *lines]))
    found = read(path, recording, 40)
    frames = [round(10 * (late + k / fps), 6) for k in range(40)]
    wanted = [(int(f), 100.0 + k) for k, f in enumerate(frames) if f == int(f) and f < 40]
    assert [(row[0], row[3]) for row in plain(found)] == wanted
    start = round(late * fps)
    assert f"row of frame 1 has the time {late:g} s, which is frame {start}" in found.notes[0]
    assert ("nearest in time" in " ".join(found.notes)) == (fps != 10.0)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.txt", "x", "cannot be read from .txt"),
        ("a.csv", "frame,view,keypoint,x,y\n0,cam9,nose,1,2\n", "cannot be determined"),
        ("a.csv", "frame,view,keypoint,x,y\n0,cam1,tail,1,2\n", "no keypoint to use"),
        ("cam1.json", '[{"image_id": 1, "keypoints": [1, 2, 1]}]', "none of the usual layouts"),
        ("cam1.json", "{}", "not a COCO file"),
    ],
)
def test_what_cannot_be_read_is_said(recording, tmp_path, name, content, said):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=said):
        read(tmp_path / name, recording)


NAMES = ("nose", "left_hip", "right_hip")


def rows(people, *, named=False):
    """Rows of `people`: for each frame places (x, y) and confidences in the detector's order."""
    found = []
    for frame, picture in people.items():
        for place, (name, x, y, sure) in enumerate(picture):
            who = Who(place, name if named else "")
            for k, point in enumerate(NAMES):
                found.append((frame, "N", point, x + 5.0 * k, y + 40.0 * k, sure, "d", who))
    return found


def crossing(frames=30):
    """Two people who walk past each other, listed in an order of chance."""
    rng = np.random.default_rng(3)
    people = {}
    for k in range(frames):
        both = [("A", 100.0 + 8 * k, 200.0, 0.8), ("B", 340.0 - 8 * k, 260.0, 0.75)]
        both = [(name, x, y, sure + rng.uniform(-0.1, 0.1)) for name, x, y, sure in both]
        people[k] = both if rng.random() < 0.5 else both[::-1]
    return people


@pytest.mark.parametrize("named", [True, False])
def test_people_who_cross_keep_their_numbers(named):
    people = crossing()
    found, names = identified(rows(people, named=named))
    assert set(names.values()) == ({"A", "B"} if named else set())
    keypoints = keypoints_of(found)
    kept = of_one_person(keypoints)
    own = kept[kept.keypoint == "nose"]
    assert own.frame.tolist() == list(range(30))
    assert own.place[:, 0].tolist() == [100.0 + 8 * k for k in range(30)]
    surest = [max(one, key=lambda person: person[3])[0] for one in people.values()]
    changes = sum(a != b for a, b in pairwise(surest))
    assert changes > 5
    assert changes_of_surest(keypoints) == changes


def test_who_leaves_and_comes_back_is_the_same_and_a_passer_by_another():
    people = {k: [("A", 100.0, 200.0, 0.5)] for k in (*range(10), *range(30, 40))}
    for k in range(3, 8):
        people[k] = [("B", 500.0, 200.0, 0.9), *people[k]]
    kept = of_one_person(keypoints_of(identified(rows(people))[0]))
    assert set(kept.frame.tolist()) == set(people)
    assert kept.place[:, 0].max() < 200.0
