"""``info --deep`` measures pairs, clocks and depths, and ends with 2 where one is plainly wrong."""

import shutil

import pytest

from tests.conftest import QUICK


@pytest.fixture
def exchanged(recording, tmp_path):
    """The recording with the images of view N exchanged."""
    folder = tmp_path / "copy"
    shutil.copytree(recording, folder)
    for name in ("N_{}.mp4", "N_{}_background.png"):
        files = [folder / name.format(side) for side in ("left", "right")]
        if files[0].exists():
            aside = files[0].rename(folder / f"aside{files[0].suffix}")
            files[1].rename(files[0])
            aside.rename(files[1])
    return folder


def errors_of(ended):
    return [f for f in ended.json["findings"] if f["severity"] == "error"]


def test_images_that_are_exchanged_are_an_error(run, recording, exchanged):
    assert errors_of(run("info", recording, "--deep", "--json")) == []
    run("info", exchanged)
    [finding] = errors_of(run("info", exchanged, "--deep", "--json", status=2))
    assert finding["where"] == "view N"
    assert "wrong side" in finding["what"]
    assert "swap the files of left and right" in finding["remedy"]


@pytest.mark.slow
def test_what_has_one_cause_is_corrected_if_it_is_wanted(run, exchanged):
    before = (exchanged / "recording.toml").read_bytes()
    run("info", exchanged, "--correct", status=2)
    assert (exchanged / "recording.toml").read_bytes() == before
    assert "[--correct: Exchange" in run("info", exchanged, "--deep", status=2).out
    ended = run("info", exchanged, "--deep", "--correct", "--json")
    assert "Corrected. The file before is recording-before-1.toml." in ended.err
    [done] = ended.json["corrected"]
    assert done["words"] == "Exchange the files of left and right in view N."
    assert (exchanged / "recording-before-1.toml").read_bytes() == before


def test_what_is_plainly_wrong_is_not_tracked_unless_it_is_wanted(run, exchanged, tmp_path):
    output = tmp_path / "run.npz"
    command = ("track", exchanged, "-o", output, *QUICK[:-2], "--init", "tpose", "--frames", "0:2")
    refused = run(*command, status=2)
    assert "error: view N: " in refused.err
    assert "--despite-errors" in refused.err
    assert not output.exists()
    assert "view N" not in run(*command, "--views", "S").err  # the other view is sound
    assert "Error" not in run(*command, "--despite-errors").err
