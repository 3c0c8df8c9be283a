"""Start-up: pictures without a screen, clear refusals, everything else to the command line."""

import os
import subprocess
import sys

import pytest
from PySide6.QtGui import QImage

pytestmark = pytest.mark.window


@pytest.fixture
def program(tmp_path):
    """Function that starts the program in a process of its own, without a screen."""
    environment = {k: v for k, v in os.environ.items() if k not in {"DISPLAY", "WAYLAND_DISPLAY"}}
    environment.pop("QT_QPA_PLATFORM", None)
    environment["XDG_CONFIG_HOME"] = str(tmp_path / "config")
    environment["XDG_STATE_HOME"] = str(tmp_path / "state")
    environment["QT_QPA_PLATFORM_PLUGIN_PATH"] = str(tmp_path / "nowhere")

    def start(*arguments, module="app", how="-m"):
        command = [sys.executable, how, *([module] if how == "-m" else []), *map(str, arguments)]
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=300, check=False
        )

    return start


def test_a_picture_is_made_without_a_screen(program, small_recording, tmp_path):
    picture = tmp_path / "window.png"
    done = program(
        "open", small_recording, "--frame", 3, "--workspace", "review", "--screenshot", picture
    )
    assert done.returncode == 0, done.stderr
    assert "propagateSizeHints" not in done.stderr
    image = QImage(str(picture))
    assert image.width() >= 1366
    colours = {
        image.pixel(x, y) for x in range(0, image.width(), 40) for y in range(0, image.height(), 40)
    }
    assert len(colours) > 50, "the picture is not blank"


_SCIPY = ("linalg", "ndimage", "optimize", "signal", "sparse", "spatial", "special", "stats")
_AFTER_THE_WINDOW = (
    *("vtkmodules", "pyvista", "pyqtgraph", "matplotlib", "numba", "llvmlite", "PIL", "jinja2"),
    *(f"scipy.{part}" for part in _SCIPY),
)
"""What takes long to load and nobody needs before a recording is shown."""

_SHOWN = """
import sys
from app.start import prepare, load_qt
prepare(needs_screen=False)
load_qt()
from app.program import WindowProgram
program = WindowProgram()
program.window.show()
program.app.processEvents()
print(*[name for name in sys.argv[1:] if name in sys.modules])
program.window.close()
"""


def test_the_window_shows_before_what_takes_long_is_loaded(program):
    done = program(_SHOWN, *_AFTER_THE_WINDOW, how="-c")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["open", "/nowhere/at/all", "--screenshot", "x.png"], "/nowhere/at/all"),
        (["open", "RECORDING", "--workspace", "dance", "--screenshot", "x.png"], "dance"),
        (["open", "RECORDING", "--screenshot", "/nowhere/x.png"], "/nowhere/x.png"),
        (["open", "RECORDING", "--frame", "many"], "many"),
        (["open", "RECORDING"], "screen"),
    ],
)
def test_what_cannot_be_done_is_refused_in_a_sentence(program, small_recording, arguments, word):
    done = program(*[small_recording if a == "RECORDING" else a for a in arguments])
    assert done.returncode == 2
    assert word in done.stderr
    assert "Traceback" not in done.stderr


def test_other_commands_are_the_command_line_s(program, small_recording):
    done = program("info", small_recording)
    assert done.returncode == 0
    assert "small" in done.stdout


def test_help_of_a_window_command_needs_no_qt(program):
    done = program("open", "--help")
    assert done.returncode == 0
    assert "--screenshot" in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_an_interrupt_while_the_window_is_made_ends_the_program_at_once(small_recording):
    script = (
        "import os, signal, sys; from app import __main__, program\n"
        "program.WindowProgram = lambda: os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.exit(__main__.main(['open', sys.argv[1]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(small_recording)],
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stderr) == (1, "Stopped.\n")


_FREED = """
import mmap, threading
import numpy as np
from app.start import give_back_pictures
give_back_pictures()
def held():
    with open("/proc/self/statm") as pages:
        return int(pages.read().split()[1]) * mmap.PAGESIZE >> 20
before, kept = held(), []
def read():
    for _ in range(30):
        pictures = [np.ones(900_000, np.uint8) for _ in range(20)]
        kept.append(np.ones(3000, np.uint8))
        del pictures
readers = [threading.Thread(target=read) for _ in range(4)]
for one in readers: one.start()
for one in readers: one.join()
print(held() - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="of the GNU C library")
def test_freed_pictures_are_given_back(program):
    """Without it 72 MiB stay."""
    done = program(_FREED, how="-c")
    assert int(done.stdout) < 36, done.stderr
