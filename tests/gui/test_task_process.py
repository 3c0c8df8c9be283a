"""Tasks in a process of their own: what they tell, orders, a process that dies, the end."""

from __future__ import annotations

import multiprocessing
import os
from functools import partial

import pytest

from app.services.tasks.process import TaskProcess
from stereotrack_core.errors import InputError
from stereotrack_core.worker_processes import Lost

pytestmark = pytest.mark.window


def count(asker, most):
    """Tell numbers until told to stop."""
    for number in range(most):
        asker.tell(("number", number))
    while asker.orders(None) != ["stop"]:
        pass


def fail(_asker):
    """Fail of what a person has done wrong."""
    raise InputError("this is wrong", where="here", remedy="Do it right.")


def die(_asker):
    """End the process."""
    os._exit(7)


@pytest.fixture
def process(qapp):
    made = TaskProcess()
    yield made
    made.close()


def following(task):
    """What a task tells, and how it ends."""
    task.said, task.over = [], []
    task.told.connect(task.said.append)
    task.ended.connect(task.over.append)
    return task


def test_tasks_are_done_one_after_the_other_and_hear_what_is_said_to_them(process, qtbot):
    first, second = (following(process.run(partial(count, most=most))) for most in (2, 1))
    second.order("stop")
    first.order("nothing of interest")
    qtbot.waitUntil(lambda: len(first.said) == 2)
    assert second.said == []
    first.order("stop")
    qtbot.waitUntil(lambda: second.over == [None])
    assert first.over == [None]
    assert (first.said, second.said) == ([("number", 0), ("number", 1)], [("number", 0)])
    first.order("stop")  # it has ended, which is all right


def test_what_a_task_fails_of_is_told_and_the_next_one_is_done(process, qtbot):
    wrong, right = following(process.run(fail)), following(process.run(partial(count, most=1)))
    right.order("stop")
    qtbot.waitUntil(lambda: right.over == [None])
    [error] = wrong.over
    assert (error.what, error.where, error.remedy) == ("this is wrong", "here", "Do it right.")


def test_one_that_dies_takes_the_task_in_work_with_it_alone(process, qtbot):
    dies, waits = following(process.run(die)), following(process.run(partial(count, most=3)))
    qtbot.waitUntil(lambda: len(waits.said) == 3)
    assert [type(error) for error in dies.over] == [Lost]
    waits.order("stop")
    qtbot.waitUntil(lambda: waits.over == [None])


def test_closing_it_ends_the_process_and_nothing_is_told_any_more(process, qtbot):
    before = set(multiprocessing.active_children())
    task = following(process.run(partial(count, most=1)))
    qtbot.waitUntil(lambda: bool(task.said))
    [mine] = set(multiprocessing.active_children()) - before
    process.close()
    mine.join()
    assert task.over == []
    again = following(process.run(partial(count, most=1)))
    qtbot.waitUntil(lambda: bool(again.said))
