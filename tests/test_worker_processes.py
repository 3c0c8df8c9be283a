"""Processes that do tasks: what they tell, how they are lost, and how they end."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.worker_processes import Lost, WorkerProcess, end, with_words


def do(task, asker):
    """What the processes of these tests do."""
    if task == "wrong":
        raise InputError("this cannot be", where="here", remedy="Do it otherwise.")
    if task == "odd":
        raise ValueError(lambda: "cannot be sent")
    if task == "die":
        os._exit(7)
    for _ in range(int(task)):
        asker.on_frames(1)
    asker.tell({"task": task})


def sleep(_task, asker):
    """A task that listens to nobody."""
    asker.tell("asleep")
    time.sleep(600)


@pytest.fixture
def worker():
    made = WorkerProcess(do, 1)
    yield made
    end([made])


def all_words(worker, task):
    worker.give(task)
    heard = []
    while worker.busy:
        for one in with_words([worker], 10):
            heard += one.words()
    return heard


def test_tasks_one_after_the_other_with_frames_counted(worker):
    for task in ("3", "40"):
        *frames, last = all_words(worker, task)
        assert sum(frames) == int(task)
        assert last == {"task": task}


def test_what_a_task_fails_of_is_told_and_the_process_goes_on(worker):
    (wrong,) = all_words(worker, "wrong")
    assert isinstance(wrong, InputError)
    assert (str(wrong), wrong.where) == ("here: this cannot be. Do it otherwise.", "here")
    (odd,) = all_words(worker, "odd")
    assert isinstance(odd, RuntimeError)
    assert str(odd).startswith("ValueError")
    assert all_words(worker, "0") == [{"task": "0"}]


def test_a_process_that_ends_by_itself_is_lost(worker):
    with pytest.raises(Lost, match="exit code 7"):
        all_words(worker, "die")


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
@pytest.mark.parametrize("seconds", [0.0, 0.3, 1.5], ids=["started", "loading", "waiting"])
def test_interrupts_of_the_terminal_reach_only_the_one_that_asks(tmp_path, seconds):
    script = tmp_path / "asker.py"
    script.write_text(
        textwrap.dedent("""
        import time
        from stereotrack_core.worker_processes import WorkerProcess, end
        if __name__ == "__main__":
            workers = [WorkerProcess(print, 2) for _ in range(2)]
            try:
                print(*(worker.pid for worker in workers), flush=True)
                while True:  # a signal just before a sleep does not end it
                    time.sleep(0.1)
            except KeyboardInterrupt:
                print("stopped", flush=True)
            finally:
                end(workers)
        """)
    )
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as asker:
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


@needs_proc
def test_a_process_at_work_ends_when_the_one_that_asked_is_killed(tmp_path):
    script = tmp_path / "asker.py"
    script.write_text(
        textwrap.dedent("""
        import time
        from stereotrack_core.worker_processes import WorkerProcess, with_words
        from tests.test_worker_processes import sleep
        if __name__ == "__main__":
            worker = WorkerProcess(sleep, 1)
            worker.give(0)
            with_words([worker], None)
            print(worker.pid, flush=True)
            time.sleep(600)
        """)
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=environment
    ) as asker:
        try:
            pid = int(asker.stdout.readline())
            assert not has_ended(pid)
        finally:
            asker.kill()
    wait_until(lambda: has_ended(pid))


def wait_until(true, seconds=60):
    until = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < until
        time.sleep(0.02)
