"""Ctrl-C: what is done is kept, what stood there before is not harmed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from stereotrack_core.interop.run_file import read_run

PROGRAM = [
    sys.executable,
    "-c",
    "import sys; from stereotrack_core.cli import main; sys.exit(main())",
]


@pytest.mark.skipif(os.name == "nt", reason="signals are sent otherwise there")
def test_a_run_that_is_stopped_keeps_what_it_has(sound, tmp_path, run):
    place = tmp_path / "run.npz"
    slow = ("--set", "data_points=20000", "--set", "iterations=50")
    command = [*PROGRAM, "track", str(sound), "-o", str(place), *slow]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(4)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert "Traceback" not in err
    assert process.returncode == 1, (out, err)
    if "nothing was written" in err:
        assert not place.exists()
        return
    stored = read_run(place)
    assert 0 < len(stored.frame) < 12
    assert f"Stopped after {len(stored.frame)} of 12 frames" in err
    assert run("evaluate", place).status == 0
