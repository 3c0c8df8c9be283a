"""Studies: which one is wanted; its window is made when it is wanted first."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.study.description import SUFFIX, Study, StudySettings, write_study

from ...context import Context
from ...services.actions import Menu
from ...session.changes import Part
from ...widgets.forms.form_dialog import ask_to_open, ask_to_save

if TYPE_CHECKING:
    from .window import StudyWindow

_FILTER = f"Study (*{SUFFIX})"


def register(context: Context) -> StudyController:
    """Offer studies."""
    studies = StudyController(context)
    file, track = Menu("&File").command, Menu("&Track", context.session.no_recording).command
    context.actions.add([
        file("new_study", "New study …", "Make a study file (.study.toml): recordings with their "
             "subjects and conditions, and the settings that all are tracked with.",
             studies.ask_for_new, "Ctrl+Alt+Shift+N", "add", section=True),
        file("open_study", "Open a study …", "Show the recordings of a study file (.study.toml) "
             "in one table: annotation, runs, errors, failures and problems. Track and evaluate "
             "them together.", studies.ask_for_study, "Ctrl+Alt+Shift+O", "table"),
        track("sweep", "Sweep …", "Track the open recording with several parameter values and "
              "seeds in the background, and compare the results: a study of one recording.",
              studies.sweep, "Ctrl+Alt+S", "grid", section=True),
    ])  # fmt: skip
    return studies


class StudyController:
    """Asks which study is wanted, and shows it."""

    def __init__(self, context: Context) -> None:
        self._context, self._state = context, context.session.study
        self.window: StudyWindow | None = None
        context.session.changes.hear(Part.STUDY_WANTED, self.open_study)
        context.session.changes.watch(Part.STUDY, self._show)

    def _show(self) -> None:
        if self._state.study is not None:
            from .window import StudyWindow

            self.window = self.window or StudyWindow(self._context)
            self.window.show_study(self._state.study)

    def _folder(self) -> Path:
        if self._state.study is not None:
            return self._state.study.folder
        recording = self._context.session.document.recording
        return Path.home() if recording is None else recording.folder.resolve().parent

    def ask_for_study(self) -> None:
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Open a study", self._folder(), _FILTER, self.open_study)

    def ask_for_new(self) -> None:
        """Let the person choose where a new study is kept, and show it; nothing is overwritten."""

        def make(path: Path) -> None:
            stem = path.name.removesuffix(".toml").removesuffix(".study")
            settings = self._state.panel_settings(StudySettings())
            self._write_and_open(Study(path.with_name(stem + SUFFIX), settings=settings))

        folder, parent = self._folder(), self._context.docks.dialog_parent
        proposed = folder / f"{folder.name or 'walks'}{SUFFIX}"
        ask_to_save(parent, "New study", proposed, _FILTER, make, goes_on=True)

    def sweep(self) -> None:
        """Show a study of the open recording alone, which is made if there is none yet."""
        recording = self._context.session.document.recording
        if recording is not None:
            from .pages import study_of_open

            folder = recording.folder.resolve()
            beside = folder.parent if os.access(folder.parent, os.W_OK) else Path.home()
            made = study_of_open(self._context, beside / f"{folder.name}-sweep{SUFFIX}")
            if self._write_and_open(made) and self.window is not None:
                self.window.tabs.setCurrentWidget(self.window.form)

    def _write_and_open(self, study: Study) -> bool:
        there = study.path.exists() or self._context.notifier.attempt(lambda: write_study(study))
        return there and self.open_study(study.path)

    def open_study(self, path: Path) -> bool:
        shown = self._context.notifier.attempt(partial(self._state.open, path))
        if shown and self.window is not None:
            self.window.show()
            self.window.raise_()
        return shown
