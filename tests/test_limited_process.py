"""Reading in a process of its own: results, errors, and what ends that process."""

import os
import re
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.limited_process import GB, read_apart
from stereotrack_core.project.database import ProjectDamaged
from tests.test_worker_processes import has_ended, needs_proc, wait_until

ROOT = Path(__file__).parents[1]
REMEDY = "Save it again."
limited = pytest.mark.skipif(sys.platform != "linux", reason="memory is not limited there")


@pytest.fixture
def path(tmp_path):
    made = tmp_path / "file"
    made.write_text("content")
    return made


def content(path, *, times=1):
    os.write(1, b"what is printed is no result\n")
    return path.read_text() * times, os.getpid()


def wrong(path):
    raise InputError("x" * 390, where="y" * 900, remedy="z" * 3000)


def wrong_project(path):
    raise ProjectDamaged(path, "no table")


def much(path):
    return len(bytearray(8 * GB))


def bit_by_bit(path):
    return [bytearray(10_000_000) for _ in range(1000)]


def abort(path):
    os.abort()


def leave(path):
    os._exit(3)


def sleep(path):
    path.with_name("pid").write_text(f"{os.getpid()}\n")
    time.sleep(600)


def hold_everything(path):
    """Go on for ever without letting any other thread of the process work."""
    path.with_name("pid").write_text(f"{os.getpid()}\n")
    return re.match(r"(a+)+$", "a" * 64 + "b")


def test_what_is_read_comes_back_from_another_process(path):
    text, pid = read_apart(partial(content, times=1_000_000), path, REMEDY)
    assert text == "content" * 1_000_000
    assert pid != os.getpid()


def test_errors_of_the_project_arrive_unchanged(path):
    for read in (wrong, wrong_project):
        with pytest.raises(InputError) as here:
            read(path)
        with pytest.raises(InputError) as there:
            read_apart(read, path, REMEDY)
        assert type(there.value) is type(here.value)
        assert str(there.value) == str(here.value)
        assert vars(there.value) == vars(here.value)


@limited
@pytest.mark.parametrize("read", [much, bit_by_bit])
def test_one_that_takes_all_memory_gives_a_sentence(read, path):
    with pytest.raises(InputError, match=r"or too large: .* more than 0.5 GB of memory") as refusal:
        read_apart(read, path, REMEDY, memory=GB // 2)
    assert (refusal.value.where, refusal.value.remedy) == (str(path), REMEDY)


@pytest.mark.parametrize(("read", "why"), [(abort, "SIGABRT|exit code"), (leave, "exit code 3")])
def test_one_that_ends_its_process_gives_a_sentence(read, why, path):
    with pytest.raises(InputError, match=f"is damaged so that its reader broke down .({why})"):
        read_apart(read, path, REMEDY)


@pytest.mark.parametrize("read", [sleep, hold_everything])
def test_one_that_never_ends_gives_a_sentence(read, path):
    with pytest.raises(InputError, match="or too large: reading it takes more than 2 s"):
        read_apart(read, path, REMEDY, seconds=2.0)


@needs_proc
@pytest.mark.parametrize("name", ["sleep", pytest.param("hold_everything", marks=pytest.mark.slow)])
def test_it_ends_when_the_one_that_reads_is_killed(name, path):
    code = (
        "from pathlib import Path; from stereotrack_core.limited_process import read_apart; "
        f"from tests.test_limited_process import {name}; "
        f"read_apart({name}, Path({str(path)!r}), '', seconds=20.0)"
    )
    told = path.with_name("pid")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen([sys.executable, "-c", code], env=environment) as asker:
        try:
            wait_until(lambda: told.is_file() and told.read_text().endswith("\n"))
        finally:
            asker.kill()
    wait_until(lambda: has_ended(int(told.read_text())))


def test_a_script_that_says_nothing_about_main_reads_and_runs_once(path, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from pathlib import Path\n"
        "from stereotrack_core.limited_process import read_apart\n"
        f"print(read_apart(Path.read_text, Path({str(path)!r}), ''))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "content\n", "")
