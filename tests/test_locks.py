"""Outputs of one writer at a time: who has one, what the second process is told, and the end."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.locks import FileLock, is_held, lock_path, refuse_second, writing

HOLDER = (
    "import sys, time; from pathlib import Path; from stereotrack_core.locks import FileLock; "
    "lock = FileLock(Path(sys.argv[1])); print('held', flush=True); time.sleep(600)"
)


def test_the_second_process_is_told_who_writes_and_a_killed_one_is_not_in_the_way(tmp_path):
    output = tmp_path / "run.npz"
    command = [sys.executable, "-c", HOLDER, str(output)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        try:
            assert holder.stdout.readline() == "held\n"
            for attempt in (writing(output).__enter__, lambda: refuse_second(output)):
                with pytest.raises(InputError, match="Wait until it has finished, stop it") as told:
                    attempt()
                assert f"written by process {holder.pid} on " in str(told.value)
                assert " since 20" in str(told.value)
            assert is_held(output, unsure=False)
        finally:
            holder.kill()
    assert lock_path(output).exists(), "the killed process left it"
    refuse_second(output)
    with writing(output):
        assert json.loads(lock_path(output).read_bytes())["process"] == os.getpid()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("note", [b"", b"{", b"[1]", b'{"host": 1, "process": "x"}', b"\xff"])
def test_a_lock_that_does_not_say_whose_it_is_holds_nevertheless(tmp_path, note, monkeypatch):
    monkeypatch.setattr("stereotrack_core.locks._TRY_SECONDS", 0.0)
    lock = FileLock(tmp_path / "run.npz")
    lock_path(tmp_path / "run.npz").write_bytes(note)
    with pytest.raises(InputError, match="written by another process"):
        refuse_second(tmp_path / "run.npz")
    lock.release()
    lock.release()


def test_what_stands_where_the_lock_goes_is_not_touched(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("data")
    lock_path(tmp_path / "a").symlink_to(precious)
    lock_path(tmp_path / "b").mkdir()
    for name in ("a", "b"):
        with pytest.raises(InputError, match="not a file that the program has made"):
            FileLock(tmp_path / name)
    assert precious.read_text() == "data"
    with pytest.raises(InputError, match="cannot write here"), writing(tmp_path / "no" / "file"):
        pass
    with writing(None):
        pass


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have other rights there")
def test_a_lock_that_another_user_has_left_is_not_in_the_way(tmp_path, monkeypatch):
    left = lock_path(tmp_path / "run.npz")
    left.write_text("")
    opened = Path.open

    def refused(path, mode="r", **how):
        if path == left and mode == "ab":  # root may write to everything
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, mode, **how)

    monkeypatch.setattr(Path, "open", refused)
    with writing(tmp_path / "run.npz"):
        assert is_held(tmp_path / "run.npz", unsure=False)
    assert not left.exists()
