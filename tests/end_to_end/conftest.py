"""A small recording as the program makes it, copies of it to damage, and the program itself."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from stereotrack_core.program import main

FRAMES = 10
# With which small pictures give enough points for every preset.
DENSE = ("--set", "speckle_size=10", "--set", "pixel_step=1", "--set", "match_window=9")


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


@pytest.fixture
def copy(sound, tmp_path) -> Path:
    """A copy of the sound recording that a test may damage."""
    folder = tmp_path / "damaged"
    shutil.copytree(sound, folder)
    return folder
