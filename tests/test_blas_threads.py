"""Overlapping holders of one thread do not give threads back to each other's work."""

from __future__ import annotations

import os
from contextlib import suppress

import pytest
import threadpoolctl

from stereotrack_core.blas_threads import OneBlasThread, one_blas_thread


class CountedLimit:
    def __init__(self):
        self.set = self.restored = 0

    def __call__(self):
        self.set += 1
        return self

    def restore_original_limits(self):
        self.restored += 1


def blas_threads():
    return {
        pool["num_threads"]
        for pool in threadpoolctl.threadpool_info()
        if pool["user_api"] == "blas"
    }


def test_the_first_to_leave_gives_nothing_back():
    limit = CountedLimit()
    threads = OneBlasThread(limit)
    first = threads.hold()
    second = threads.hold()
    first()
    assert (limit.set, limit.restored) == (1, 0)
    first()
    assert limit.restored == 0, "ending twice must not end another's"
    second()
    assert (limit.set, limit.restored) == (1, 1)
    with pytest.raises(ValueError, match="inside"), threads():
        raise ValueError("inside")
    assert (limit.set, limit.restored) == (2, 2)


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
