"""Sweeps in the window: their dialogs, and what is taken over from their results."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.tracking.presets import PRESETS, preset

from ...context import Context
from ...session.sweeping import SweepNow, SweepPresenter
from ...session.tracking import Chosen
from ...widgets.forms.form_dialog import ask_to_open
from ...widgets.forms.message import Message
from .dialog import SweepDialog
from .results import SweepResults, parameters_of

_SAID_MS = 10_000


class SweepController(QObject):
    """Makes the dialogs when they are first wanted, and follows a sweep that goes on."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self.presenter = SweepPresenter(context.settings, self)
        context.session.closing.connect(self.presenter.leave)
        self.presenter.changed.connect(self._on_changed)
        self.dialog: SweepDialog | None = None
        self.results: SweepResults | None = None
        if self.presenter.now.going:
            context.notifier.say("A sweep is in progress. Track, Sweep … shows it.", _SAID_MS)

    def show_dialog(self) -> None:
        """Ask what to sweep, or show how it is going."""
        if self.dialog is None:
            self.dialog = SweepDialog(
                self.presenter, self._context.tasks, self._context.docks.dialog_parent
            )
            self.dialog.results_wanted.connect(self.show_results)
        self._tell_facts(self.dialog)
        self.dialog.show()
        self.dialog.raise_()

    def ask_for_results(self) -> None:
        """Look at the table of the last sweep, or at one that the person chooses."""
        table = self.presenter.last_table
        if table is not None and table.is_file():
            self.show_results(table)
            return
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Open sweep results", "", "Table (*.csv)", self.show_results)

    @Slot(object)
    def show_results(self, table: Path) -> None:
        """Plot a table."""
        if self.results is None:
            self.results = SweepResults(self._context.docks.dialog_parent)
            self.results.taken_over.connect(self.take_over)
        try:
            self.results.open_table(table)
        except InputError as error:
            self._context.notifier.error(error)
            return
        self.results.show()
        self.results.raise_()

    @Slot(object)
    def take_over(self, values: dict[str, str]) -> None:
        """Put a point's values into the parameter panel."""
        context = self._context
        name = values.get("preset", "")
        chosen = self._session.track.chosen
        if name in PRESETS:
            chosen = Chosen(name, preset(name), preset(name))
        own = parameters_of(values)
        if not own and name not in PRESETS:
            said = ", ".join(f"{one} {value}" for one, value in values.items())
            context.notifier.say(f"The parameter panel has no such parameters: {said}.", 6000)
            return
        try:
            chosen = replace(chosen, settings=chosen.settings.replaced(**own))
        except InputError as error:
            context.notifier.error(error)
            return
        said = ", ".join(f"{one.replace('_', ' ')} {value}" for one, value in own.items())
        self._session.tracker.take(chosen, f"apply {said or name}")
        context.notifier.say(f"Applied: {said or name}.", 6000)

    @Slot(object)
    def _on_changed(self, now: SweepNow) -> None:
        """Say how a sweep has ended, also when its dialog is closed."""
        if now.phase == "failed":
            table = "" if now.table is None else str(now.table)
            self._context.notifier.show(Message("error", "the sweep failed", table, now.words))
        elif not now.going:
            self._context.notifier.say(f"Sweep: {now.words}", _SAID_MS)

    def _proposed_table(self) -> Path:
        """A table beside the recording, which itself is never written to."""
        recording = self._session.document.recording
        if recording is not None:
            beside = recording.folder.resolve().parent
            if os.access(beside, os.W_OK):
                return beside / f"{recording.folder.name}-sweep.csv"
        return Path.home() / "sweep.csv"

    def _tell_facts(self, dialog: SweepDialog) -> None:
        """Let the fields begin with the recording that is open and the panel's settings."""
        form, track, document = dialog.form, self._session.track, self._session.document
        base = preset(track.preset).values()
        changes = [
            f"{name}={value_text(value)}" if not isinstance(value, float) else f"{name}={value!r}"
            for name, value in track.settings.values().items()
            if value != base[name]
        ]
        form.show_base(track.preset, changes)
        recording = document.recording
        if recording is not None and not form.recordings():
            folder, project = recording.folder.resolve(), self._session.project.path
            form.add_recording(folder)
            keypoints = self._session.keypoints
            if project is not None and keypoints.wanted and keypoints.cameras:
                form.set_keypoints(str(folder), project)
        if not form.table.text():
            form.table.setText(str(self.presenter.now.table or self._proposed_table()))
        selection = self._context.view_state.selection
        if selection and not form.frames.text():
            form.frames.setText(f"{selection.start}:{selection.stop}")
        form.changed.emit()
