"""Labels and keypoints go into projects and out of them; nothing of a person's is lost."""

import json

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project.clicks import delete_clicks, place_clicks
from stereotrack_core.project.project import Project

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
        made.apply(place_clicks(CLICKS))
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
    run("export", project, "--format", kind, "-o", path)
    facts = run("import", "labels", path, "--into", empty, "--json").json
    assert (facts["taken"], facts["problems"]) == (3, 0)
    assert clicks_in(empty) == clicks_in(project)
    again = run("import", "labels", path, "--into", empty, "--json").json
    assert (again["taken"], again["the_same"]) == (0, 3)
    with Project.open(empty) as opened:
        opened.undo()
        assert opened.clicks.count() == 0


def test_what_contradicts_waits_for_a_decision(run, project, tmp_path):
    path = tmp_path / "theirs.csv"
    rows = "0,N,left_elbow,50,60,2\n0,S,left_elbow,5,6,2\n0,N,head,5,6,2\n"
    path.write_text(f"frame,view,landmark,x,y,visibility\n{rows}")
    deleted = ClickKey(0, "N_right", "head")
    with Project.open(project) as opened:
        opened.apply(place_clicks((Click(*deleted, (1.0, 1.0)),)))
        opened.apply(delete_clicks((deleted,)))
    before = clicks_in(project)
    ended = run("import", "labels", path, "--into", project, status=2)
    assert "2 clicks already in the project differ" in ended.err
    assert clicks_in(project) == before
    mine = run("import", "labels", path, "--into", project, "--conflicts", "mine", "--json").json
    assert (mine["taken"], mine["different"]) == (1, 2)
    assert deleted not in clicks_in(project)
    run("import", "labels", path, "--into", project, "--conflicts", "theirs")
    assert clicks_in(project)[CLICKS[0].key][0] == (50.0, 60.0)
    assert deleted in clicks_in(project)


def test_wrong_lines_stop_the_import_unless_they_may_be_left_out(run, empty, tmp_path):
    path = tmp_path / "x.csv"
    rows = "0,N,head,50,60,2\n0,N,nose,5,6,2\n99,N,head,5,6,2\n"
    path.write_text(f"frame,view,landmark,x,y,visibility\n{rows}")
    ended = run("import", "labels", path, "--into", empty, status=2)
    assert "unknown landmark 'nose'" in ended.err
    assert "frame 99 does not exist" in ended.err
    assert "2 of its lines cannot be read" in ended.err
    assert not clicks_in(empty)
    ended = run("import", "labels", path, "--into", empty, "--skip-problems", "--json")
    assert (ended.json["taken"], ended.json["problems"]) == (1, 2)


def test_names_can_be_said(run, empty, tmp_path):
    path = tmp_path / "S.csv"
    path.write_text("scorer,a,a\nbodyparts,left_wrist,left_wrist\ncoords,x,y\n2,5,6\n")
    ended = run("import", "labels", path, "--into", empty, "--camera", "S", status=2)
    assert "none of its landmarks is known" in ended.err
    named = ("--name", "left_wrist=left_hand", "--camera", "S")
    run("import", "labels", path, "--into", empty, *named)
    assert list(clicks_in(empty)) == [ClickKey(2, "S_right", "left_hand")]
    run("import", "labels", path, "--into", empty, "--name", "x", status=2)


def test_trajectories_become_references_and_come_back(run, recording, project, tmp_path):
    path = tmp_path / "truth.trc"
    ended = run("export", recording / "reference.csv", "--format", "trc", "-o", path, status=2)
    assert "--fps" in ended.err
    ended = run("export", recording / "reference.csv", "--format", "trc", "-o", path, "--fps", "10")
    assert run("import", "labels", path, "--into", project, "--json").json["reference"] == "truth"
    run("import", "labels", path, "--into", project, status=2)
    run("import", "labels", path, "--into", project, "--conflicts", "theirs")
    truth = read_trajectory(recording / "reference.csv")
    for kind in ("csv", "trc", "c3d", "npz"):
        out = tmp_path / f"out.{kind}"
        ended = run("export", project, "--format", kind, "--reference", "-o", out)
        assert np.allclose(read_trajectory(out).points, truth.points, atol=1e-5, equal_nan=True)
    run("export", project, "--format", "bvh", "-o", tmp_path / "out.bvh")


