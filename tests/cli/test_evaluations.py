"""Joint angles, failures and other runs by ``stereotrack evaluate``."""

import csv
import dataclasses
import shutil

import numpy as np
import pytest

from stereotrack_core.annotation.provenance import Provenance
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.evaluation.joint_angles import NAMES
from stereotrack_core.interop.reference_npz import write_reference
from stereotrack_core.interop.run_file import read_run, read_trajectory, write_run
from stereotrack_core.project.entries import save_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.scenarios import keep_scenario
from stereotrack_core.recording.landmarks import write_landmarks
from tests.evaluation.failure_segments.runs import recorded


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    """A run that loses its left forearm in frames 4 to 9, beside its recording."""
    folder = tmp_path_factory.mktemp("failures")
    (folder / "recording").mkdir()
    _, run, truth = recorded(folder / "recording")
    write_run(folder / "run.npz", run)
    write_landmarks(folder / "truth.csv", truth)
    return folder


@pytest.fixture(scope="module")
def runs(tracked, tmp_path_factory):
    """Two runs of many frames, the second with half the errors, and what is true."""
    folder = tmp_path_factory.mktemp("runs")
    stored, frames = read_run(tracked), 160
    arrays = {
        name: np.concatenate([getattr(stored, name)] * frames)[:frames]
        for name in (
            *("x", "P", "tracked", "unexplained_fraction", "residual", "innovation"),
            *("limb_sigma_deg", "limb_lost", "seconds"),
        )
    }
    points = np.tile(stored.landmarks[stored.tracked][0], (frames, 1, 1))
    for name, sigma in (("rough", 0.04), ("fine", 0.02), ("truth", 0.0)):
        errors = sigma * np.random.default_rng(round(1000 * sigma)).normal(size=points.shape)
        fields = {**arrays, "frame": np.arange(frames), "landmarks": points + errors}
        long = dataclasses.replace(stored, **fields)
        write_run(folder / f"{name}.npz", long)
        write_run(folder / f"{name}.csv", long)
    return folder


def with_meta(run, path, **meta):
    stored = read_run(run)
    write_run(path, dataclasses.replace(stored, meta={**stored.meta, **meta}))
    return path


def test_angles_of_a_run_are_tables(run, tracked):
    ended = run("evaluate", tracked, "--angles")
    for words in ("left shoulder elevation", "Errors of the joint angles"):
        assert words in ended.out


def test_angles_as_json_are_ranges_and_errors(run, recording):
    reference = recording / "reference.csv"
    arguments = ("evaluate", reference, "--angles", "--json")
    facts = run(*arguments, "--reference", reference).json["angles"]
    whole = facts["stretches"][0]
    # a person in the T pose
    assert whole["angles"]["left_shoulder_elevation"]["mean"] == pytest.approx(90, abs=10)
    assert whole["angles"]["right_shoulder_plane"]["mean"] == pytest.approx(0, abs=10)
    assert whole["angles"]["torso_turn"]["mean"] == pytest.approx(0, abs=5)
    assert (whole["name"], whole["first"], whole["end"]) == ("all", 0, 10)
    assert set(whole["angles"]) == set(NAMES)
    assert facts["errors"]["torso_turn"]["rms"] == pytest.approx(0, abs=1e-9)
    few = run(*arguments, "--frames", "2:9").json
    assert few["reference"] is None
    assert (few["angles"]["stretches"][0]["first"], few["angles"]["stretches"][0]["end"]) == (2, 9)


def test_angles_are_exported_from_runs_and_projects(run, recording, tracked, tmp_path):
    truth = read_trajectory(recording / "reference.csv")
    project, tables = tmp_path / "a.stereotrack", []
    with Project.create(project, recording, who="A") as made:
        made.apply(save_reference("truth", Reference(truth.frame, truth.points)))
    for k, source in enumerate((tracked, project, recording / "reference.csv")):
        path = tmp_path / f"{k}.csv"
        run("export", source, "--format", "angles", "-o", path)
        with path.open(newline="") as file:
            tables.append(list(csv.DictReader(file)))
    assert tables[1] == tables[2]
    first = tables[0][0]
    assert (first["frame"], first["seconds"]) == ("0", "0.0")
    assert [row["frame"] for row in tables[0]] == [str(frame) for frame in range(10)]
    seen = next(row for row in tables[0] if row["left_shoulder_elevation_deg"])
    assert 0.0 < float(seen["left_shoulder_elevation_deg"]) < 180.0


