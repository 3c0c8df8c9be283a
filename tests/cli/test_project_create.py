"""``stereotrack project create``: a project without the window."""

import shutil

from stereotrack_core.project.project import Project


def test_a_project_of_a_recording(run, recording, tmp_path):
    there = shutil.copytree(recording, tmp_path / "walk")
    facts = run("project", "create", there, "--annotator", "B", "--json").json
    path = tmp_path / "walk.stereotrack"
    assert facts["project"] == str(path)
    assert facts["landmarks"][0] == "left_shoulder"
    with Project.open(path, read_only=True) as project:
        assert project.clicks.count() == 0
        assert project.find_recording().folder == there
    assert "such a file already" in run("project", "create", there, "-o", path, status=2).err
    assert run("project", "create", there, "--json").json["project"].endswith("walk-2.stereotrack")


def test_refusals(run, recording, tmp_path):
    for arguments, words in (
        ((tmp_path / "nothing",), "no such folder"),
        ((recording, "-o", tmp_path / "a.db"), "must end in .stereotrack"),
        ((recording, "-o", recording / "a.stereotrack"), "never written to"),
        ((recording, "--landmarks", tmp_path / "x.toml"), "x.toml"),
    ):
        assert words in run("project", "create", *arguments, status=2).err
    assert not list(tmp_path.iterdir())