def test_the_suffix_names_the_format(run, project, tracked, tmp_path):
    run("export", tracked, "-o", tmp_path / "a.bvh")
    assert (tmp_path / "a.bvh").read_text().startswith("HIERARCHY")
    facts = run("export", tracked, "--format", "angles", "-o", tmp_path / "a.csv", "--json").json
    assert facts["files"][str(tmp_path / "a.csv")] == "joint angles of 10 frames"
    run("export", project, "-o", tmp_path / "a.json")
    assert clicks_in(project)
    assert "means no format" in run("export", tracked, "-o", tmp_path / "a.xyz", status=2).err


def test_other_tools_open_labels(run, project, empty, tmp_path):
    sio = pytest.importorskip("sleap_io")
    for kind, name in (("dlc", "d.csv"), ("slp", "s.slp")):
        run("export", project, "--format", kind, "-o", tmp_path / name)
    stored = sio.load_slp(str(tmp_path / "s.slp"))
    places = [one.instances[0]["left_elbow"]["xy"].tolist() for one in stored.labeled_frames]
    assert sorted(places) == [[10.25, 20.5], [12.0, 20.5]]
    assert all(one.image.shape[:2] == (240, 320) for one in stored.labeled_frames)
    for name in ("s.slp", "d_N_left.csv"):
        run("import", "labels", tmp_path / name, "--into", empty)
        assert clicks_in(empty).keys() <= clicks_in(project).keys()


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
        (("import", "labels", tmp_path / "x.mat", "--into", project), "COCO keypoints"),
    )
    (tmp_path / "x.mat").write_bytes(b"")
    for arguments, words in wrong:
        assert words in run(*arguments, status=2).err


ROWS = (
    "frame,view,keypoint,x,y,confidence,person\n"
    "0,N,left_wrist,10.25,20.5,0.75,0\n0,N,nose,11.0,2.0,0.5,0\n"
    "0,N,nose,30.0,2.0,0.25,1\n0,N,tail,3.0,2.0,0.25,1\n1,N_left,head,5.0,6.0,1.0,0\n"
)


def test_predictions_are_kept_counted_and_written(run, empty, tmp_path):
    file = tmp_path / "rtm.csv"
    file.write_text(ROWS)
    ended = run("import", "predictions", file, "--into", empty, "--json")
    facts = ended.json
    assert (facts["keypoints"], facts["of_landmarks"], facts["detectors"]) == (3, 3, "rtm")
    unknown = "of keypoints that are no part of the body's layouts"
    assert facts["left_out"] == {unknown: 1, "of other people": 1}
    with Project.open(empty, read_only=True) as opened:
        assert opened.clicks.count() == 0
        assert opened.keypoints.sources() == {"rtm": 3}
    out = tmp_path / "out.csv"
    run("export", empty, "--predictions", "--format", "csv", "-o", out)
    lines = out.read_text().splitlines()
    assert lines[1] == "0,N,left_wrist,10.250,20.500,0.75,0,rtm"
    assert lines[3].startswith("1,N_left,head,")
    again = run("import", "predictions", out, "--into", empty, "--json").json
    assert (again["keypoints"], again["left_out"]) == (3, {})
    results = tmp_path / "out.json"
    coco = ("--format", "coco", "-o", results)
    ended = run("export", empty, "--predictions", "rtm", *coco)
    assert "1 that COCO does not have left out" in " ".join(ended.out.split())
    assert len(json.loads(results.read_text())) == 1
