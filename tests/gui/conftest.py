"""A real window on a small recording; without a screen unless one is asked for."""

import os

# before Qt is loaded: by default nothing is shown anywhere
if os.environ.get("STEREOTRACK_TEST_DISPLAY") != "1":
    os.environ["QT_QPA_PLATFORM"] = "offscreen"

import functools
from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import QWidget

from app.features.annotate import panels
from app.features.annotate.clicking import facts
from app.services.failures import FailureRelay
from app.session import camera_doubts
from app.session.jobs import Processes
from stereotrack_core.simulation.make import Simulation, simulate
from tests.gui.kept_window import PATIENCE_MS, KeptWindow, close_window, open_recording, show_window

FRAMES = 8
FOLDER = Path(__file__).parent
PAUSES = ((camera_doubts, "_PAUSE_MS"), (facts, "_PAUSE_MS"), (panels, "_COUNTING_MS"))
KEPT = pytest.StashKey[KeptWindow]()


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


@pytest.fixture(autouse=True)
def nothing_left_open(qapp):
    """Close what a test leaves open, and fail: it would keep the mouse from others' widgets."""
    yield
    left = []
    while shown := qapp.activePopupWidget() or qapp.activeModalWidget():
        left.append(f"{type(shown).__name__} {shown.windowTitle()!r}")
        shown.close()
        shown.hide()
    assert not left, f"left open: {', '.join(left)}"
    assert not QWidget.mouseGrabber(), "a widget still has the mouse"
    assert qapp.mouseButtons() == Qt.MouseButton.NoButton, "a mouse button is still down"


@pytest.fixture(scope="session", autouse=True)
def short_pauses():
    """Windows that wait less after an edit whether another one follows, and so settle sooner."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in PAUSES:
            patch.setattr(module, name, 40)
        yield


@pytest.fixture(scope="session")
def small_recording(tmp_path_factory) -> Path:
    """Two stereo views of a person in the T pose, rendered once."""
    folder = tmp_path_factory.mktemp("recordings") / "small"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=FRAMES, views="NS", seed=3))
    return folder


@pytest.fixture(scope="session")
def four_views(tmp_path_factory) -> Path:
    """Four stereo views of a person, rendered once."""
    folder = tmp_path_factory.mktemp("recordings") / "four"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=3, views="NOSW", seed=3))
    return folder


@pytest.fixture
def settings(tmp_path) -> QSettings:
    made = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    made.setValue("projects_folder", str(tmp_path / "projects"))
    return made


@pytest.fixture
def failures():
    """Exceptions that nobody caught, of any thread; there shall be none."""
    seen = []
    relay = FailureRelay(seen.append)
    yield seen
    relay.remove()


@pytest.fixture(scope="session")
def processes(qapp):
    """The processes that work for the windows, one after the other."""
    made = Processes()
    yield made
    made.close()


@pytest.fixture(scope="session")
def kept(request, processes, tmp_path_factory):
    """The window that tests share."""
    kept = request.session.stash[KEPT] = KeptWindow(tmp_path_factory.mktemp("kept"), processes)
    yield kept
    kept.close()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """Close the window that tests share where others follow, whose garbage would be kept too."""
    kept = item.session.stash.get(KEPT, None)
    if kept is not None and not (nextitem and nextitem.path.is_relative_to(FOLDER)):
        kept.close()


@pytest.fixture
def window(qtbot, settings, failures, processes, kept):
    """A new window with its welcome page."""
    kept.close()
    made = show_window(qtbot, settings, processes)
    qtbot.addWidget(made)
    yield made
    close_window(made)
    assert not failures, [message.sentence() for message in failures]


@pytest.fixture
def shared_window(qtbot, failures, kept, tmp_path):
    """Function that shows a recording with an empty project in the window that tests share."""
    yield lambda recording, workspace: kept.take(qtbot, recording, workspace, tmp_path / "projects")
    assert not failures, [message.sentence() for message in failures]


@pytest.fixture
def opened(shared_window, small_recording):
    """The window with the small recording open and painted, and an empty project."""
    return shared_window(small_recording, "")


@pytest.fixture
def newly_opened(window, qtbot, small_recording):
    """The same in a window of its own, in which nothing was ever arranged in another way."""
    open_recording(window, qtbot, small_recording)
    return window


@pytest.fixture
def annotating(shared_window, small_recording):
    """The window in the workspace Annotate, with an empty project."""
    window = shared_window(small_recording, "annotate")
    assert window.context.docks.workspace == "annotate"
    assert window.context.session.project.why_no_edit() == ""
    return window


@pytest.fixture
def four(shared_window, four_views):
    """The window in the workspace Annotate, with four views and an empty project."""
    return shared_window(four_views, "annotate")


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
