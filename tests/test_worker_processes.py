"""A process that threads wait for: results, words, orders, a process that dies, the end."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.worker_processes import Lost, TaskProcess


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


def fail_oddly(_asker):
    raise ValueError(lambda: "cannot be sent")


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
    with pytest.raises(RuntimeError, match=r"^ValueError"):
        process(fail_oddly)
    assert process(partial(turned, "abc")) == "cba"


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


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
@pytest.mark.parametrize("seconds", [0.0, 0.3, 1.5], ids=["started", "loading", "waiting"])
def test_interrupts_of_the_terminal_reach_only_the_one_that_asks(tmp_path, seconds):
    script = tmp_path / "asker.py"
    script.write_text(
        textwrap.dedent("""
        import time
        from stereotrack_core.worker_processes import TaskProcess
        if __name__ == "__main__":
            workers = [TaskProcess(2) for _ in range(2)]
            try:
                print(*(worker._given(id) and worker.pid for worker in workers), flush=True)
                while True:  # a signal just before a sleep does not end it
                    time.sleep(0.1)
            except KeyboardInterrupt:
                print("stopped", flush=True)
            finally:
                for worker in workers:
                    worker.close()
        """)
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "start_new_session": True}
    with subprocess.Popen([sys.executable, str(script)], text=True, **pipes) as asker:
        pids = [int(word) for word in asker.stdout.readline().split()]
        time.sleep(seconds)
        os.killpg(asker.pid, signal.SIGINT)
        out, err = asker.communicate(timeout=300)
    assert (out, err) == ("stopped\n", "")
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def has_ended(pid):
    """Whether a process is no more, or only waits to be counted."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return True
    return status == "Z"


needs_proc = pytest.mark.skipif(sys.platform != "linux", reason="there is no /proc")


def wait_until(true, seconds=60):
    until = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < until
        time.sleep(0.02)
