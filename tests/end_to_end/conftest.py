"""A small recording as the program makes it, copies of it to damage, and the program itself."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from stereotrack_core.program import main

FRAMES = 12
FAST = (
    *("--preset", "fast", "--init", "tpose"),
    *("--set", "fit_shape=no", "--set", "least_focal=0"),
)
"""A run that is not about how the person is found or measured, nor about exact depths: these take
most of the time."""


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
    matter of chance: for whatever depends on that there is ``clear``.
    """
    small = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")
    return _rendered(tmp_path_factory.mktemp("end to end") / "sound", *small)


@pytest.fixture(scope="session")
def clear(tmp_path_factory) -> Path:
    """The same in pictures of the usual size, in which the body is found where it is."""
    return _rendered(tmp_path_factory.mktemp("end to end") / "clear")


def _rendered(folder: Path, *size: str) -> Path:
    frames = ("--frames", str(FRAMES), "--views", "NS", "--motion", "t-pose")
    assert main(["simulate", str(folder), *frames, *size]) == 0
    return folder


@pytest.fixture
def copy(sound, tmp_path) -> Path:
    """A copy of the sound recording that a test may damage."""
    folder = tmp_path / "damaged"
    shutil.copytree(sound, folder)
    return folder
