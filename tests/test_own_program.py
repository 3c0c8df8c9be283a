"""Processes of the program: what starts a module, here and where it is frozen."""

import os
import subprocess
import sys
from contextlib import suppress

import threadpoolctl

from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.own_program import asked_module, module_command
from stereotrack_core.version import __version__


def test_the_command_line_runs_in_a_process_of_its_own(tmp_path):
    command = module_command("stereotrack_core", ["--version"])
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == (f"stereotrack {__version__}\n", "")


def test_a_frozen_program_starts_itself_and_knows_what_it_is_asked(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    command = module_command("stereotrack_core", ["info", "folder"])
    assert command[0] == sys.executable
    assert asked_module(command) == ("stereotrack_core", ["info", "folder"])
    for argv in (["stereotrack"], ["stereotrack", "open", "x"], ["stereotrack", "--run-module"]):
        assert asked_module(argv) is None


def blas_threads():
    pools = threadpoolctl.threadpool_info()
    return {pool["num_threads"] for pool in pools if pool["user_api"] == "blas"}


def test_blas_really_runs_on_one_thread_until_the_last_has_left():
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        before = blas_threads()
        first, second = one_blas_thread.hold(), one_blas_thread.hold()
        first()
        assert blas_threads() == {1}
        second()
        assert blas_threads() == before


def test_the_program_begins_with_one_thread_unless_it_is_told_otherwise(monkeypatch, capsys):
    from app.__main__ import main

    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")  # so that it is put back as it was
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    for told in ("1", "3"):
        with suppress(SystemExit):
            main(["--version"])
        assert os.environ["OPENBLAS_NUM_THREADS"] == told
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    assert "stereotrack" in capsys.readouterr().out
