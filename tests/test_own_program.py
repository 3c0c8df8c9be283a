"""Processes of the program: what starts a module, here and where it is frozen."""

import os
import subprocess
import sys

from stereotrack_core.own_program import (
    BOUND,
    GO_ON,
    STOP,
    asked_module,
    module_command,
    program_command,
)
from stereotrack_core.version import __version__


def test_the_command_line_runs_in_a_process_of_its_own(tmp_path):
    done = subprocess.run(
        program_command(["--version"]), cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == (f"stereotrack {__version__}\n", "")


def test_a_frozen_program_starts_itself_and_knows_what_it_is_asked(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    command = module_command("app.pdf", ["page.html", "page.pdf"])
    assert command[0] == sys.executable
    assert asked_module(command) == ("app.pdf", ["page.html", "page.pdf"])
    for argv in (["stereotrack"], ["stereotrack", "open", "x"], ["stereotrack", "--run-module"]):
        assert asked_module(argv) is None


def test_a_process_stops_with_the_one_that_started_it_unless_it_shall_go_on(tmp_path, monkeypatch):
    (tmp_path / "sleeper.py").write_text("import time\ntime.sleep(600)\n")
    monkeypatch.syspath_prepend(tmp_path)
    ended = {}
    for said in (b"", STOP + GO_ON + STOP, GO_ON):
        with subprocess.Popen(
            module_command("sleeper", []), stdin=subprocess.PIPE, env={**os.environ, **BOUND}
        ) as process:
            process.stdin.write(said)
            process.stdin.close()  # as the system does for a process that is killed
            try:
                ended[said] = process.wait(0.5 if said == GO_ON else 60)
            except subprocess.TimeoutExpired:
                process.kill()
    assert list(ended) == [b"", STOP + GO_ON + STOP]
    assert set(ended.values()) != {0}
