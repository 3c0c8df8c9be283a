"""Labels go into projects and out of them, and nothing of a person's is lost on the way."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Prediction, Visibility
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project.clicks import AcceptPredictions, DeleteClicks, PlaceClicks
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import load_reference, save_reference

pytestmark = pytest.mark.xdist_group("cli")

CLICKS = (
    Click(0, "N_right", "left_elbow", (10.25, 20.5)),
    Click(0, "N_left", "left_elbow", (12.0, 20.5), Visibility.GUESSED),
    Click(3, "S_right", "head", None, Visibility.OUTSIDE),
)


@pytest.fixture
def project(recording, tmp_path):
    """Path of a project of the tiny recording, with three clicks."""
    path = tmp_path / "a.stereotrack"
    with Project.create(path, recording, who="A") as made:
        made.apply(PlaceClicks(CLICKS))
    return path


@pytest.fixture
def empty(recording, tmp_path):
    """Path of a project without clicks."""
    path = tmp_path / "b.stereotrack"
    Project.create(path, recording, who="B").close()
    return path


def clicks_in(path):
    with Project.open(path, read_only=True) as project:
        return {one.key: (one.position, one.visibility) for one in project.clicks.all()}


@pytest.mark.parametrize(("kind", "suffix"), [("csv", ".csv"), ("coco", ".json")])
def test_clicks_go_from_project_to_project(run, project, empty, tmp_path, kind, suffix):
    path = tmp_path / f"clicks{suffix}"
    assert run("export", project, "--format", kind, "-o", path).status == 0
    facts = run("import", "labels", path, "--into", empty, "--json").json
    assert (facts["taken"], facts["problems"]) == (3, 0)
    assert clicks_in(empty) == clicks_in(project)
    again = run("import", "labels", path, "--into", empty, "--json").json
    assert (again["taken"], again["the_same"]) == (0, 3)
    with Project.open(empty) as opened:
        opened.undo()
        assert opened.clicks.count() == 0


def test_the_source_of_clicks_is_kept_or_its_loss_is_said(run, project, empty, tmp_path):
    with Project.open(project) as opened:
        predicted = Prediction(5, "N_right", "head", "fit", (9.0, 9.0), 1.0)
        opened.apply(AcceptPredictions((predicted,)))
    for kind, suffix in (("csv", ".csv"), ("coco", ".json"), ("dlc", ".csv"), ("argus", ".csv")):
        path = tmp_path / f"{kind}{suffix}"
        ended = run("export", project, "--format", kind, "-o", path)
        lost = "which clicks are accepted or imported (1)"
        assert (lost in ended.err) is (kind in ("dlc", "argus"))
        assert ("which clicks are guessed (1)" in ended.err) is (kind in ("dlc", "argus"))
        assert "annotators and times (4)" in ended.err
    for path in (tmp_path / "csv.csv", tmp_path / "coco.json"):
        with Project.open(empty) as opened:
            opened.apply(DeleteClicks(tuple(one.key for one in opened.clicks.all())))
        taken = ("--conflicts", "theirs")
        assert run("import", "labels", path, "--into", empty, *taken).status == 0
        with Project.open(empty, read_only=True) as opened:
            origins = {one.key: one.origin for one in opened.clicks.all()}
        assert origins[predicted.key] == "accepted"
        assert sorted(origins.values()) == ["accepted", "hand", "hand", "hand"]


def test_deeplabcut_gets_a_file_for_each_camera(run, project, empty, tmp_path):
    facts = run("export", project, "--format", "dlc", "-o", tmp_path / "d.csv", "--json").json
    assert len(facts["files"]) == 3
    for camera in ("N_left", "N_right"):
        path = tmp_path / f"d_{camera}.csv"
        assert run("import", "labels", path, "--into", empty).status == 0
    assert set(clicks_in(empty)) == {CLICKS[0].key, CLICKS[1].key}


def test_what_contradicts_waits_for_a_decision(run, project, tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text(
        "frame,view,landmark,x,y,visibility\n0,N,left_elbow,50,60,2\n0,S,left_elbow,5,6,2\n"
        "0,N,head,5,6,2\n"
    )
    deleted = ClickKey(0, "N_right", "head")
    with Project.open(project) as opened:
        opened.apply(PlaceClicks((Click(*deleted, (1.0, 1.0)),)))
        opened.apply(DeleteClicks((deleted,)))
    before = clicks_in(project)
    ended = run("import", "labels", path, "--into", project)
    assert ended.status == 2
    assert "2 of its clicks contradict the project" in ended.err
    assert clicks_in(project) == before
    mine = run("import", "labels", path, "--into", project, "--conflicts", "mine", "--json").json
    assert (mine["taken"], mine["different"]) == (1, 2)
    assert deleted not in clicks_in(project)
    run("import", "labels", path, "--into", project, "--conflicts", "theirs")
    assert clicks_in(project)[CLICKS[0].key][0] == (50.0, 60.0)
    assert deleted in clicks_in(project)


def test_wrong_lines_stop_the_import_unless_they_may_be_left_out(run, empty, tmp_path):
    path = tmp_path / "x.csv"
    path.write_text(
        "frame,view,landmark,x,y,visibility\n0,N,head,50,60,2\n0,N,nose,5,6,2\n99,N,head,5,6,2\n"
    )
    ended = run("import", "labels", path, "--into", empty)
    assert ended.status == 2
    assert "unknown landmark 'nose'" in ended.err
    assert "frame 99 does not exist" in ended.err
    assert "2 of its lines cannot be read" in ended.err
    assert not clicks_in(empty)
    ended = run("import", "labels", path, "--into", empty, "--skip-problems", "--json")
    assert (ended.json["taken"], ended.json["problems"]) == (1, 2)


def test_names_can_be_said(run, empty, tmp_path):
    path = tmp_path / "S.csv"
    path.write_text("scorer,a,a\nbodyparts,left_wrist,left_wrist\ncoords,x,y\n2,5,6\n")
    ended = run("import", "labels", path, "--into", empty, "--camera", "S")
    assert ended.status == 2
    assert "none of its landmarks is known" in ended.err
    named = ("--name", "left_wrist=left_hand", "--camera", "S")
    assert run("import", "labels", path, "--into", empty, *named).status == 0
    assert list(clicks_in(empty)) == [ClickKey(2, "S_right", "left_hand")]
    assert run("import", "labels", path, "--into", empty, "--name", "x").status == 2


def test_trajectories_become_references_and_come_back(run, recording, project, tmp_path):
    path = tmp_path / "truth.trc"
    ended = run("export", recording / "reference.csv", "--format", "trc", "-o", path)
    assert ended.status == 2
    assert "--fps" in ended.err
    ended = run("export", recording / "reference.csv", "--format", "trc", "-o", path, "--fps", "10")
    assert ended.status == 0
    assert run("import", "labels", path, "--into", project, "--json").json["reference"] == "truth"
    assert run("import", "labels", path, "--into", project).status == 2
    assert run("import", "labels", path, "--into", project, "--conflicts", "theirs").status == 0
    truth = read_trajectory(recording / "reference.csv")
    for kind in ("csv", "trc", "c3d", "npz"):
        out = tmp_path / f"out.{kind}"
        ended = run("export", project, "--format", kind, "--reference", "-o", out)
        assert ended.status == 0, ended.err
        assert np.allclose(read_trajectory(out).points, truth.points, atol=1e-5, equal_nan=True)
    assert run("export", project, "--format", "bvh", "-o", tmp_path / "out.bvh").status == 0


def test_names_and_axes_of_a_foreign_trajectory_can_be_said(run, recording, project, tmp_path):
    path, csv = tmp_path / "theirs.trc", tmp_path / "out.csv"
    run("export", recording / "reference.csv", "--format", "trc", "-o", path, "--fps", "10")
    path.write_text(path.read_text().replace("left_hand", "LWrist"))
    said = ("--name", "LWrist=left_hand", "--axes", "z,x,y")
    truth = read_trajectory(recording / "reference.csv")
    assert run("export", path, "--format", "csv", "-o", csv, *said).status == 0
    assert np.allclose(read_trajectory(csv).points, truth.points, atol=1e-5, equal_nan=True)
    assert run("import", "labels", path, "--into", project, *said).status == 0
    with Project.open(project, read_only=True) as opened:
        kept = load_reference(opened.references, "theirs").points
    assert np.allclose(kept, truth.points, atol=1e-5, equal_nan=True)
    ended = run("export", csv, "--format", "csv", "-o", tmp_path / "again.csv", *said)
    assert ended.status == 2
    assert "Omit --name and --axes" in ended.err
    ended = run("import", "labels", path, "--into", project, "--axes", "x,y")
    assert ended.status == 2
    assert "three axes" in ended.err


def test_another_project_is_taken_in_with_author_flag_and_deletions(run, project, empty, tmp_path):
    with Project.open(project, who="A") as opened:
        opened.apply(PlaceClicks((Click(5, "S_right", "head", (4.0, 5.0), flag="uncertain"),)))
        opened.apply(DeleteClicks((CLICKS[0].key,)))
    with Project.open(empty) as opened:
        opened.apply(PlaceClicks((CLICKS[0],)))
    ended = run("import", "labels", project, "--into", empty)
    assert ended.status == 2
    assert "1 of its clicks contradicts the project" in ended.err
    assert run("import", "labels", project, "--into", empty, "--conflicts", "theirs").status == 0
    with Project.open(empty, read_only=True) as opened:
        flagged = opened.clicks.get(ClickKey(5, "S_right", "head"))
        assert (flagged.flag, flagged.who) == ("uncertain", "A")
        assert opened.clicks.get(CLICKS[0].key).deleted


def test_a_project_of_another_recording_is_refused(run, recording, project, tmp_path):
    folder = shutil.copytree(recording, tmp_path / "other")
    description = folder / "recording.toml"
    description.write_text(description.read_text() + "\n# another\n")
    Project.create(tmp_path / "o.stereotrack", folder).close()
    ended = run("import", "labels", tmp_path / "o.stereotrack", "--into", project)
    assert ended.status == 2
    assert "a different recording" in ended.err


def test_references_keep_their_uncertainty(run, project, tmp_path):
    points = np.random.default_rng(0).normal(size=(4, 9, 3))
    stated = Reference(np.arange(4), points, limb_sigma_deg=np.full((4, 6), 2.0))
    with Project.open(project) as opened:
        opened.apply(save_reference("one", stated))
        opened.apply(save_reference("two", Reference(np.arange(4), points)))
    path = tmp_path / "r.npz"
    ended = run("export", project, "--format", "npz", "-o", path)
    assert ended.status == 2
    assert "one, two" in ended.err
    assert run("export", project, "--format", "npz", "--reference", "one", "-o", path).status == 0
    assert np.array_equal(read_reference(path).limb_sigma_deg, stated.limb_sigma_deg)
    path = path.rename(tmp_path / "again.npz")
    run("import", "labels", path, "--into", project)
    with Project.open(project, read_only=True) as opened:
        kept = load_reference(opened.references, "again")
    assert np.array_equal(kept.limb_sigma_deg, stated.limb_sigma_deg)


def test_runs_are_exported(run, tracked, tmp_path):
    for kind in ("csv", "trc", "c3d", "bvh"):
        path = tmp_path / f"run.{kind}"
        assert run("export", tracked, "--format", kind, "-o", path).status == 0
        if kind != "bvh":
            expected = read_trajectory(tracked).points
            assert np.allclose(read_trajectory(path).points, expected, atol=1e-5, equal_nan=True)


def test_the_suffix_names_the_format(run, project, tracked, tmp_path):
    assert run("export", tracked, "-o", tmp_path / "a.bvh").status == 0
    assert (tmp_path / "a.bvh").read_text().startswith("HIERARCHY")
    facts = run("export", tracked, "-o", tmp_path / "a.mot", "--json").json
    assert facts["files"][str(tmp_path / "a.mot")] == "joint angles of 10 frames"
    assert run("export", project, "-o", tmp_path / "a.json").status == 0
    assert clicks_in(project)
    ended = run("export", tracked, "-o", tmp_path / "a.xyz")
    assert (ended.status, "means no format" in ended.err) == (2, True)


def test_a_run_goes_to_rerun_with_images_and_clouds(run, tracked, tmp_path):
    chunk = pytest.importorskip("rerun.chunk")
    path = tmp_path / "a.rrd"
    ended = run("export", tracked, "-o", path, "--frames", "2:4", "--views", "N")
    assert ended.status == 0, ended.err
    rows = {}
    for one in chunk.RrdReader(str(path)).stream():
        rows[one.entity_path] = rows.get(one.entity_path, 0) + one.num_rows
    assert rows["/world/cloud"] == rows["/world/cameras/N/image"] == rows["/world/landmarks"] == 2
    ended = run("export", tracked, "-o", path, "--frames", "20:30")
    assert (ended.status, "It has the frames 0:10" in ended.err) == (2, True)


@pytest.mark.parametrize("kind", ["dltdv", "argus", "xmalab"])
def test_tables_of_points_come_back(run, project, empty, tmp_path, kind):
    path = tmp_path / "points.csv"
    assert run("export", project, "--format", kind, "-o", path).status == 0
    assert len(path.read_text().splitlines()) == 11
    assert run("import", "labels", path, "--into", empty).status == 0
    places = {key: place for key, (place, _) in clicks_in(project).items() if place is not None}
    assert {key: place for key, (place, _) in clicks_in(empty).items()} == places


def test_other_tools_open_labels_with_their_pictures(run, project, empty, tmp_path):
    sio = pytest.importorskip("sleap_io")
    pytest.importorskip("tables")
    for kind, name in (("coco", "c.json"), ("dlc", "d.h5"), ("slp", "s.slp")):
        ended = run("export", project, "--format", kind, "--pictures", "-o", tmp_path / name)
        assert ended.status == 0, ended.err
    placed = {"N_right": [10.25, 20.5], "N_left": [12.0, 20.5]}
    own = tmp_path / "labeled-data"
    found = {
        camera: sio.load_dlc(own / camera / "CollectedData_stereotrack.csv") for camera in placed
    }
    for camera, place in placed.items():
        (labelled,) = found[camera].labeled_frames
        assert labelled.image.shape[:2] == (240, 320)
        assert labelled.instances[0]["left_elbow"]["xy"].tolist() == place
    coco = sio.load_coco(tmp_path / "c.json")
    assert all(one.image.shape[:2] == (240, 320) for one in coco.labeled_frames)
    shutil.move(tmp_path / "s.slp", tmp_path / "labeled-data" / "s.slp")  # it needs no recording
    for one in sio.load_slp(tmp_path / "labeled-data" / "s.slp").labeled_frames:
        assert one.image.shape[:2] == (240, 320)
    for path in (own / "s.slp", own / "N_left" / "CollectedData_stereotrack.h5"):
        assert run("import", "labels", path, "--into", empty).status == 0
        assert clicks_in(empty).keys() <= clicks_in(project).keys()
    ended = run("export", project, "--format", "csv", "--pictures", "-o", tmp_path / "x.csv")
    assert (ended.status, "names no pictures" in ended.err) == (2, True)


def test_refusals(run, recording, project, tracked, tmp_path):
    csv, json_ = tmp_path / "x.csv", tmp_path / "x.json"
    wrong = (
        (("export", project, "--format", "coco", "-o", csv), "must end in .json"),
        (("export", tracked, "--format", "coco", "-o", json_), "cannot be exported as coco"),
        (("export", project, "--format", "trc", "-o", tmp_path / "x.trc"), "no reference"),
        (("export", tracked, "--format", "csv", "--reference", "a", "-o", csv), "only projects"),
        (("export", tmp_path / "no.stereotrack", "--format", "csv", "-o", csv), "no.stereotrack"),
        (("export", project, "--format", "csv", "-o", recording / "x.csv"), "never written to"),
        (("import", "labels", tmp_path / "no.csv", "--into", project), "no such file"),
        (("import", "labels", tracked, "--into", tmp_path / "no.stereotrack"), "no.stereotrack"),
        (("import", "labels", tracked, "--into", project, "--camera", "N"), "belongs to no camera"),
        (("import", "labels", tmp_path / "x.mat", "--into", project), "COCO keypoints"),
    )
    (tmp_path / "x.mat").write_bytes(b"")
    other = Path(shutil.copy(project, tmp_path / "other.stereotrack"))
    wrong += ((("import", "labels", other, "--into", project, "--camera", "N"), "--camera"),)
    for arguments, words in wrong:
        ended = run(*arguments)
        assert ended.status == 2, arguments
        assert words in ended.err


def test_coco_file_says_what_other_tools_need(run, project, tmp_path):
    path = tmp_path / "c.json"
    run("export", project, "--format", "coco", "-o", path)
    content = json.loads(path.read_text())
    assert {one["file_name"] for one in content["images"]} >= {"N_right/000000.png"}
    assert all(len(one["keypoints"]) == 27 for one in content["annotations"])
    assert content["categories"][0]["keypoints"][0] == "left_shoulder"


def test_a_camera_with_a_slash_is_not_written_to_another_folder(run, recording, tmp_path):
    path, out = tmp_path / "a.stereotrack", tmp_path / "out"
    out.mkdir()
    with Project.create(path, recording, who="A") as made:
        there = (Click(0, "../S", "head", (1.0, 2.0)), Click(0, "N_left", "head", (1.0, 2.0)))
        made.apply(PlaceClicks(there))
    ended = run("export", path, "--format", "dlc", "-o", out / "x.csv")
    assert (ended.status, ended.out) == (2, "")
    assert "'../S' cannot be used as a folder name" in ended.err
    assert run("export", path, "--format", "coco", "-o", out / "x.json").status == 2
    assert not list(tmp_path.rglob("*.csv"))
