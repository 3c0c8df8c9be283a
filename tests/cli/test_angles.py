"""Joint angles from the command line."""

import csv

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.evaluation.joint_angles.definitions import NAMES
from stereotrack_core.interop.reference_npz import write_reference
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import save_reference

pytestmark = pytest.mark.xdist_group("cli")


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_run_has_tables_and_a_row_for_every_frame(run, tracked, tmp_path):
    path = tmp_path / "angles.csv"
    ended = run("angles", tracked, "--reference", "-o", path)
    assert ended.status == 0
    assert "left shoulder elevation" in ended.out
    assert "left against right" in ended.out
    assert "Errors of the joint angles" in ended.out
    assert "cut-off 4 Hz, the highest possible at 10 frames per second" in ended.err
    rows = rows_of(path)
    first = rows[0]
    assert (first["frame"], first["seconds"]) == ("0", "0.0")
    assert [row["frame"] for row in rows] == [str(frame) for frame in range(10)]
    seen = next(row for row in rows if row["left_shoulder_elevation_deg"])
    for side in ("left", "right"):
        assert 0.0 < float(seen[f"{side}_shoulder_elevation_deg"]) < 180.0
        assert 0.5 < float(seen[f"{side}_shoulder_elevation_sigma_deg"]) < 45
    assert first["left_shoulder_elevation_acceleration_deg_s2"] == ""


def test_json_tells_ranges_sides_errors_and_how_it_was_smoothed(run, recording):
    reference = recording / "reference.csv"
    facts = run("angles", reference, "--cutoff", "2", "--reference", reference, "--json").json
    assert facts["cut_off_hz"] == 2.0
    whole = facts["stretches"][0]
    # a person in the T pose
    assert whole["angles"]["left_shoulder_elevation"]["mean"] == pytest.approx(90, abs=10)
    assert whole["angles"]["right_shoulder_plane"]["mean"] == pytest.approx(0, abs=10)
    assert whole["angles"]["torso_turn"]["mean"] == pytest.approx(0, abs=5)
    assert (whole["name"], whole["first"], whole["end"]) == ("all", 0, 10)
    assert set(whole["angles"]) == set(NAMES)
    assert whole["angles"]["left_shoulder_elevation"]["range_sigma"] is None
    assert set(whole["sides"]) == {
        "shoulder_plane", "shoulder_elevation", "shoulder_rotation", "elbow_flexion"
    }  # fmt: skip
    assert facts["errors"]["torso_turn"]["rms"] == pytest.approx(0, abs=1e-9)
    few = run("angles", reference, "--frames", "2:9", "--json").json["stretches"][0]
    assert (few["first"], few["end"]) == (2, 9)


def test_a_reference_states_how_uncertain_its_angles_are(run, recording, tmp_path):
    truth = read_trajectory(recording / "reference.csv")
    covariance = np.broadcast_to(0.005**2 * np.eye(3), (len(truth.frame), 9, 3, 3))
    path = tmp_path / "fitted.npz"
    write_reference(path, Reference(truth.frame, truth.points, covariance))
    refused = run("angles", path)
    assert (refused.status, "--fps" in refused.err) == (2, True)
    facts = run("angles", path, "--fps", 25, "--json").json
    elevation = facts["stretches"][0]["angles"]["right_shoulder_elevation"]
    # 5 mm at both ends of an upper arm of some 0.3 m, and the torso that it is measured against
    assert 1.1 < elevation["sigma"] < 2.5


def test_angles_are_exported_from_runs_and_projects(run, recording, tracked, tmp_path):
    path = tmp_path / "a.csv"
    ended = run("export", tracked, "--format", "angles", "-o", path, "--json")
    assert (ended.status, len(rows_of(path))) == (0, 10)
    truth = read_trajectory(recording / "reference.csv")
    project = tmp_path / "a.stereotrack"
    with Project.create(project, recording, who="A") as made:
        made.apply(save_reference("truth", Reference(truth.frame, truth.points)))
    out = tmp_path / "b.csv"
    assert run("export", project, "--format", "angles", "-o", out).status == 0
    direct = tmp_path / "c.csv"
    assert run("angles", recording / "reference.csv", "-o", direct).status == 0
    assert out.read_text() == direct.read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--cutoff", "0"], "--cutoff"),
        (["--cutoff", "nan"], "--cutoff"),
        (["--fps", "-1"], "--fps"),
        (["--frames", "90:99"], "--frames"),
        (["--segments"], "no segments"),
        (["-o", "angles.txt"], "angles.csv"),
        (["--reference", "nowhere.csv"], "nowhere.csv"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_sentence(run, recording, tmp_path, arguments, said):
    bare = tmp_path / "reference.csv"
    bare.write_bytes((recording / "reference.csv").read_bytes())
    rate = [] if "--fps" in arguments else ["--fps", "10"]
    ended = run("angles", bare, *rate, *arguments)
    assert (ended.status, ended.out) == (2, "")
    assert said in ended.err
    assert "Traceback" not in ended.err
    assert run("angles", tmp_path / "nothing.npz").status == 2


def test_a_reference_of_other_frames_is_refused(run, tracked, tmp_path):
    path = tmp_path / "late.csv"
    path.write_text("frame,landmark,x,y,z\n900,head,0,0,1\n")
    ended = run("angles", tracked, "--reference", path)
    assert ended.status == 2
    assert "contains none of the frames" in ended.err


def test_too_few_frames_are_said_to_be_too_few(run, tracked):
    ended = run("angles", tracked, "--frames", "3:5")
    assert ended.status == 0
    assert "in 5 consecutive frames" in ended.err


@pytest.mark.parametrize(("kind", "suffix"), [("angles", ".csv"), ("trc", ".trc")])
def test_a_file_without_frames_is_exported_without_frames(run, tmp_path, kind, suffix):
    path, output = tmp_path / "none.csv", tmp_path / f"out{suffix}"
    path.write_text("frame,landmark,x,y,z\n")
    ended = run("export", path, "--format", kind, "-o", output, "--fps", "10")
    assert ended.status == 0
    assert "0 frames" in ended.out
    assert output.is_file()