def test_failures_have_frames_limbs_peak_cause_and_evidence(run, failing):
    ended = run("evaluate", failing / "run.npz", "--failures")
    for words in ("1 failure in", "4-9", "left forearm", " 80 "):
        assert words in ended.out
    told = run("evaluate", failing / "run.npz", "--failures", "--json").json["failures"]
    (failure,) = told["list"]
    assert (failure["first"], failure["last"], failure["found"]) == (4, 9, "truth")
    assert failure["limbs"] == ["left_forearm"]
    assert {"cause", "confidence", "evidence"} <= set(failure["verdict"])
    assert told["rules"]["episode_error"] == 45.0


def test_failures_of_a_run_that_has_lost_its_recording(run, failing, tmp_path):
    gone = with_meta(failing / "run.npz", tmp_path / "gone.npz", recording_folder="/gone")
    arguments = ("evaluate", gone, "--failures", "--json")
    ended = run(*arguments, "--reference", failing / "truth.csv")
    assert len(ended.json["failures"]["list"]) == 1
    assert "classified from the run alone" in ended.err
    without = run(*arguments).json["failures"]
    assert without["list"] == []
    assert len(run(*arguments, "--recording", failing / "recording").json["failures"]["list"]) == 1


def test_the_better_run_is_named_in_a_sentence(run, runs):
    arguments = ("--reference", runs / "truth.csv", "--frames", "20:")
    against = ("--against", runs / "rough.npz", *arguments)
    ended = run("evaluate", runs / "fine.npz", *against)
    assert "B is better by" in ended.out
    assert "140 frames" in ended.out
    facts = run("evaluate", runs / "fine.npz", *against, "--json").json["against"]
    forearms = facts["measures"]["forearms"]
    assert facts["frames"] == 140
    assert forearms["low"] < forearms["difference"] < forearms["high"] < 0
    assert forearms["differs"]
    evaluated = run("evaluate", runs / "fine.npz", *arguments, "--json").json
    assert forearms["second_mean"] == pytest.approx(evaluated["measures"]["forearms"]["mean"])
    lost = facts["measures"]["lost"]["second_mean"]
    assert lost == pytest.approx(evaluated["lost_percent"])


def test_several_runs_are_compared_with_the_first(run, runs):
    files = (runs / "rough.npz", runs / "fine.npz", runs / "rough.npz")
    arguments = ("compare", *files, "--reference", runs / "truth.csv", "--frames", "20:")
    facts = run(*arguments, "--json").json
    assert [pair["run"] for pair in facts["pairs"]] == [str(file) for file in files[1:]]
    better, same = (pair["measures"]["forearms"]["difference"] for pair in facts["pairs"])
    assert better < 0.0 == same
    assert run(*arguments).out.count("B compared with A") == 2
    run("compare", files[0], status=2)


def test_the_recordings_own_reference_and_segments_are_used(run, recording, tracked, tmp_path):
    moved = tmp_path / "tiny"
    shutil.copytree(recording, moved)
    description = (moved / "recording.toml").read_text()
    if "segments" not in description:
        (moved / "recording.toml").write_text(f'segments = "segments.csv"\n{description}')
    (moved / "segments.csv").write_text("segment,first,end\nstart,0,4\nrest,4,10\n")
    here = with_meta(tracked, tmp_path / "a.npz", recording_folder=str(moved))
    arguments = ("evaluate", here, "--against", here, "--angles", "--segments")
    ended = run(*arguments)
    for words in ("start: B compared with A", "rest: B compared with A", "equal in every frame"):
        assert words in ended.out
    facts = run(*arguments, "--json").json
    assert [part["name"] for part in facts["against"]["segments"]] == ["start", "rest"]
    assert facts["against"]["segments"][0]["frames"] == 4
    assert [part["name"] for part in facts["angles"]["stretches"]] == ["all", "start", "rest"]


