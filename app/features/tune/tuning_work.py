"""What the Tune workspace does: attempts beside the run, and values of one parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterRow
from stereotrack_core.tracking.pipeline import FirstPose
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.settings import Settings
from stereotrack_core.tracking.tuning.attempt import Attempt
from stereotrack_core.tracking.tuning.series import all_values, spread_values

from ...services.actions import ActionBook
from ...session.runs import RunEntry
from .attempts import AttemptPresenter
from .numbers import attempt_table
from .preset_work import PresetWork
from .runner import TrialRunner
from .series import SeriesPresenter
from .stores import StoreKeeper
from .tune_menu import ATTEMPT_BUTTONS, PRESET_BUTTONS
from .warming import CloudWarmer

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

SECONDS = 2.0
"""Length of the stretch around the frame where neither a selection nor the zoom says another."""

_LONGEST_SECONDS = 10.0


class TuningWork(QObject):
    """Connects what is tried with the panels, the views and the project."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = w = window
        self.stores = StoreKeeper(w.document, w.clouds)
        self.runner = TrialRunner(self)
        self.attempts = AttemptPresenter(
            w.document, w.clouds, w.runs, w.track, w.judging, self.runner,
            self.stores, self.stretch, self._first_pose,
        )  # fmt: skip
        self.series = SeriesPresenter(
            w.document, w.runs, w.judging, w.tasks, self.runner, self.attempts, self.stores,
            self.stretch, self._first_pose,
        )  # fmt: skip
        self.attempts.live = bool(w.settings.value("tune/live", True, type=bool))
        self.warmer = CloudWarmer(self.runner, self.stores, self._to_warm)
        self.presets = PresetWork(w, self.selected)
        self._against: RunEntry | None = None
        self._compared = "preset"
        self._connect()
        self.show_settings()

    def _connect(self) -> None:
        w = self._w
        w.parameters.settings_changed.connect(self._on_settings)
        w.parameters.preset_requested.connect(self.presets.use)
        w.parameters.against_requested.connect(self._on_compared)
        w.attempts_panel.chosen.connect(self._on_row)
        w.attempts_panel.base_chosen.connect(self._on_base)
        w.attempts_panel.dismissed.connect(self._on_dismissed)
        w.series_panel.row_chosen.connect(self._on_series_row)
        w.series_panel.begin_requested.connect(self._on_series)
        w.series_panel.cancel_requested.connect(self.series.cancel)
        w.series_panel.shown.connect(self.series.show)
        w.series_panel.taken.connect(self._on_taken)
        self.attempts.changed.connect(self.show)
        self.attempts.arrived.connect(w.instant.tell_soon)
        for changed in (w.runs.active_changed, w.timeline.selection_changed, w.spaces.changed):
            changed.connect(self.warmer.warm_soon)
        self.series.changed.connect(self.show_series)
        for presenter in (self.attempts, self.series):
            presenter.message.connect(w.messages.show_message)
            presenter.changed.connect(w.refresh_soon)
        self.presets.used.connect(self._on_preset)
        w.judging.judged.connect(self.show)
        w.runs.active_changed.connect(self.show_settings)
        w.timeline.selection_changed.connect(self.show)
        w.document.frame_changed.connect(self.show)
        w.spaces.changed.connect(self._on_workspace)
        w.docks["attempts"].visibilityChanged.connect(self.show)

    # ---- facts

    @property
    def active(self) -> bool:
        """Whether the Tune workspace is shown, where changes are tried."""
        space = self._w.spaces.current
        return space is not None and space.name == "tune"

    def settled(self) -> bool:
        """Whether everything that was changed has been tried."""
        return self.attempts.settled() and not self.series.running

    def stretch(self) -> range:
        """Frames to try on: the selection, else what is visible, else two seconds here."""
        w = self._w
        recording, count = w.document.recording, w.document.frame_count
        if recording is None or not count:
            return range(0)
        if w.timeline.selection:
            return w.timeline.selection
        scale = w.timeline.scale
        seen = range(max(int(scale.first), 0), min(round(scale.last), count))
        if not scale.is_whole and len(seen) and len(seen) <= _LONGEST_SECONDS * recording.fps:
            return seen
        length = min(max(round(SECONDS * recording.fps), 2), count)
        first = min(max(w.document.frame - length // 2, 0), count - length)
        return range(first, first + length)

    def _mark(self) -> None:
        """Select the stretch on which something is going to be tried, so that it stays."""
        timeline, stretch = self._w.timeline, self.stretch()
        if not timeline.selection and len(stretch):
            timeline.set_selection(stretch)
            timeline.selection_changed.emit(stretch)

    def selected(self) -> RunEntry | None:
        """The attempt that is selected in the table; else the newest."""
        attempts = self.attempts.entries
        entries = self._entries()
        row = self._w.attempts_panel.row
        if 0 <= row < len(entries) and entries[row] in attempts:
            return entries[row]
        return attempts[-1] if attempts else None

    def _entries(self) -> tuple[RunEntry, ...]:
        """The run and its attempts, as the table has them."""
        run = self._w.runs.active
        attempts = tuple(entry for entry in self.attempts.entries if entry is not run)
        return (run, *attempts) if run is not None else attempts

    def _to_warm(self) -> Attempt | None:
        """What is going to be tried, if nothing else is being done."""
        idle = self.active and self.settled() and not self._w.track.running
        return self.attempts.wanted() if idle and self.attempts.base() is not None else None

    def _first_pose(self) -> FirstPose:
        return self._w.tracker.first_pose

    # ---- showing

    @Slot()
    def show(self, _what: object = None) -> None:
        """Say what is tried, and how good it is."""
        w, panel = self._w, self._w.attempts_panel
        if not panel.isVisible() or w.document.recording is None:
            return
        running = self.attempts.running
        panel.show_words(self.attempts.words(), self._stretch_words())
        panel.show_progress(
            len(running.frames) if running is not None else 0,
            len(running.wanted) if running is not None else 0,
        )
        run, *others = self._entries() or (None,)
        panel.show_table(
            attempt_table(run, others, w.judging.all(), self._against, self.attempts.changes)
        )

    def _stretch_words(self) -> str:
        stretch, w = self.stretch(), self._w
        if not len(stretch):
            return ""
        frames = f"Frames {stretch.start} to {stretch.stop - 1}"
        if w.timeline.selection:
            return f"{frames}, which are selected in the timeline."
        return f"{frames}. Shift+drag in the timeline selects others."

    @Slot()
    def show_series(self) -> None:
        """Show what the values of one parameter give."""
        series = self.series
        self._w.series_panel.show_series(
            series.multiples(), series.shown, series.share, running=series.running
        )

    @Slot()
    def show_settings(self) -> None:
        """Show the settings, and how they differ from what they are compared with."""
        track, panel = self._w.track, self._w.parameters
        base, against = track.base, "preset"
        if self._compared == "thesis":
            base, against = preset("thesis"), "thesis"
        elif self._compared == "run":
            run = self.attempts.base()
            if run is not None and run.settings is not None:
                base, against = run.settings, "run"
        panel.set_settings(track.settings, base, against)
        panel.set_preset(track.preset)
        self._w.series_panel.set_rows(track.settings.rows())

    @Slot(str)
    def _on_compared(self, word: str) -> None:
        self._compared = word
        self.show_settings()
        if self._w.parameters.against_box.currentData() != word:
            self._w.statusBar().showMessage("There is no run whose settings are known.", 4000)

    # ---- what a person does

    @Slot()
    def _on_settings(self, _what: object = None) -> None:
        if self.active:
            if self.attempts.live:
                self._mark()
            self.attempts.on_settings()
        elif self.attempts.running is not None:
            self.attempts.cancel()

    @Slot()
    def _on_workspace(self) -> None:
        if not self.active:
            self.attempts.cancel()
        self.show()

    @Slot()
    def _on_preset(self) -> None:
        self._w.follower.use_settings(self._w.track.settings)
        self.show_settings()
        self._on_settings()

    def toggle_live(self) -> None:
        """Try changes at once, or only when asked to."""
        self.attempts.live = not self.attempts.live
        self._w.settings.setValue("tune/live", self.attempts.live)
        self.show()

    @Slot(int)
    def _on_row(self, _row: int) -> None:
        self._w.refresh_soon()

    @Slot(int)
    def _on_base(self, row: int) -> None:
        entries = self._entries()
        self._against = entries[row] if 0 <= row < len(entries) else None
        self.show()

    @Slot(int)
    def _on_dismissed(self, row: int) -> None:
        entries = self._entries()
        if 0 <= row < len(entries):
            self.attempts.dismiss(entries[row])

    def compare_with_selected(self) -> None:
        """State the differences from the selected attempt."""
        self._against = self.selected()
        self.show()

    def dismiss_selected(self) -> None:
        """Take the selected attempt away."""
        entry = self.selected()
        if entry is not None:
            self.attempts.dismiss(entry)

    def make_selected_the_run(self) -> None:
        """Make the selected attempt the active run."""
        entry = self.selected()
        if entry is not None:
            self.attempts.make_run(entry)

    def take_settings_of_selected(self) -> None:
        """Go on with the settings of the selected attempt."""
        entry = self.selected()
        if entry is not None and entry.settings is not None:
            self._use(entry.settings)

    def _use(self, settings: Settings) -> None:
        self._w.follower.use_settings(settings)
        self.show_settings()
        self._on_settings()

    # ---- one parameter

    @Slot(object)
    def _on_series_row(self, row: ParameterRow) -> None:
        self._w.series_panel.set_value(self._w.track.settings.values()[row.name])

    @Slot(object, float, float, int, bool)
    def _on_series(
        self, row: ParameterRow, low: float, high: float, count: int, by_factors: bool
    ) -> None:
        try:
            values = all_values(row) or spread_values(row, low, high, count, by_factors=by_factors)
        except InputError as refusal:
            self._w.series_panel.refuse(f"{refusal.what}. {refusal.remedy}")
            return
        self._mark()
        self.series.begin(row, values, self._w.track.settings)

    @Slot(int)
    def _on_taken(self, place: int) -> None:
        row, tried = self.series.row, self.series.tried
        if row is not None and 0 <= place < len(tried):
            self.series.show(None)
            self._use(self._w.track.settings.replaced(**{row.name: tried[place].value}))

    # ---- coming and going

    def offer(self, book: ActionBook) -> None:
        """Put the commands where they are needed."""
        attempts = [book.action(name) for name in ATTEMPT_BUTTONS]
        self._w.attempts_panel.set_actions(attempts)
        self._w.parameters.set_menu([book.action(name) for name in PRESET_BUTTONS])

    def search_parameters(self) -> None:
        """Show the parameters, and let the person type what is looked for."""
        dock = self._w.docks["parameters"]
        if dock.isHidden():
            self._w.spaces.toggle_panel("parameters")
        dock.raise_()
        self._w.parameters.focus_search()

    def stop(self) -> None:
        """End everything, as another recording comes or the window closes; waits for nothing."""
        self._against = None
        self.warmer.cancel()
        self.attempts.stop()
        self.series.clear()
        self.runner.close()
        self.stores.close()
