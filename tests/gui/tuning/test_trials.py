"""One thing at a time is computed from the clouds of trials, and only the newest is told of."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from PySide6.QtCore import QCoreApplication

from app.features.tune.runner import Request, TrialRunner, Trials
from app.services.tasks.shared import Shared

PATIENCE_S = 300.0
A_MOMENT_S = 0.2
"""What must not happen gets so long; on a busy machine that proves less, and fails nothing."""


class Held(Request):
    """Is in the middle of something until it is let go, and hears of nothing meanwhile."""

    def __init__(self, store, told, name="", error=None):
        super().__init__(store, self.hold, lambda error: told.append((self, error)))
        self.advanced = lambda: told.append((self, "advanced"))
        self.name, self.error = name, error
        self.begun, self.go = threading.Event(), threading.Event()

    def hold(self, store, _request):
        store.log.append(f"{self.name} begins")
        self.begun.set()
        assert self.go.wait(PATIENCE_S)
        store.log.append(f"{self.name} ends")
        self.tell_advance()
        if self.error is not None:
            raise self.error


class Store:
    """In place of a store of clouds; knows in which thread it was closed."""

    def __init__(self):
        self.log = []
        self.closed_in = None

    def close(self):
        self.closed_in = threading.current_thread()


@pytest.fixture
def store():
    made = Store()
    return Shared(made, made.close)


@pytest.fixture
def trials(qtbot):
    made = TrialRunner()
    made.told = []
    yield made
    made.close()


def test_two_never_use_the_clouds_at_once_and_only_the_newest_is_told_of(qtbot, trials, store):
    first, second, third = (Held(store, trials.told, name) for name in ("first", "second", "third"))
    trials.begin(first)
    assert first.begun.wait(PATIENCE_S)
    trials.begin(second)
    trials.begin(third)
    assert not third.begun.wait(A_MOMENT_S), "the one before is in the middle of something"
    assert [one.cancelled() for one in (first, second, third)] == [True, True, False]
    assert first.over.is_set()
    third.go.set()
    first.go.set()
    qtbot.waitUntil(third.over.is_set)
    assert store.resource.log == ["first begins", "first ends", "third begins", "third ends"]
    assert trials.told == [
        (first, None), (second, None), (third, "advanced"), (third, None)
    ]  # fmt: skip
    assert not second.begun.is_set()


def test_what_is_cancelled_is_waited_for_by_the_next_one_too(qtbot, trials, store):
    """A change of a parameter cancels; the attempt comes when the changes have stopped."""
    first, second = (Held(store, trials.told, name) for name in ("first", "second"))
    trials.begin(first)
    assert first.begun.wait(PATIENCE_S)
    trials.cancel(first)
    trials.begin(second)
    assert not second.begun.wait(A_MOMENT_S)
    second.go.set()
    first.go.set()
    qtbot.waitUntil(second.over.is_set)
    assert store.resource.log == ["first begins", "first ends", "second begins", "second ends"]
    assert trials.told == [(second, "advanced"), (second, None)]


def test_a_failure_is_told_and_the_next_request_is_done(qtbot, trials, store):
    error = RuntimeError("no clouds")
    wrong, right = Held(store, trials.told, error=error), Held(store, trials.told)
    for one in (wrong, right):
        one.go.set()
        trials.begin(one)
        qtbot.waitUntil(one.over.is_set)
    assert trials.told == [(wrong, "advanced"), (wrong, error), (right, "advanced"), (right, None)]


def test_closing_waits_for_nobody_and_the_last_user_closes_the_clouds(qtbot, trials, store):
    first, late = (Held(store, trials.told, name) for name in ("first", "late"))
    trials.begin(first)
    assert first.begun.wait(PATIENCE_S)
    thread = trials._worker._thread
    trials.close()
    store.close()
    assert thread.is_alive(), "closing waits for nothing"
    assert store.resource.closed_in is None, "somebody still uses it"
    trials.begin(late)
    qtbot.waitUntil(late.over.is_set)
    assert not late.begun.is_set(), "nothing begins with clouds that were closed"
    first.go.set()
    thread.join(PATIENCE_S)
    assert store.resource.closed_in is thread
    QCoreApplication.processEvents()
    assert trials.told == [(late, None)]


@dataclass(frozen=True)
class Tracked:
    """In place of a tracked frame."""

    frame: int

    def without_cloud(self):
        return self


@dataclass(eq=False)
class Entry:
    """In place of an entry of the list of runs."""

    frames: dict = field(default_factory=dict)
    body = origin = wall_seconds = None


@dataclass(frozen=True)
class Trial:
    """In place of a trial, whose pipeline gives all its frames."""

    stretch: range

    @contextmanager
    def begun(self, _store, _cancelled):
        yield self

    body = "body"

    def origin(self):
        return "origin"

    def frames(self, stretch):
        return map(Tracked, stretch)


def test_frames_wait_until_they_are_taken_in_their_order(qtbot, trials, store):
    entries = [Entry(), Entry()]
    tried = list(zip(entries, (Trial(range(3)), Trial(range(5, 7))), strict=True))
    told = trials.told
    request = Trials(
        tried, store, lambda error: told.append(error), lambda: told.append("advanced")
    )
    trials.begin(request)
    qtbot.waitUntil(request.over.is_set)
    assert request.take() == {entries[0]: [0, 1, 2], entries[1]: [5, 6]}
    assert [sorted(entry.frames) for entry in entries] == [[0, 1, 2], [5, 6]]
    assert {(entry.body, entry.origin) for entry in entries} == {("body", "origin")}
    assert request.take() == {}
    assert told == ["advanced", None]
