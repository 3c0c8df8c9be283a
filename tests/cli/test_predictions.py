"""Keypoints of a detector go into a project and out of it, apart from its clicks."""

import json

import pytest

from stereotrack_core.project.project import Project

pytestmark = pytest.mark.xdist_group("cli")

ROWS = (
    "frame,view,keypoint,x,y,confidence,person\n"
    "0,N,left_wrist,10.25,20.5,0.75,0\n0,N,nose,11.0,2.0,0.5,0\n"
    "0,N,nose,30.0,2.0,0.25,1\n0,N,tail,3.0,2.0,0.25,1\n1,N_left,head,5.0,6.0,1.0,0\n"
)


@pytest.fixture
def project(recording, tmp_path):
    path = tmp_path / "a.stereotrack"
    Project.create(path, recording, who="A").close()
    return path


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "rtm.csv"
    path.write_text(ROWS)
    return path


def test_predictions_are_kept_counted_and_written(run, project, file, tmp_path):
    ended = run("import", "predictions", file, "--into", project, "--json")
    assert ended.status == 0, ended.err
    facts = ended.json
    assert (facts["keypoints"], facts["of_landmarks"], facts["detectors"]) == (3, 3, "rtm")
    assert facts["left_out"] == {
        "of keypoints that are no part of the body's layouts": 1,
        "of other people": 1,
    }
    with Project.open(project, read_only=True) as opened:
        assert opened.clicks.count() == 0
        assert opened.keypoints.sources() == {"rtm": 3}
    out = tmp_path / "out.csv"
    assert run("export", project, "--predictions", "--format", "csv", "-o", out).status == 0
    lines = out.read_text().splitlines()
    assert lines[1] == "0,N,left_wrist,10.250,20.500,0.75,0,rtm"
    assert lines[3].startswith("1,N_left,head,")
    again = run("import", "predictions", out, "--into", project, "--json").json
    assert (again["keypoints"], again["left_out"]) == (3, {})
    results = tmp_path / "out.json"
    coco = ("--format", "coco", "-o", results)
    ended = run("export", project, "--predictions", "rtm", *coco)
    assert ended.status == 0
    assert "1 that COCO does not have left out" in " ".join(ended.out.split())
    assert len(json.loads(results.read_text())) == 1
