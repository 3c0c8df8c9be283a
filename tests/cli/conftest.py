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
def recording(sound):
    """A tiny recording: two stereo views, ten frames, a T pose."""
    return sound


@pytest.fixture(scope="session")
def tracked(whole):
    """A run of the tiny recording."""
    return whole
