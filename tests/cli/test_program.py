"""The program as a whole: help, exit status, and what goes to which stream."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from stereotrack_core.cli import commands
from stereotrack_core.cli.options import CommandLine
from stereotrack_core.cli.output import stoppable
from stereotrack_core.errors import Cancelled, InputError

NAMES = [command.name for command in commands.COMMANDS]


def test_list_of_commands(run):
    for arguments in ([], ["--help"]):
        ended = run(*arguments)
        assert ended.err == ""
        for command in commands.COMMANDS:
            assert f"stereotrack {command.name} " in ended.out
            assert command.summary in ended.out


@pytest.mark.parametrize("name", NAMES)
def test_help_of_every_command(run, name):
    ended = run(name, "--help")
    assert ended.out.startswith(f"usage: stereotrack {name}")
    assert ended.err == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly"], "'fly'"),
        (["trak"], "Did you mean track? "),
        (["track"], "RECORDING"),
        (["track", "a", "-o", "b.npz", "--what"], "--what"),
        (["cloud", "a", "-o", "b.ply", "--frame", "x"], "--frame"),
        (["open", "somewhere"], "workbench"),
    ],
)
def test_wrong_arguments_give_one_sentence(run, arguments, words):
    ended = run(*arguments, status=2)
    assert ended.out == ""
    assert words in ended.err
    assert ended.err.startswith("stereotrack: ")
    assert ended.err.count("\n") == 1


def failing(monkeypatch, error):
    def fail(args):
        raise error

    module = SimpleNamespace(run=CommandLine("", (), fail))
    monkeypatch.setitem(sys.modules, "stereotrack_core.cli.fail", module)
    command = commands.Command("fail", "fails")
    monkeypatch.setattr(commands, "COMMANDS", (*commands.COMMANDS, command))


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (InputError("it is wrong", where="a.toml, fps", remedy="Write 10."), 2, "a.toml, fps: it"),
        (InputError("no full stop"), 2, "no full stop."),
        (Cancelled(), 1, "Stopped."),
        (KeyboardInterrupt(), 1, "Stopped."),
        (ZeroDivisionError("by zero"), 1, "--debug"),
        (MemoryError(), 1, "MemoryError: no details"),
        (BrokenPipeError(), 1, ""),
        (OSError(28, "No space left on device", "run.npz"), 1, "run.npz: No space left on device."),
        (OSError("a socket"), 1, "--debug"),
        (PermissionError(13, "Permission denied"), 2, "a file: permission denied"),
    ],
)
def test_errors_become_a_sentence_and_a_status(run, monkeypatch, error, status, words):
    failing(monkeypatch, error)
    ended = run("fail", status=status)
    assert ended.out == ""
    assert words in ended.err


MAIN = "import sys; from stereotrack_core.program import main; sys.exit(main(['--help']))"


def own_process(code, **streams):
    """A process of its own that has run this code."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.run([sys.executable, "-c", code], text=True, **{**pipes, **streams})


def test_start_is_light():
    heavy = "{'cv2', 'scipy', 'numba', 'rich.table', 'av', 'PySide6', 'ezc3d'}"
    code = (
        "import sys; from stereotrack_core.program import main; main(['--help']); "
        f"print({heavy} & set(sys.modules))"
    )
    done = own_process(code)
    assert done.stdout.splitlines()[-1] == "set()"
    assert (done.returncode, done.stderr) == (0, "")


def test_reader_that_leaves():
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as stdout:
        done = own_process(MAIN, stdout=stdout)
    assert (done.returncode, done.stderr) == (1, "")


FULL = Path("/dev/full")
some_disk_is_full = pytest.mark.skipif(not FULL.exists(), reason="no disk is full here")


@some_disk_is_full
def test_a_result_on_a_full_disk_is_missed_in_words():
    with FULL.open("w") as stdout:
        done = own_process(MAIN, stdout=stdout)
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("stereotrack: standard output: No space left")
    assert done.returncode == 1


@some_disk_is_full
def test_a_message_that_nobody_can_read_ends_no_work():
    code = "import sys; from stereotrack_core.cli.output import say; say('A frame.'); print('done')"
    with FULL.open("w") as stderr:
        done = own_process(code, stderr=stderr)
    assert (done.returncode, done.stdout) == (0, "done\n")


def test_first_interrupt_asks_and_second_stops():
    with stoppable() as stopped:
        assert not stopped()
        os.kill(os.getpid(), signal.SIGINT)
        assert stopped()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_work_that_never_asks_is_stopped_at_once():
    with pytest.raises(Cancelled, match="Nothing was"), stoppable("Nothing was.", at_once=True):
        os.kill(os.getpid(), signal.SIGINT)


def test_on_a_terminal_it_is_said_how_to_stop_at_once(monkeypatch):
    reading, writing = os.pipe()
    with os.fdopen(writing, "w") as terminal, os.fdopen(reading) as screen:
        monkeypatch.setattr(terminal, "isatty", lambda: True, raising=False)
        monkeypatch.setattr(sys, "stderr", terminal)
        with stoppable():
            os.kill(os.getpid(), signal.SIGINT)
        terminal.close()
        assert screen.read() == "\nStopping; Ctrl-C once more stops at once.\n"
