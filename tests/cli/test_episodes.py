"""``stereotrack episodes``: table, JSON, filters, exports, refusals."""

import dataclasses
import shutil

import pytest

from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.recording.landmarks import write_landmarks
from tests.evaluation.failure_segments.runs import recorded


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    """A run that loses its left forearm in frames 4 to 9, beside its recording."""
    folder = tmp_path_factory.mktemp("episodes")
    (folder / "recording").mkdir()
    _, run, truth = recorded(folder / "recording")
    write_npz(folder / "run.npz", run)
    write_landmarks(folder / "truth.csv", truth)
    return folder


def test_the_table_tells_frames_limbs_peak_and_cause(run, failing):
    ended = run("episodes", failing / "run.npz")
    assert ended.status == 0
    assert "1 failure in" in ended.out
    assert "4-9" in ended.out
    assert "left forearm" in ended.out
    assert "80°" in ended.out


def test_json_holds_the_evidence_and_how_well_signs_do(run, failing):
    told = run("episodes", failing / "run.npz", "--json", "--no-pictures").json
    (failure,) = told["episodes"]
    assert (failure["first"], failure["last"], failure["found"]) == (4, 9, "truth")
    assert failure["limbs"] == ["left_forearm"]
    assert {"cause", "confidence", "evidence"} <= set(failure["verdict"])
    assert told["without_truth"] == {
        "precision": None, "recall": 0.0, "true": 1, "found": 0, "called": 0, "right": 0,
    }  # fmt: skip
    assert told["rules"]["episode_error"] == 45.0


def test_filters_and_rules(run, failing):
    def count(*options):
        told = run("episodes", failing / "run.npz", "--json", "--no-pictures", *options).json
        return len(told["episodes"])

    assert count("--limb", "left_forearm") == count("--found", "truth") == 1
    assert count("--limb", "torso") == count("--found", "signs") == 0
    assert count("--set", "episode_error=120") == 0
    assert count("--set", "episode_least=1") == 0


def test_no_failure_is_said_in_one_sentence(run, failing):
    ended = run("episodes", failing / "run.npz", "--no-pictures", "--set", "episode_error=120")
    assert ended.status == 0
    assert ended.out == f"No failures in {failing / 'run.npz'}.\n"


def test_strips_and_a_video_are_written(run, failing, tmp_path):
    ended = run(
        "episodes", failing / "run.npz", "--no-pictures", "--view", "N",
        "--strips", tmp_path / "strips", "--video", tmp_path / "all.mp4",
    )  # fmt: skip
    assert ended.status == 0
    names = [path.name for path in (tmp_path / "strips").iterdir()]
    assert len(names) == 1
    assert names[0].startswith("0004-0009-left-forearm-")
    assert (tmp_path / "all.mp4").stat().st_size > 1000
    assert "1 strip written to" in ended.err


def test_a_run_alone_with_a_reference(run, failing, tmp_path):
    shutil.copy(failing / "run.npz", tmp_path / "alone.npz")
    truth = failing / "truth.csv"
    folder = failing / "recording"
    hidden = failing / "elsewhere"
    folder.rename(hidden)
    try:
        ended = run("episodes", tmp_path / "alone.npz", "--reference", truth, "--json")
        assert len(ended.json["episodes"]) == 1
        assert "classified from the run alone" in ended.err
        without = run("episodes", tmp_path / "alone.npz", "--json").json
        assert without["episodes"] == []
        assert "without_truth" not in without
        refused = run("episodes", tmp_path / "alone.npz", "--strips", tmp_path / "s")
        assert refused.status == 2
        assert "--recording" in refused.err
    finally:
        hidden.rename(folder)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--limb", "tail"), "left_forearm"),
        (("--cause", "ghosts"), "crossing"),
        (("--video", "film.avi"), ".mp4"),
        (("--set", "episode_error=-3"), "episode_error"),
        (("--view", "Q", "--strips", "x"), "--view: there is no view 'Q'"),
        (("--strips", "file/deep"), "file: there is no such folder"),
    ],
)
def test_wrong_input_is_refused_in_words(run, failing, tmp_path, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    ended = run("episodes", failing / "run.npz", "--no-pictures", *options)
    assert ended.status == 2
    assert words in ended.err
    assert "Traceback" not in ended.err
    assert ended.out == ""


def test_a_run_that_states_no_frame_rate_needs_its_recording(run, failing, tmp_path):
    stored = read_npz(failing / "run.npz")
    meta = {"recording": "gone"}
    write_npz(tmp_path / "old.npz", dataclasses.replace(stored, meta=meta))
    refused = run("episodes", tmp_path / "old.npz")
    assert refused.status == 2
    assert "frame rate" in refused.err
    ended = run("episodes", tmp_path / "old.npz", "--recording", failing / "recording")
    assert ended.status == 0
    assert "not the recording" not in ended.err


def test_a_recording_that_is_not_the_runs_is_told(run, failing, tmp_path):
    stored = read_npz(failing / "run.npz")
    meta = {**stored.meta, "fingerprint": "0" * 32}
    write_npz(tmp_path / "other.npz", dataclasses.replace(stored, meta=meta))
    options = ("--recording", failing / "recording", "--no-pictures")
    ended = run("episodes", tmp_path / "other.npz", *options)
    assert ended.status == 0
    assert "not the recording that was tracked" in ended.err
