"""Work in threads of its own tells the window how it ended, and leaves nothing behind there."""

import threading
import weakref

import pytest

from app.services.tasks.newest import LatestOnly
from app.services.tasks.task import TaskList, wait_for_threads
from stereotrack_core.errors import Cancelled, InputError

PATIENCE_S = 300.0
"""Waiting ends with the event that is waited for; this ends it where that never comes."""


class Held:
    """Work that is in the middle of something until it is let go."""

    def __init__(self):
        self.begun, self.go = threading.Event(), threading.Event()

    def __call__(self, question=None):
        self.begun.set()
        assert self.go.wait(PATIENCE_S)
        return question


def destroyed_in(thing):
    """List that will name the thread in which the last reference to a thing has gone."""
    where = []
    weakref.finalize(thing, lambda: where.append(threading.current_thread()))
    return where


def _ends(task, told):
    """Connect when the work is over already, as somebody does who is late."""
    assert task.join(10.0)
    for name in ("stopped", "failed", "finished", "ended"):
        getattr(task, name).connect(lambda *_what, name=name: told.append(name))


@pytest.mark.parametrize(
    ("error", "how"),
    [(None, "finished"), (InputError("x", remedy="y"), "failed"), (Cancelled(), "stopped")],
)
def test_who_connects_after_the_end_is_told_as_well(qtbot, error, how):
    def work(_task):
        if error is not None:
            raise error
        return 3

    tasks, told, done = TaskList(lambda _error: None), [], []
    _ends(tasks.begin("something quick", work, done.append), told)
    assert told == []
    qtbot.waitUntil(lambda: "ended" in told, timeout=10_000)
    assert told == [how, "ended"]
    assert done == ([3] if error is None else [])
    assert tasks.tasks == ()


def test_a_task_that_outlives_its_list_ends_in_the_window_s_thread(qtbot):
    tasks, held, told = TaskList(lambda _error: None), Held(), []
    task = tasks.begin("something long", lambda _task: held(), told.append)
    thread, where = task._thread, destroyed_in(task)
    assert held.begun.wait(PATIENCE_S)
    tasks.shutdown(0.0)
    del task
    held.go.set()
    thread.join(PATIENCE_S)
    qtbot.waitUntil(lambda: where != [], timeout=10_000)
    assert where == [threading.main_thread()]
    assert told == [], "nobody is there any more who could use what comes of it"


def test_the_program_waits_for_its_threads_but_not_for_ever(qtbot, kept):
    kept.close()  # whose threads live as long as it
    held = Held()
    newest = LatestOnly(held, "something asked", lambda *_: None, lambda *_: None)
    newest.ask("first")
    thread = newest._task._thread
    assert held.begun.wait(PATIENCE_S)
    newest.close()
    wait_for_threads(0.0)
    assert thread.is_alive()
    held.go.set()
    wait_for_threads(PATIENCE_S)
    assert not thread.is_alive()
