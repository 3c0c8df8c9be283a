"""A real window on a small recording; without a screen unless one is asked for."""

from __future__ import annotations

import os

# before Qt is loaded: by default nothing is shown anywhere
if os.environ.get("STEREOTRACK_TEST_DISPLAY") != "1":
    os.environ["QT_QPA_PLATFORM"] = "offscreen"

import functools
import gc
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QApplication

from app.services.failures import FailureRelay
from app.services.tasks.task import Processes
from app.widgets.style.theme import apply_theme
from stereotrack_core.simulation.make import simulate
from tests.gui.hands import window_with

FRAMES = 8
PATIENCE_MS = 300_000
"""Waiting ends as soon as what is waited for is there, so a busy machine may take its time."""


def patient(wait: Callable) -> Callable:
    """The same way of waiting, which gives up after this long at the earliest.

    Where nothing is to come, as in ``assertNotEmitted``, it waits no longer than it is told to.
    """

    @functools.wraps(wait)
    def waiting(*what, timeout=PATIENCE_MS, raising=True, **how):
        if not raising:
            return wait(*what, timeout=timeout, raising=False, **how)
        return wait(*what, timeout=max(timeout, PATIENCE_MS), **how)

    return waiting


@pytest.fixture
def qtbot(qtbot):
    """The bot, which waits for what it is told to however busy the machine is."""
    for name in ("waitUntil", "waitSignal", "waitSignals", "waitExposed"):
        setattr(qtbot, name, patient(getattr(qtbot, name)))
    return qtbot


@pytest.fixture(scope="session")
def small_recording(tmp_path_factory) -> Path:
    """Two stereo views of a person in the T pose, rendered once."""
    folder = tmp_path_factory.mktemp("recordings") / "small"
    simulate(folder, person="P2", motion="t-pose", frames=FRAMES, views="NS", seed=3)
    return folder


@pytest.fixture(scope="session")
def four_views(tmp_path_factory) -> Path:
    """Four stereo views of a person, rendered once."""
    folder = tmp_path_factory.mktemp("recordings") / "four"
    simulate(folder, person="P2", motion="t-pose", frames=3, views="NOSW", seed=3)
    return folder


@pytest.fixture
def settings(tmp_path) -> QSettings:
    made = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    made.setValue("projects_folder", str(tmp_path / "projects"))
    return made


@pytest.fixture
def failures():
    """Exceptions that nobody caught, of any thread; there shall be none."""
    relay = FailureRelay()
    seen = []
    relay.message.connect(seen.append)
    relay.install()
    yield seen
    relay.remove()


@pytest.fixture(scope="session")
def processes(qapp):
    """The processes that work for the windows, one after the other."""
    made = Processes()
    yield made
    made.close()


@pytest.fixture
def window(qtbot, settings, failures, processes):
    """The window with its welcome page."""
    app = QApplication.instance()
    apply_theme(app, "dark")
    gc.disable()
    made = window_with(settings, processes)
    qtbot.addWidget(made)
    made.resize(1366, 768)
    with qtbot.waitExposed(made):
        made.show()

    def active():
        made.activateWindow()
        return made.isActiveWindow()

    qtbot.waitUntil(active)
    yield made
    made.close()
    gc.enable()
    left = [t for t in threading.enumerate() if t.name in {"track", "frames read"}]
    for thread in left:
        thread.join(
            PATIENCE_MS / 1000
        )  # it has been told to end, and may be in the middle of a frame
    assert not any(thread.is_alive() for thread in left), f"threads outlive the window: {left}"
    assert not failures, [message.sentence() for message in failures]


@pytest.fixture
def opened(window, qtbot, small_recording):
    """The window with the small recording open and painted."""
    window.context.session.opening.open(small_recording)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None, timeout=30_000)
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    return window


@pytest.fixture
def annotate_first(settings):
    """Recordings open in the workspace Annotate, which draws no clouds and no scene."""
    settings.setValue("workspace", "annotate")


@pytest.fixture
def annotating(annotate_first, opened):
    """The window in the workspace Annotate, with an empty project."""
    assert opened.context.docks.workspace == "annotate"
    assert opened.context.session.project.why_no_edit() == ""
    return opened


@pytest.fixture
def four(annotate_first, window, qtbot, four_views):
    """The window in the workspace Annotate, with four views and an empty project."""
    window.context.session.opening.open(four_views)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None, timeout=30_000)
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    return window


@pytest.fixture
def dark(qapp):
    """The dark theme's tokens, with the theme shown; the old theme comes back."""
    from app.widgets.style.theme import apply_theme, chosen_theme, current_theme

    before = chosen_theme()
    apply_theme(qapp, "dark")
    yield current_theme()
    apply_theme(qapp, before)


@pytest.fixture
def shown(qtbot, dark):
    """Function that shows a widget of a given size and waits until it is painted."""

    def show(widget, width=640, height=480):
        qtbot.addWidget(widget)
        widget.resize(width, height)
        with qtbot.waitExposed(widget):
            widget.show()
        return widget

    return show
