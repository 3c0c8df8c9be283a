"""Jobs in threads of their own tell the window's how they end; what comes too late is dropped."""

import gc
import threading
import weakref

import pytest

from app.session.jobs import Job, LatestOnly, NewestJob
from app.session.work_threads import wait_for_threads
from stereotrack_core.errors import Cancelled, InputError
from tests.session.plain_loop import PATIENCE_S


class Held:
    """Work that is in the middle of something until it is let go."""

    def __init__(self):
        self.begun, self.go = threading.Event(), threading.Event()

    def __call__(self, question=None):
        self.begun.set()
        assert self.go.wait(PATIENCE_S)
        return question


@pytest.mark.parametrize(
    ("error", "how"),
    [(None, "done"), (InputError("x", remedy="y"), "failed"), (Cancelled(), "stopped")],
)
def test_a_job_tells_how_it_ended(plain, tasks, failed, error, how):
    def work(task):
        task.tell("one")
        task.tell("two")
        task.report(0.5, "half")
        if error is not None:
            raise error
        return 3

    told, note = [], lambda name: lambda *_: told.append(name)
    words, progress = [], []
    job = Job(
        "work", work, note("done"), None, note("stopped"), note("ended"), words.extend,
        lambda *far: progress.append(far),
    )  # fmt: skip
    task = tasks.run(job)
    assert task.join(PATIENCE_S)
    assert (told, words, task.over) == ([], [], False), "all is told by the loop"
    plain.until(lambda: "ended" in told)
    assert told == (["ended"] if how == "failed" else [how, "ended"])
    assert failed == ([error] if how == "failed" else [])
    assert (words, progress) == (["one", "two"], [(0.5, "half")])
    assert tasks.tasks == ()


def test_what_a_job_has_found_is_freed_without_looking_for_garbage(plain, tasks):
    """The window looks for garbage rarely, and never at what has outlived a long look."""

    def work(task):
        task.work.step(0.5, "half")
        return Held()

    kept, told = [], []
    job = Job("work", work, lambda found: kept.append(weakref.ref(found)), told=told.extend)
    gc.disable()
    try:
        ended = weakref.ref(tasks.run(job))
        plain.until(lambda: bool(kept) and tasks.tasks == ())
        plain.until(lambda: kept[0]() is None and ended() is None)
    finally:
        gc.enable()


def test_a_handler_that_fails_keeps_nothing_back(plain, tasks, monkeypatch):
    told, raised = [], []
    monkeypatch.setattr("sys.excepthook", lambda kind, *_: raised.append(kind))
    tasks.write(Job("write", lambda _task: 0, lambda _: 1 / 0, ended=lambda: told.append("ended")))
    tasks.after_writes(lambda: told.append("written"))
    plain.until(lambda: len(told) == 2)
    assert (told, raised) == (["ended", "written"], [ZeroDivisionError])


def test_of_jobs_of_one_kind_only_the_newest_is_heard_of(plain, tasks):
    newest, held, told, discarded = NewestJob(tasks), Held(), [], []

    def job(name, work):
        return Job(name, work, told.append, ended=lambda: told.append("ended"),
                   discard=discarded.append)  # fmt: skip

    first = newest.run(job("first", lambda _task: held(1)))
    assert held.begun.wait(PATIENCE_S)
    newest.run(job("second", lambda _task: 2))
    assert first.token.cancelled()
    assert newest.busy
    held.go.set()
    plain.until(lambda: bool(discarded) and not newest.busy)
    assert (told, discarded) == ([2, "ended"], [1])


def test_work_that_outlives_the_window_is_heard_of_by_nobody(plain, tasks):
    held, told = Held(), []
    task = tasks.run(Job("something long", lambda _task: held(), told.append))
    assert held.begun.wait(PATIENCE_S)
    tasks.shutdown(0.0)
    held.go.set()
    assert task.join(PATIENCE_S)
    plain.once()
    assert told == []
    assert tasks.run(Job("something late", lambda _task: told.append("begun"))).over
    assert told == []


@pytest.mark.parametrize("late", [False, True])
def test_of_questions_that_wait_only_the_newest_is_answered(plain, tasks, late):
    held, told = Held(), []
    newest = LatestOnly(tasks, held, "ask", lambda *both: told.append(both), late=late)
    newest.ask(1)
    plain.until(held.begun.is_set)
    newest.ask(2)
    newest.ask(3)
    held.go.set()
    plain.until(newest.settled)
    assert told == [(1, 1), (3, 3)][not late :]


def test_a_thread_that_has_nothing_to_do_does_the_next_work(plain, tasks):
    threads = []
    for _ in range(2):
        task = tasks.run(Job("work", lambda _task: threads.append(threading.current_thread())))
        plain.until(lambda task=task: task.over)
        plain.until(lambda: threads[-1].name != "work")
    assert threads[0] is threads[1]


def test_the_program_waits_for_its_threads_but_not_for_ever(tasks):
    held = Held()
    newest = LatestOnly(tasks, held, "something asked", lambda *_: None)
    newest.ask("first")
    assert held.begun.wait(PATIENCE_S)
    newest.close()
    (thread,) = (one for one in threading.enumerate() if one.name == "something asked")
    wait_for_threads(0.0)
    assert thread.is_alive()
    held.go.set()
    thread.join(PATIENCE_S)
    assert not thread.is_alive()
