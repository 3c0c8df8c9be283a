"""A process that threads wait for: results, words, orders, a process that dies, the end."""

import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.task_process import TaskProcess
from stereotrack_core.worker_processes import Lost


@pytest.fixture
def process():
    made = TaskProcess()
    yield made
    made.close()


def turned(text, _asker):
    os.write(1, b"what is printed is no result\n")
    return text[::-1]


def who(_asker):
    return os.getpid()


def fail(_asker):
    raise InputError("this is wrong", where="here", remedy="Do it right.")


def die(_asker):
    os._exit(7)


def tell_and_die(asker):
    asker.tell("a word")
    os._exit(7)


def follow(asker):
    """Tell what is ordered, until it is enough."""
    heard = []
    while "enough" not in heard:
        heard += asker.orders(None)
        asker.tell(list(heard))
    return heard


def sleep(asker):
    asker.tell("asleep")
    time.sleep(600.0)


def count(asker):
    asker.kept["count"] = asker.kept.get("count", 0) + 1
    return asker.kept["count"]


def test_it_does_tasks_in_another_process_and_keeps_what_they_leave(process):
    assert process(partial(turned, "abc")) == "cba"
    assert process(partial(turned, "x" * 3_000_000)) == "x" * 3_000_000
    assert process(who) != os.getpid()
    assert [process(count), process(count)] == [1, 2]


def test_what_a_task_raises_is_raised_here_and_the_next_one_is_done(process):
    with pytest.raises(InputError) as error:
        process(fail)
    assert (error.value.where, error.value.remedy) == ("here", "Do it right.")
    assert process(partial(turned, "abc")) == "cba"


def test_orders_reach_their_task_however_early_they_are_given_and_no_other(process):
    first, second = partial(follow), partial(follow)
    process.order(first, "early")
    process.order(first, "enough")
    process.order(second, "of the second")
    process.order(second, "enough")
    assert process(first) == ["early", "enough"]
    process.order(first, "late")
    told = []
    assert process(second, told.append) == ["of the second", "enough"]
    assert told[-1] == ["of the second", "enough"]


@pytest.mark.parametrize("task", [sleep, follow])
def test_a_task_that_is_no_longer_wanted_ends_whether_it_listens_or_not(process, task):
    wanted, told = [], []

    def hear(word):
        told.append(word)
        wanted.append(False)

    process.order(task, "begin")
    first = process(who)
    with pytest.raises(Cancelled):
        process(task, hear, lambda: bool(wanted), listens=task is follow)
    assert told
    assert (process(who) == first) == (task is follow), "what a task has left is still there"
    with pytest.raises(Cancelled):
        process(partial(turned, "abc"), cancelled=lambda: True)


def test_one_that_dies_at_work_says_so(process):
    told = []
    with pytest.raises(Lost, match="exit code 7"):
        process(tell_and_die, told.append)
    assert told == ["a word"], "what has told something is not done again"
    with pytest.raises(Lost, match="exit code 7"):
        process(die)
    assert process(partial(turned, "abc")) == "cba"


def test_one_that_is_ended_starts_again_with_the_next_task(process):
    first = process(who)
    process.end()
    assert process(who) != first
    with ThreadPoolExecutor(1) as pool:
        begun = threading.Event()
        asleep = pool.submit(process, sleep, lambda _: begun.set())
        assert begun.wait(300)
        process.end()
        with pytest.raises(Lost):
            asleep.result(300)


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="processes cannot be looked at here")
def test_one_that_is_closed_is_gone_and_does_nothing_more(process):
    number = process(who)
    process.close()
    end = time.monotonic() + 300.0
    while os.path.exists(f"/proc/{number}") and time.monotonic() < end:
        time.sleep(0.02)
    assert not os.path.exists(f"/proc/{number}")
    with pytest.raises(Cancelled):
        process(who)


def test_several_threads_take_turns_also_where_the_process_has_died(process):
    os.kill(process(who), signal.SIGTERM)
    texts = [f"{k} {'x' * (k % 7) * 20_000}" for k in range(60)]
    with ThreadPoolExecutor(6) as pool:
        tasks = [partial(turned, text) for text in texts]
        assert list(pool.map(process, tasks)) == [text[::-1] for text in texts]
