"""The panels of reviewing in the window: they follow runs, selection and threshold."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtGui import QGuiApplication

from stereotrack_core.atomic import write_file
from stereotrack_core.evaluation.joint_angles.motion import (
    CUT_OFF_HZ,
    HIGHEST_SHARE,
    frame_columns,
    frame_rows,
)
from stereotrack_core.recording.description import Segment
from stereotrack_core.tables import csv_text

from ...context import Context
from ...session.runs import RunEntry
from ...widgets.forms.form_dialog import ask_to_save
from ...widgets.plots.limb_plots import AnglePlot
from ...widgets.tables.panels import MotionTable
from ...widgets.tables.trees import StatisticsPanel
from . import limb_numbers
from .joint_angles import (
    COLUMNS,
    QUANTITIES,
    Moved,
    RunAngles,
    choices,
    curves_of,
    plot_words,
    range_rows,
    table_words,
    unit_of,
)

_DELAY_MS = 60
_TABLES = "Tables (*.csv)"


class ReviewController(QObject):
    """Fills statistics and joint angles; only those that are seen."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session, self._state = context, context.session, context.view_state
        session, tasks = context.session, context.tasks
        self.statistics, self.motion = StatisticsPanel(), MotionTable(CUT_OFF_HZ)
        self.angles = AnglePlot(choices(), QUANTITIES)
        docks = context.docks
        docks.add("statistics", "Statistics", self.statistics)
        # this shares the place of the plot of errors, and says by itself what it shows
        docks.add("angles", "Joint angles", self.angles, titled=False)
        docks.add("motion", "Motion", self.motion)
        self._run_angles = RunAngles(session.runs, tasks, lambda: session.track.entry)
        self._shows = {
            "statistics": self._show_statistics,
            "angles": self._show_angles,
            "motion": self._show_angles,
        }
        self._stale: set[str] = set()
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self.show)
        tasks.watch(lambda: not self._timer.isActive())
        self._connect()

    def _connect(self) -> None:
        session, angles, timeline = self._session, self.angles, self._context.docks.timeline
        angles.frame_requested.connect(session.document.visit)
        for panels, changes in (
            (("statistics",), (self._state.threshold_changed,)),
            (("angles", "motion"), (
                angles.chosen, self._run_angles.known.changed, self.motion.cut_off_changed,
            )),
            (tuple(self._shows), (
                session.judging.judged, session.judging.truth_changed, session.opened,
                session.closed, session.track.finished, self._state.selection_changed,
            )),
            ((), [self._context.docks.dock(name).visibilityChanged for name in self._shows]),
        ):  # fmt: skip
            for changed in changes:
                changed.connect(partial(self.show_soon, panels))
        self.motion.angle_chosen.connect(self._on_angle)
        angles.visible_range_changed.connect(timeline.set_visible_range)
        timeline.visible_range_changed.connect(angles.set_visible_range)
        timeline.margins_changed.connect(angles.set_margins)
        angles.set_margins(*timeline.margins)
        session.document.frame_changed.connect(angles.set_frame)
        session.document.count_changed.connect(angles.set_range)
        session.opened.connect(self._on_opened)

    @Slot()
    def _on_opened(self) -> None:
        recording = self._session.document.recording
        if recording is not None:
            highest = HIGHEST_SHARE * recording.fps
            self.motion.set_highest_cut_off(CUT_OFF_HZ, highest)
            self.angles.set_range(self._session.document.frame_count)

    def add_buttons(self) -> None:
        """Offer the commands in their panels, once they are made."""
        actions = self._context.actions
        for name in ("copy_statistics", "save_statistics"):
            self.statistics.add_action_button(actions.action(name))
        self.motion.add_action_button(actions.action("save_angles"))

    def show_soon(self, panels: tuple[str, ...], *_what: object) -> None:
        """Bring these panels up to date, after what else happens now."""
        self._stale.update(panels)
        self._timer.start()

    @Slot()
    def show(self) -> None:
        """Bring the panels that are seen up to date, where they are not."""
        if self._session.document.recording is None:
            return
        docks = self._context.docks
        seen = {name for name in self._stale if docks.is_seen(name)}
        self._stale -= seen
        for show in dict.fromkeys(self._shows[name] for name in sorted(seen)):
            show()

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

    def _moved(self) -> list[Moved]:
        recording = self._session.document.recording
        if recording is None:
            return []
        truth = self._session.judging.truth
        return self._run_angles.shown(truth, recording.fps, self.motion.cut_off.value())

    def _show_angles(self) -> None:
        self._run_angles.ask(self._session.judging.truth)
        moved, plot = self._moved(), self.angles
        curves = curves_of(moved, plot.angle_key, plot.quantity_key)
        words = plot_words(moved, plot.angle_key, plot.quantity_key)
        plot.show_curves(curves, unit_of(plot.quantity_key), words)
        plot.set_selection(self._state.selection)
        stretch = self._stretches()[0]
        rows = range_rows(moved[0], stretch) if moved else ()
        said = table_words(moved[0], stretch) if moved else ""
        self.motion.show_rows(said, COLUMNS, rows)

    # ---- what a person does

    @Slot(str)
    def _on_angle(self, key: str) -> None:
        box = self.angles.angle
        box.setCurrentIndex(box.findData(key))
        if self._context.docks.is_shown("angles"):
            self._context.docks.bring_up("angles")

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

    def save_angles(self, path: Path) -> None:
        """Write joint angles of every frame as CSV."""
        moved = self._moved()
        if moved:
            rows = frame_rows(moved[0].angles, moved[0].motion)
            self._write(path, csv_text(frame_columns(), rows))

    def why_no_angles(self) -> str:
        """Why there are no joint angles to be saved."""
        if self._moved():
            return ""
        return "Joint angles have not been computed. Open the panel Joint angles or Motion first."

    def ask_where(self, title: str, name: str, write: Callable[[Path], None]) -> None:
        """Ask for a file, and write something there."""
        recording = self._session.document.recording
        folder = Path.home() if recording is None else recording.folder.parent
        ask_to_save(self._context.docks.dialog_parent, title, folder / name, _TABLES, write)

    def _write(self, path: Path, text: str) -> None:
        path = path if path.suffix else path.with_suffix(".csv")
        if self._context.notifier.attempt(lambda: write_file(path, text)):
            self._context.notifier.say(f"Saved to {path}.", 6000)
