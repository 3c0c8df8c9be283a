"""The panels of reviewing in the window: they follow runs, selection and threshold."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles.motion import CUT_OFF_HZ, HIGHEST_SHARE
from stereotrack_core.evaluation.joint_angles.table import frame_columns, frame_rows
from stereotrack_core.recording.csv_table import csv_text
from stereotrack_core.recording.description import Segment

from ...session.runs import RunEntry
from . import angle_curves, limb_numbers
from .angle_curves import Moved
from .explaining import content_of
from .joint_angles import AnglePresenter
from .sights import SightPresenter

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_DELAY_MS = 60
_TABLES = "Tables (*.csv)"


class ReviewWork(QObject):
    """Fills statistics, explanations and joint angles; only those that are seen."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = w = window
        self.panels = window.review_panels
        self.angles = AnglePresenter(w.runs, w.tasks, lambda: w.track.entry)
        self.sights = SightPresenter(w.tasks, lambda: w.track.entry)
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self.show)
        panels = self.panels
        for plot in (panels.explanations, panels.angles):
            plot.frame_requested.connect(self._go_to)
        for signal in (
            panels.explanations.kind_chosen, panels.angles.chosen, self.angles.changed,
            self.sights.changed, w.judging.judged, w.judging.truth_changed,
            w.timeline.selection_changed, w.follower.threshold_moved, w.document.opened,
            w.document.closed, w.track.finished,
        ):  # fmt: skip
            signal.connect(self.show_soon)
        for name in panels.widgets():
            w.docks[name].visibilityChanged.connect(self.show_soon)
        panels.motion.angle_chosen.connect(self._on_angle)
        panels.motion.cut_off_changed.connect(self.show_soon)
        panels.angles.visible_range_changed.connect(w.timeline.set_visible_range)
        w.timeline.visible_range_changed.connect(panels.angles.set_visible_range)
        w.timeline.margins_changed.connect(panels.angles.set_margins)
        panels.angles.set_margins(*w.timeline.margins)
        w.document.frame_changed.connect(panels.angles.set_frame)
        w.document.count_changed.connect(panels.angles.set_range)
        w.document.opened.connect(self._on_opened)

    @Slot()
    def _on_opened(self) -> None:
        recording = self._w.document.recording
        if recording is not None:
            highest = HIGHEST_SHARE * recording.fps
            self.panels.motion.set_highest_cut_off(CUT_OFF_HZ, highest)
            self.panels.angles.set_range(self._w.document.frame_count)

    def add_buttons(self) -> None:
        """Offer the commands in their panels, once they are made."""
        book = self._w.actions_book
        for name in ("copy_statistics", "save_statistics"):
            self.panels.statistics.add_action_button(book.action(name))
        self.panels.motion.add_action_button(book.action("save_angles"))

    def settled(self) -> bool:
        """Whether the panels follow the facts."""
        return not self._timer.isActive()

    @Slot()
    def show_soon(self, _what: object = None) -> None:
        """Bring the panels that are seen up to date, after what else happens now."""
        self._timer.start()

    @Slot()
    def show(self) -> None:
        """Bring the panels that are seen up to date."""
        if self._w.document.recording is None:
            return
        if self.panels.statistics.isVisible():
            self._show_statistics()
        if self.panels.explanations.isVisible():
            self._show_explanations()
        if self.panels.angles.isVisible() or self.panels.motion.isVisible():
            self._show_angles()

    # ---- what is shown

    def _entries(self) -> list[RunEntry]:
        """Runs that are shown, the active one first."""
        active = self._w.runs.active
        others = [e for e in self._w.runs.entries if e.visible and e is not active]
        return [*([active] if active is not None else []), *others]

    def _stretches(self) -> tuple[Segment, ...]:
        recording = self._w.document.recording
        segments = () if recording is None else recording.segments
        count = self._w.document.frame_count
        return limb_numbers.stretches_of(self._w.timeline.selection, count, segments)

    def _numbers(self) -> tuple[limb_numbers.StretchNumbers, ...]:
        judgements, threshold = self._w.judging.all(), self._w.plot.threshold
        return limb_numbers.numbers_of(self._entries(), judgements, self._stretches(), threshold)

    def _show_statistics(self) -> None:
        judgement = self._w.judging.of(self._w.runs.active)
        numbers = self._numbers()
        if judgement is None or not numbers:
            self.panels.statistics.show_statistics("", (), ())
            return
        self.panels.statistics.show_statistics(
            limb_numbers.words(numbers, judgement),
            limb_numbers.columns(self._w.plot.threshold, judgement.measure),
            limb_numbers.groups(numbers),
        )

    def _show_explanations(self) -> None:
        recording, kind = self._w.document.recording, self.panels.explanations.kind_key
        if recording is None:
            return
        judgements = self._w.judging.all()
        explained = self.sights.explained(
            self._entries(), judgements, recording, with_views=kind == "views"
        )
        content = content_of(kind, explained, self._w.timeline.selection)
        self.panels.explanations.show_content(content)

    def _moved(self) -> list[Moved]:
        recording = self._w.document.recording
        if recording is None:
            return []
        truth = self._w.judging.truth
        return self.angles.shown(truth, recording.fps, self.panels.motion.cut_off.value())

    def _show_angles(self) -> None:
        self.angles.ask(self._w.judging.truth)
        moved, plot = self._moved(), self.panels.angles
        curves = angle_curves.curves_of(moved, plot.angle_key, plot.quantity_key)
        words = angle_curves.plot_words(moved, plot.angle_key, plot.quantity_key)
        plot.show_curves(curves, angle_curves.unit_of(plot.quantity_key), words)
        plot.set_selection(self._w.timeline.selection)
        stretch = self._stretches()[0]
        rows = angle_curves.range_rows(moved[0], stretch) if moved else ()
        said = angle_curves.table_words(moved[0], stretch) if moved else ""
        self.panels.motion.show_rows(said, angle_curves.COLUMNS, rows)

    # ---- what a person does

    @Slot(int)
    def _go_to(self, frame: int) -> None:
        self._w.document.pause()
        self._w.document.go_to(frame)

    @Slot(str)
    def _on_angle(self, key: str) -> None:
        box = self.panels.angles.angle
        box.setCurrentIndex(box.findData(key))
        dock = self._w.docks["angles"]
        if not dock.isHidden():
            dock.raise_()

    def move_threshold(self, degrees: float) -> None:
        """Raise or lower the threshold of the plot of errors."""
        plot = self._w.plot
        plot.set_threshold(min(max(plot.threshold + degrees, 0.0), 180.0))
        self._w.statusBar().showMessage(f"The threshold is {plot.threshold:.0f}°.", 3000)
        self.show_soon()

    def copy_statistics(self) -> None:
        """Put the statistics on the clipboard as a table."""
        text = limb_numbers.as_csv(self._numbers(), self._w.plot.threshold)
        QGuiApplication.clipboard().setText(text)
        self._w.statusBar().showMessage("The statistics are on the clipboard, as CSV.", 4000)

    def ask_where_to_save_statistics(self) -> None:
        """Ask for a file for the statistics."""
        path = self._ask("Save the statistics", "statistics.csv")
        if path is not None:
            self.save_statistics(path)

    def save_statistics(self, path: Path) -> None:
        """Write the statistics as CSV."""
        self._write(path, limb_numbers.as_csv(self._numbers(), self._w.plot.threshold))

    def ask_where_to_save_angles(self) -> None:
        """Ask for a file for the joint angles of the active run, or of the reference."""
        path = self._ask("Save the joint angles", "angles.csv")
        if path is not None:
            self.save_angles(path)

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
        return "Open the panel Joint angles or Motion first; it works them out."

    def _ask(self, title: str, name: str) -> Path | None:
        recording = self._w.document.recording
        folder = Path.home() if recording is None else recording.folder.parent
        chosen, _ = QFileDialog.getSaveFileName(self._w, title, str(folder / name), _TABLES)
        return Path(chosen) if chosen else None

    def _write(self, path: Path, text: str) -> None:
        path = path if path.suffix else path.with_suffix(".csv")
        try:
            write_file(path, text)
        except InputError as error:
            self._w.show_error(error)
            return
        self._w.statusBar().showMessage(f"Written to {path}.", 6000)
