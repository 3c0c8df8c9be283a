"""``stereotrack track --keypoints``: mono views, from a detector's file and from a project."""

from dataclasses import replace

import pytest

from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.project.project import Project
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth


@pytest.fixture
def mono(tmp_path):
    """Folder of four mono views, and a file of keypoints."""
    (tmp_path / "mono").mkdir()
    recording = mono_recording(tmp_path / "mono")
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3))
    path = tmp_path / "keypoints.csv"
    write_table(path, keypoints, recording)
    return recording.folder, path


def test_a_file_and_a_project_give_the_same_run(run, mono, tmp_path):
    folder, file = mono
    first, second = tmp_path / "first.npz", tmp_path / "second.npz"
    ended = run("track", folder, "-o", first, "--keypoints", file, "--json")
    assert ended.json["tracked"] == FRAMES
    project = tmp_path / "mono.stereotrack"
    Project.create(project, folder, who="A").close()
    run("import", "predictions", file, "--into", project)
    run("track", folder, "-o", second, "--keypoints", project)
    runs = [read_npz(path) for path in (first, second)]
    assert runs[0].meta["keypoints"] == runs[1].meta["keypoints"]
    assert (runs[0].x == runs[1].x).all()
    again = ("track", folder, "-o", tmp_path / "again.npz", "--like", first)
    for more in ((), ("--keypoints", file)):  # the run holds those that it used
        ended = run(*again, *more)
        assert (read_npz(tmp_path / "again.npz").x == runs[0].x).all()
    write_npz(first, replace(runs[0], keypoints=None))  # as older versions wrote it
    assert "the run used keypoints of simulated" in run(*again, status=2).err


def test_one_of_two_people_is_tracked_by_name(run, mono, tmp_path):
    folder, file = mono
    header, *lines = file.read_text().splitlines()
    both = [header]
    for line in lines:
        cells = line.split(",")
        both.append(",".join((*cells[:6], "patient", cells[7])))
        x = str(float(cells[3]) + 25.0)
        sure = "0.99" if int(cells[0]) % 2 else "0.2"
        both.append(",".join((*cells[:3], x, cells[4], sure, "therapist", cells[7])))
    file.write_text("\n".join(both) + "\n")
    out = ("-o", tmp_path / "run.npz", "--keypoints", file)
    ended = run("track", folder, *out, "--person", "patient", "--json")
    assert ended.json["warnings"] == []
    assert "2 people (patient, therapist): patient is kept in all frames, as stated" in ended.err
    assert "would have changed" in ended.err
    nobody = run("track", folder, *out, "--person", "nurse", status=2)
    assert "no person 'nurse'" in nobody.err
    assert "patient, therapist" in nobody.err
    alone = run("track", folder, "-o", tmp_path / "a.npz", "--layout", "coco17", status=2)
    assert "Give the keypoints with --keypoints" in alone.err
