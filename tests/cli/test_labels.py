"""Labels go into projects and out of them, and nothing of a person's is lost on the way."""

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project.clicks import DeleteClicks, PlaceClicks
from stereotrack_core.project.project import Project

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


def test_the_suffix_names_the_format(run, project, tracked, tmp_path):
    assert run("export", tracked, "-o", tmp_path / "a.bvh").status == 0
    assert (tmp_path / "a.bvh").read_text().startswith("HIERARCHY")
    facts = run("export", tracked, "--format", "angles", "-o", tmp_path / "a.csv", "--json").json
    assert facts["files"][str(tmp_path / "a.csv")] == "joint angles of 10 frames"
    assert run("export", project, "-o", tmp_path / "a.json").status == 0
    assert clicks_in(project)
    ended = run("export", tracked, "-o", tmp_path / "a.xyz")
    assert (ended.status, "means no format" in ended.err) == (2, True)


def test_other_tools_open_labels(run, project, empty, tmp_path):
    sio = pytest.importorskip("sleap_io")
    for kind, name in (("dlc", "d.csv"), ("slp", "s.slp")):
        ended = run("export", project, "--format", kind, "-o", tmp_path / name)
        assert ended.status == 0, ended.err
    stored = sio.load_slp(str(tmp_path / "s.slp"))
    places = [one.instances[0]["left_elbow"]["xy"].tolist() for one in stored.labeled_frames]
    assert sorted(places) == [[10.25, 20.5], [12.0, 20.5]]
    assert all(one.image.shape[:2] == (240, 320) for one in stored.labeled_frames)
    for name in ("s.slp", "d_N_left.csv"):
        assert run("import", "labels", tmp_path / name, "--into", empty).status == 0
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
        ended = run(*arguments)
        assert ended.status == 2, arguments
        assert words in ended.err
