"""A small recording as the program makes it, copies of it to damage, and the program itself."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from stereotrack_core.program import main

FRAMES = 12
# A run that is not about how the person is found or measured, nor about exact depths: these take
# most of the time.
FAST = ("--preset", "fast", "--init", "tpose", "--set", "fit_shape=no", "--set", "least_focal=0")
# With which small pictures give enough points for every preset.
DENSE = ("--set", "speckle_size=10", "--set", "pixel_step=1", "--set", "match_window=9")
SMALL = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output as JSON."""
        return json.loads(self.out)

    @property
    def sentence(self) -> str:
        """The one line that a refusal is."""
        lines = self.err.strip().splitlines()
        assert self.status == 2, (self.status, self.out, self.err)
        assert len(lines) == 1, self.err
        assert "Traceback" not in self.err
        assert lines[0].startswith("stereotrack: ")
        assert lines[0].endswith(".")
        return lines[0]


@pytest.fixture
def run(capsys) -> Callable[..., Ended]:
    """Function that runs a command line in this process."""

    def command(*arguments: object) -> Ended:
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Ended(status, captured.out, captured.err)

    return command


@pytest.fixture(scope="session")
def sound(tmp_path_factory) -> Path:
    """A rendered recording of two stereo views in which nothing is wrong.

    Its pictures are so small that where limbs are, and whether enough of the body is seen, is a
    matter of chance.
    """
    return rendered(tmp_path_factory.mktemp("end to end") / "sound", *SMALL)


def rendered(folder: Path, *size: str, views: str = "NS") -> Path:
    """Simulate somebody in the T pose."""
    frames = ("--frames", str(FRAMES), "--views", views, "--motion", "t-pose")
    assert main(["simulate", str(folder), *frames, *size]) == 0
    return folder


@pytest.fixture(scope="session")
def whole(sound, tmp_path_factory) -> Path:
    """A fast run of the sound recording."""
    place = tmp_path_factory.mktemp("whole") / "whole.npz"
    assert main(["track", str(sound), "-o", str(place), *FAST]) == 0
    return place


@pytest.fixture
def copy(sound, tmp_path) -> Path:
    """A copy of the sound recording that a test may damage."""
    folder = tmp_path / "damaged"
    shutil.copytree(sound, folder)
    return folder
