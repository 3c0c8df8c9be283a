"""Everything that can be done in the window, in every state that it can be in."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QSettings
from PySide6.QtTest import QTest

from app.widgets.scene import drawing
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.tracking.presets import preset
from tests.gui.kept_window import close_window, show_window
from tests.gui.long_recordings import repeated
from tests.gui.made_runs import add_run
from tests.gui.walking import Walk, Watch

pytestmark = [pytest.mark.window, pytest.mark.slow]

PROGRAM = Path(__file__).with_name("texts_process.py")
ROOT = PROGRAM.parents[2]
FRAMES = 600
LESS = {"fit_shape": False, "search_proposals": 30, "data_points": 300, "iterations": 3}
CLOSED = ("empty", "refused")
STATES = (*CLOSED, "open", "with runs", "running", "broken", "no reference", "no OpenGL")


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> Path:
    """Two stereo views, long enough for a part of a video to be damaged."""
    folder = tmp_path_factory.mktemp("recordings") / "short"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=20, views="NS", seed=3))
    return folder


@pytest.fixture
def recording(short, tmp_path, state) -> Path:
    """A copy of it, longer for a run that lasts, or damaged as the state wants it."""
    if state == "running":
        return repeated(short, tmp_path / "recording", FRAMES // 20)
    folder = shutil.copytree(short, tmp_path / "recording")
    if state == "no reference":
        (folder / "reference.csv").unlink()
        text = (folder / "recording.toml").read_text(encoding="utf-8")
        kept = [line for line in text.splitlines() if not line.startswith("reference")]
        (folder / "recording.toml").write_text("\n".join([*kept, ""]), encoding="utf-8")
    if state == "broken":  # pictures in the middle of a video
        video = bytearray((folder / "S_left.mp4").read_bytes())
        for place in range(len(video) // 4, len(video) // 2, 50):
            video[place] ^= 0xFF
        (folder / "S_left.mp4").write_bytes(video)
    if state == "refused":
        (folder / "calibration.toml").write_text("[N_left]\nwidth = -3\n", encoding="utf-8")
    return folder


class Keeper:
    """Brings a window to a state, and back to it."""

    def __init__(self, window, recording: Path, state: str) -> None:
        self.window, self.session = window, window.context.session
        self.recording, self.state = recording, state

    def begin(self) -> None:
        """Go there for the first time."""
        if self.state == "refused":
            self.session.open(self.recording)
            self._settle()
            assert self.window.messages.message is not None
        self.keep()

    def keep(self) -> None:
        """Go back to it, where something was left."""
        if self.state in CLOSED:
            if self.session.document.recording is not None:
                self.session.track.stop()
                self.session.document.close()
            return
        if self.session.document.recording is None:
            self.session.open(self.recording)
            self._wait(lambda: self.session.document.frame_set is not None)
            self._settle()
        runs, track = self.session.runs, self.session.track
        if self.state == "with runs" and not runs.entries:
            add_run(self.window, "good", off=0.05)
            add_run(self.window, "bad", off=0.3)
            self._settle()
        if self.state == "running" and not track.running:
            track.stop()
            runs.clear()
            track.choose("fast", preset("fast").replaced(**LESS))
            track.begin(self.session.document.recording, range(FRAMES), "tpose")

    def _settle(self) -> None:
        self._wait(self.window.context.tasks.settled)

    def _wait(self, condition) -> None:
        for _ in range(6000):
            if condition():
                return
            QTest.qWait(20)
        raise AssertionError(f"{self.state}: nothing comes of {condition}")


@pytest.mark.parametrize("state", STATES)
def test_everything_in_every_state(qtbot, processes, kept, tmp_path, recording, state, monkeypatch):
    kept.close()
    if state == "no OpenGL":
        monkeypatch.setattr(drawing, "_kinds", lambda: iter(()))
    settings = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(tmp_path / "projects"))
    window = show_window(qtbot, settings, processes)
    qtbot.addWidget(window)
    with Watch() as watch:
        keeper = Keeper(window, recording, state)
        watch.now = "the beginning"
        keeper.begin()
        walk = Walk(window, watch, keeper.keep)
        spaces = [one.name for one in window.context.docks.workspaces]
        for space in ("",) if state in CLOSED else spaces:
            walk.controls(space)
        walk.commands(frozenset({"quit", "demo"}))
        watch.now = "the end"
        window.context.session.track.stop()
        close_window(window)
    assert watch.wrong == []
    assert len(walk.done) > (30 if state in CLOSED else 250)
    assert len(walk.answers.answered) > 10


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("scale", ["1", "1.5", "2"])
def test_no_text_is_cut_off(theme, scale, small_recording):
    """In a window of 1366 x 768, in all workspaces and dialogs."""
    said = subprocess.run(
        [sys.executable, str(PROGRAM), theme, str(small_recording)],
        env={**os.environ, "PYTHONPATH": str(ROOT), "QT_SCALE_FACTOR": scale},
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert (said.stdout, said.returncode) == ("", 0), said.stderr
