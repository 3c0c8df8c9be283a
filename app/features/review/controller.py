"""The panel of statistics in the window: it follows runs, selection and threshold."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtGui import QGuiApplication

from stereotrack_core.atomic import write_file
from stereotrack_core.recording.description import Segment

from ...context import Context
from ...session.runs import RunEntry
from ...widgets.forms.form_dialog import ask_to_save
from ...widgets.tables.trees import StatisticsPanel
from . import limb_numbers

_DELAY_MS = 60
_TABLES = "Tables (*.csv)"


class ReviewController(QObject):
    """Fills the statistics while they are seen."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session, self._state = context, context.session, context.view_state
        session, docks = context.session, context.docks
        self.statistics = StatisticsPanel()
        docks.add("statistics", "Statistics", self.statistics)
        self._stale = False
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self.show)
        context.tasks.watch(lambda: not self._timer.isActive())
        for changed in (
            self._state.threshold_changed, session.judging.judged, session.judging.truth_changed,
            session.opened, session.closed, session.track.finished, self._state.selection_changed,
        ):  # fmt: skip
            changed.connect(self.show_soon)
        docks.dock("statistics").visibilityChanged.connect(lambda _: self._timer.start())

    def add_buttons(self) -> None:
        """Offer the commands in the panel, once they are made."""
        for name in ("copy_statistics", "save_statistics"):
            self.statistics.add_action_button(self._context.actions.action(name))

    @Slot()
    def show_soon(self, *_what: object) -> None:
        """Bring the statistics up to date, after what else happens now."""
        self._stale = True
        self._timer.start()

    @Slot()
    def show(self) -> None:
        """Bring the statistics up to date if they are seen and are not."""
        if self._session.document.recording is None or not self._stale:
            return
        if self._context.docks.is_seen("statistics"):
            self._stale = False
            self._show_statistics()

    # ---- what is shown

    def _entries(self) -> list[RunEntry]:
        """Runs that are shown, the active one first."""
        runs = self._session.runs
        return [one for one in (runs.active, *runs.shown_beside()) if one is not None]

    def _stretches(self) -> tuple[Segment, ...]:
        recording = self._session.document.recording
        segments = () if recording is None else recording.segments
        count = self._session.document.frame_count
        return limb_numbers.stretches_of(self._state.selection, count, segments)

    def _numbers(self) -> tuple[limb_numbers.StretchNumbers, ...]:
        judgements, threshold = self._session.judging.all(), self._state.threshold
        return limb_numbers.numbers_of(self._entries(), judgements, self._stretches(), threshold)

    def _show_statistics(self) -> None:
        judgement = self._session.judging.of(self._session.runs.active)
        numbers = self._numbers()
        if judgement is None or not numbers:
            self.statistics.show_statistics("", (), ())
            return
        self.statistics.show_statistics(
            limb_numbers.words(numbers, judgement),
            limb_numbers.columns(self._state.threshold, judgement.measure),
            limb_numbers.groups(numbers),
        )

    # ---- what a person does

    def move_threshold(self, degrees: float) -> None:
        """Raise or lower the threshold of the plot of errors."""
        self._state.set_threshold(min(max(self._state.threshold + degrees, 0.0), 180.0))
        self._context.notifier.say(f"Threshold: {self._state.threshold:.0f}°.", 3000)

    def copy_statistics(self) -> None:
        """Put the statistics on the clipboard as a table."""
        text = limb_numbers.as_csv(self._numbers(), self._state.threshold)
        QGuiApplication.clipboard().setText(text)
        self._context.notifier.say("Statistics copied to the clipboard as CSV.", 4000)

    def save_statistics(self, path: Path) -> None:
        """Write the statistics as CSV."""
        self._write(path, limb_numbers.as_csv(self._numbers(), self._state.threshold))

    def ask_where(self, title: str, name: str, write: Callable[[Path], None]) -> None:
        """Ask for a file, and write something there."""
        recording = self._session.document.recording
        folder = Path.home() if recording is None else recording.folder.parent
        ask_to_save(self._context.docks.dialog_parent, title, folder / name, _TABLES, write)

    def _write(self, path: Path, text: str) -> None:
        path = path if path.suffix else path.with_suffix(".csv")
        if self._context.notifier.attempt(lambda: write_file(path, text)):
            self._context.notifier.say(f"Saved to {path}.", 6000)
