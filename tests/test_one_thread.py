"""Libraries run on one thread while somebody asks for that."""

import os
from contextlib import suppress

import cv2
import pytest
import threadpoolctl

from stereotrack_core.one_thread import one_blas_thread, one_opencv_thread


def blas_threads():
    pools = threadpoolctl.threadpool_info()
    return {pool["num_threads"] for pool in pools if pool["user_api"] == "blas"}


@pytest.mark.parametrize(
    ("library", "threads", "one"),
    [(one_blas_thread, blas_threads, {1}), (one_opencv_thread, cv2.getNumThreads, 1)],
)
def test_libraries_really_run_on_one_thread_until_the_last_has_left(library, threads, one):
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        library.hold()()  # loads the BLAS of SciPy, which comes with threads of its own
        before = threads()
        first, second = library.hold(), library.hold()
        first()
        assert threads() == one
        second()
        assert threads() == before


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
