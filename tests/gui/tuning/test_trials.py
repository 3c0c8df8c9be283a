"""Trials are tracked one after the other, and only those that are wanted are told of."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest

from app.features.tune.runner import Trials
from app.services.tasks.shared import Shared
from app.services.tasks.task import TaskList
from stereotrack_core.errors import Cancelled, InputError

PATIENCE_S = 300.0
A_MOMENT_S = 0.2
"""What must not happen gets so long; on a busy machine that proves less, and fails nothing."""


@dataclass(eq=False)
class Entry:
    """In place of an entry of the list of runs."""

    frames: dict = field(default_factory=dict)
    body = origin = wall_seconds = None


@dataclass(frozen=True)
class Tracked:
    """In place of a tracked frame."""

    frame: int

    def without_cloud(self):
        return self


@dataclass(eq=False)
class Trial:
    """In place of a trial, and of its pipeline; goes no further than it is let."""

    stretch: range
    error: Exception | None = None
    begins: threading.Event = field(default_factory=threading.Event)
    go: threading.Event = field(default_factory=threading.Event)
    body = "body"

    @contextmanager
    def begun(self, store, cancelled):
        self.begins.set()
        assert self.go.wait(PATIENCE_S)
        store.append(self)
        self.cancelled = cancelled
        yield self

    def origin(self):
        return "origin"

    def frames(self, stretch):
        for frame in stretch:
            if self.cancelled():
                raise Cancelled
            yield Tracked(frame)
        if self.error is not None:
            raise self.error


@pytest.fixture
def tasks(qtbot):
    made = TaskList()
    yield made
    made.shutdown()


@pytest.fixture
def store():
    """A list of what was tracked in place of clouds; knows in which thread it was closed."""
    made, closed_in = [], []
    shared = Shared(made, lambda: closed_in.append(threading.current_thread()))
    shared.closed_in = closed_in
    return shared


@pytest.fixture
def begin(tasks, store):
    """Function from trials to their entries, what is told of them, and their work."""
    turn = threading.Lock()

    def made(*trials):
        entries, told = [Entry() for _ in trials], []
        tried = list(zip(entries, trials, strict=True))
        work = Trials(tasks, store, turn, "tracking", tried)
        work.grown.connect(lambda grown: told.append([*grown.values()]))
        work.ended.connect(lambda: told.append("ended"))
        return entries, told, work

    return made


def test_frames_go_to_their_entries_in_their_order(qtbot, begin):
    trials = Trial(range(3)), Trial(range(5, 7))
    entries, told, _ = begin(*trials)
    for trial in trials:
        trial.go.set()
    qtbot.waitUntil(lambda: "ended" in told)
    assert [list(entry.frames) for entry in entries] == [[0, 1, 2], [5, 6]]
    assert {(entry.body, entry.origin) for entry in entries} == {("body", "origin")}
    assert sum(len(frames) for grown in told[:-1] for frames in grown) == 5
    assert told[-1] == "ended"


def test_what_is_cancelled_is_waited_for_and_not_told_of(qtbot, tasks, store, begin):
    """Two never use the clouds at once; a change of a parameter cancels."""
    first, second = Trial(range(2)), Trial(range(2))
    (early,), unheard, work = begin(first)
    assert first.begins.wait(PATIENCE_S)
    work.cancel()
    _, told, _ = begin(second)
    second.go.set()
    assert not second.begins.wait(A_MOMENT_S), "the one before is in the middle of something"
    first.go.set()
    qtbot.waitUntil(lambda: told[-1:] == ["ended"])
    qtbot.waitUntil(tasks.settled)
    assert store.resource == [first, second]
    assert (unheard, early.frames) == ([], {})


def test_a_failure_is_told_once_and_the_next_trials_are_done(qtbot, tasks, begin):
    wrong, right = Trial(range(1), InputError("no", remedy="Wait.")), Trial(range(1))
    failed = []
    tasks.failed.connect(failed.append)
    for trial in (wrong, right):
        trial.go.set()
        (entry,), told, _ = begin(trial)
        qtbot.waitUntil(lambda told=told: told[-1:] == ["ended"])
        assert list(entry.frames) == [0]
    assert failed == [wrong.error]


def test_the_last_user_closes_the_clouds_and_nothing_begins_with_closed_ones(
    qtbot, tasks, store, begin
):
    first, late = Trial(range(1)), Trial(range(1))
    begin(first)
    assert first.begins.wait(PATIENCE_S)
    store.close()
    assert store.closed_in == [], "somebody still uses it"
    late.go.set()
    _, told, _ = begin(late)
    first.go.set()
    qtbot.waitUntil(lambda: told == ["ended"])
    qtbot.waitUntil(tasks.settled)
    assert not late.begins.is_set()
    assert len(store.closed_in) == 1
    assert store.closed_in[0] is not threading.main_thread()