@pytest.mark.parametrize("spoilt", ["measured", "reference"])
def test_landmarks_in_millimetres_are_told(run, failing, tmp_path, spoilt):
    truth = read_trajectory(failing / "truth.csv")
    far = dataclasses.replace(truth, points=1000.0 * truth.points)
    for name, one in (("metres", truth), ("millimetres", far)):
        write_landmarks(tmp_path / f"{name}.csv", one)
    given = ("millimetres", "metres") if spoilt == "measured" else ("metres", "millimetres")
    measured, reference = (tmp_path / f"{name}.csv" for name in given)
    done = run("evaluate", measured, "--reference", reference)
    [told] = [line for line in done.err.splitlines() if "Landmarks must be in metres." in line]
    assert told.startswith(f"{tmp_path / 'millimetres.csv'}: its torso length is")


def test_named_stretches_of_a_project_have_a_row_each(run, recording, tracked, tmp_path):
    project = tmp_path / "own.stereotrack"
    with Project.create(project, recording) as made:
        for name, frames in (("fast", range(1, 3)), ("fast", range(4, 5)), ("slow", range(2, 4))):
            made.apply(keep_scenario(name, frames))
    facts = run("evaluate", tracked, "--scenarios", project, "--json").json
    found = {part["name"]: part["frames"] for part in facts["segments"]}
    assert (found["fast"], found["slow"]) == (3, 2)
    ended = run("evaluate", tracked, "--scenarios", project, "--against", tracked)
    assert "fast: B compared with A, means over 3 frames" in ended.out


def test_the_uncertainty_of_the_reference_leaves_out_and_weighs(run, runs, tmp_path):
    stored = read_run(runs / "truth.npz")
    sigma = np.where(stored.frame < 100, 0.005, 0.05)
    covariance = np.square(sigma)[:, None, None, None] * np.eye(3) * np.ones((1, 9, 1, 1))
    known = Reference(stored.frame, stored.landmarks, covariance, np.tile(sigma[:, None] * 200, 6))
    write_reference(tmp_path / "truth.npz", known)
    arguments = ("evaluate", runs / "fine.npz", "--reference", tmp_path / "truth.npz")
    ended = run(*arguments)
    assert "of which the reference's own is " in ended.out
    near = run(*arguments, "--max-sigma", 20, "--json").json
    assert near["frames"] == 100
    assert near["measures"]["forearms"]["reference_good_to"] == pytest.approx(1.0)
    assert "60" in run(*arguments, "--max-sigma", 20).err
    plain, weighed = (run(*arguments, *more, "--json").json for more in ((), ("--weigh",)))
    means = [one["measures"]["forearms"]["mean"] for one in (plain, weighed)]
    assert means[0] != means[1] == pytest.approx(means[0], rel=0.2)
    stated = Provenance.unknown(160, 9, "clicked")
    stated.source[130:] = "fit"
    write_reference(tmp_path / "truth.npz", dataclasses.replace(known, provenance=stated))
    assert run(*arguments, "--exclude", "fit", "--json").json["frames"] == 130
    for bare in (("--weigh",), ("--exclude", "fit")):
        run("evaluate", runs / "fine.npz", "--reference", runs / "truth.csv", *bare, status=2)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("{bare} --angles --fps -1", "--fps"),
        ("{run} --angles --reference {late}", "contains none of the frames"),
        ("{bare} --failures", "complete runs"),
        ("{run} --set episode_error=30", "--failures"),
        ("{run} --against {run} --frames 500:600", "have no frame in common"),
    ],
)
def test_wrong_input_is_one_sentence(run, recording, tracked, tmp_path, words, said):
    bare, late = tmp_path / "reference.csv", tmp_path / "late.csv"
    bare.write_bytes((recording / "reference.csv").read_bytes())
    late.write_text("frame,landmark,x,y,z\n900,head,0,0,1\n")
    places = {"bare": bare, "late": late, "run": tracked}
    ended = run("evaluate", *(word.format(**places) for word in words.split()), status=2)
    assert ended.out == ""
    assert said in ended.err
