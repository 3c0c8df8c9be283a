"""Processes of the program: what starts a module, here and where it is frozen."""

import subprocess
import sys

from stereotrack_core.own_program import asked_module, module_command
from stereotrack_core.version import __version__


def test_the_command_line_runs_in_a_process_of_its_own(tmp_path):
    command = module_command("stereotrack_core", ["--version"])
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == (f"stereotrack {__version__}\n", "")


def test_a_frozen_program_starts_itself_and_knows_what_it_is_asked(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    command = module_command("app.pdf", ["page.html", "page.pdf"])
    assert command[0] == sys.executable
    assert asked_module(command) == ("app.pdf", ["page.html", "page.pdf"])
    for argv in (["stereotrack"], ["stereotrack", "open", "x"], ["stereotrack", "--run-module"]):
        assert asked_module(argv) is None
