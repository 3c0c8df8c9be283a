"""Views that are exchanged are warned of, and sound ones are not."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.program import main
from tests.end_to_end.conftest import FAST

SMALL = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Path:
    """A rendered recording of four stereo views."""
    folder = tmp_path_factory.mktemp("misfit") / "sound"
    frames = ("--frames", "6", "--views", "NOSW", "--motion", "t-pose")
    assert main(["simulate", str(folder), *frames, *SMALL]) == 0
    return folder


@pytest.fixture(scope="module")
def exchanged(sound) -> Path:
    """The same with the cameras of two views exchanged."""
    folder = sound.with_name("exchanged")
    shutil.copytree(sound, folder)
    description = folder / "recording.toml"
    other = {"N": "O", "O": "N"}
    text, count = re.subn(
        'camera = "([NO])_', lambda found: f'camera = "{other[found[1]]}_', description.read_text()
    )
    assert count == 4
    description.write_text(text)
    return folder


def tracked(run, folder, place):
    told = run("track", folder, "-o", place, *FAST, "--json")
    assert told.status == 0
    assert read_run(place).meta["warnings"] == told.json["warnings"]
    return told


def test_two_views_that_are_exchanged_are_warned_of(exchanged, tmp_path, run):
    told = tracked(run, exchanged, tmp_path / "run.npz")
    [warning] = [one for one in told.json["warnings"] if "the views are inconsistent" in one]
    assert f"warning: {warning}. Look for the cause" in told.err
    assert "stereotrack info --deep" in told.err


def test_sound_views_are_not(sound, tmp_path, run):
    told = tracked(run, sound, tmp_path / "run.npz")
    assert told.json["warnings"] == []
    assert "warning" not in told.err
