"""Ctrl-C: what is done is kept, what stood there before is not harmed."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from stereotrack_core.cli import track_plan
from stereotrack_core.interop.run_file import read_run
from tests.end_to_end.conftest import FAST, FRAMES

DONE = 3


@pytest.fixture
def interrupted(monkeypatch):
    """Ctrl-C comes when so many frames are done."""

    @contextmanager
    def progress(what: str, total: int | None) -> Iterator[Callable[[int], None]]:
        yield lambda done, _now: signal.raise_signal(signal.SIGINT) if done == DONE else None

    monkeypatch.setattr(track_plan, "progress", progress)


@pytest.mark.usefixtures("interrupted")
@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_run_that_is_stopped_keeps_what_it_has(suffix, sound, tmp_path, run):
    place = (tmp_path / "run").with_suffix(suffix)
    told = run("track", sound, "-o", place, *FAST)
    assert told.status == 1
    assert f"Stopped after {DONE} of {FRAMES} frames; they are in {place}." in told.err
    if suffix == ".npz":
        assert read_run(place).frame.tolist() == list(range(DONE))
    scored = run("evaluate", place, "--reference", sound / "reference.csv", "--frames", f"0:{DONE}")
    assert scored.status == 0
