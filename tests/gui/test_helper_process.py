"""Work in another process: answers, failures in words, a process that dies, the end."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest

from app.services.tasks import helper_process
from app.services.tasks.helper_process import HelperProcess
from stereotrack_core.errors import InputError


@pytest.fixture
def worker(tmp_path, monkeypatch):
    """A process whose worker is written to a file that it can import."""
    made = []

    def make(text: str) -> HelperProcess:
        (tmp_path / "a_worker.py").write_text(text)
        monkeypatch.syspath_prepend(str(tmp_path))
        made.append(HelperProcess("a_worker:Worker"))
        return made[-1]

    yield make
    for helper in made:
        helper.close()


WORKER = """
import os, time
from stereotrack_core.errors import InputError
class Worker:
    def __call__(self, question):
        print("what is printed is no answer")
        if question == "wrong":
            raise InputError("this is wrong", where="here", remedy="Do it right.")
        if question == "who":
            return os.getpid()
        while question == "never":
            time.sleep(60.0)
        return question[::-1]
"""


def test_it_answers_in_another_process(worker, capfd):
    helper = worker(WORKER)
    assert helper("abc") == "cba"
    assert helper("who") != os.getpid()
    assert helper("x" * 3_000_000) == "x" * 3_000_000


def test_what_answering_raised_is_raised_here_and_the_next_question_is_answered(worker, capfd):
    helper = worker(WORKER)
    with pytest.raises(InputError, match="this is wrong"):
        helper("wrong")
    assert helper("abc") == "cba"


def test_a_process_that_died_is_started_anew(worker, capfd):
    helper = worker(WORKER)
    first = helper("who")
    os.kill(first, signal.SIGTERM)
    assert helper("abc") == "cba"
    assert helper("who") != first


def test_one_that_cannot_start_says_so_and_does_not_wait(worker, capfd):
    helper = worker("raise SystemExit(3)")
    with pytest.raises((EOFError, OSError)):
        helper("abc")


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="processes cannot be looked at here")
def test_it_ends_with_the_window(worker, capfd):
    helper = worker(WORKER)
    process = helper("who")
    helper.close()
    end = time.monotonic() + 300.0
    while os.path.exists(f"/proc/{process}") and time.monotonic() < end:
        time.sleep(0.02)
    assert not os.path.exists(f"/proc/{process}")
    with pytest.raises(EOFError):
        helper("abc")


A_MOMENT_S = 0.5
"""What must not come to an end gets so long; a busy machine makes that prove less, not fail."""


def test_one_that_is_closed_while_it_is_being_started_leaves_no_process(worker, capfd, monkeypatch):
    helper = worker(WORKER)
    closing = threading.Thread(target=helper.close)
    started = []

    start = subprocess.Popen

    def late(*what, **how):
        closing.start()
        closing.join(A_MOMENT_S)
        started.append(start(*what, **how))
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", late)
    with suppress(EOFError):  # it may have answered before it was closed
        helper("abc")
    closing.join(300)
    (process,) = started
    assert process.poll() is not None, "the process outlives the window"
    with pytest.raises(EOFError):
        helper("abc")


def test_one_that_is_closed_while_its_answer_is_read_ends_that_in_words(worker, capfd, monkeypatch):
    helper = worker(WORKER)
    helper("abc")
    closing = threading.Thread(target=helper.close)
    read = helper_process._receive

    def receive(pipe):
        closing.start()
        closing.join(A_MOMENT_S)
        return read(pipe)

    monkeypatch.setattr(helper_process, "_receive", receive)
    with pytest.raises(EOFError):
        helper("never")
    closing.join(300)
    assert not closing.is_alive()


def test_several_threads_take_turns_also_where_the_process_has_died(worker, capfd):
    helper = worker(WORKER)
    os.kill(helper("who"), signal.SIGTERM)
    questions = [f"{k} {'x' * (k % 7) * 20_000}" for k in range(60)]
    with ThreadPoolExecutor(6) as pool:
        assert list(pool.map(helper, questions)) == [one[::-1] for one in questions]
