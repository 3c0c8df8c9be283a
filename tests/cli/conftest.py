"""A small recording, and a way to run commands."""

import json
from dataclasses import dataclass

import pytest

from stereotrack_core.program import main


@dataclass(frozen=True)
class Ended:
    """What a command said."""

    out: str
    err: str

    @property
    def json(self):
        """Standard output as strict JSON."""
        return json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))


@pytest.fixture
def run(capsys):
    """Function that runs a command line in this process and checks its exit status."""

    def command(*arguments, window=None, status=0):
        found = main([str(argument) for argument in arguments], window=window)
        ended = Ended(*capsys.readouterr())
        assert found == status, ended.err
        assert "Traceback" not in ended.err
        return ended

    return command


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    """A tiny rendered recording: two stereo views, ten frames, a T pose at first."""
    folder = tmp_path_factory.mktemp("cli") / "tiny"
    small = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")
    frames = ("--frames", "10", "--views", "NS", "--motion", "t-pose")
    assert main(["simulate", str(folder), *frames, *small]) == 0
    return folder


@pytest.fixture(scope="session")
def tracked(recording):
    """A run of the tiny recording."""
    path = recording.parent / "tiny.npz"
    assert main(["track", str(recording), "-o", str(path), "--preset", "fast"]) == 0
    return path
