"""A recording made of videos or images: what was found, what is chosen, where it goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from ....context import Context
from ....session.changes import Part
from ....session.jobs import Job, NewestJob
from ....widgets.forms.form_dialog import ask_for_folder

if TYPE_CHECKING:
    from .sources_page import Looked
    from .wizard import ImportWizard


class ImportController:
    """From dropped videos, or a folder without a recording.toml, to an open recording.

    What it takes for that is loaded when it is wanted, so that the window is there sooner.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._looking = NewestJob(context.tasks)
        self.wizard: ImportWizard | None = None
        self._session = context.session
        context.session.changes.hear(Part.IMPORT_WANTED, self.offer)

    def ask_for_videos(self) -> None:
        parent, start = self._context.docks.dialog_parent, self._session.recent_folder()
        title = "Folder of the videos or images"
        ask_for_folder(parent, title, start, lambda path: self.offer((path,)))

    def ask_to_attach(self) -> None:
        from .calibration_page import ask_to_attach

        ask_to_attach(self._context)

    def offer(self, paths: tuple[Path, ...]) -> None:
        if self.wizard is not None:  # what is being filled in is not thrown away
            self.wizard.raise_()
            return
        from .sources_page import look

        self._looking.run(Job("looking at the videos", lambda _task: look(paths), self._show))

    def _show(self, looked: Looked) -> None:
        if self.wizard is not None:
            return
        from .wizard import ImportWizard

        parent = self._context.docks.dialog_parent
        wizard = ImportWizard(looked, self._context.tasks, self._session.open, parent)
        wizard.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        wizard.finished.connect(self._on_finished)
        self.wizard = wizard
        wizard.open()

    def _on_finished(self) -> None:
        self.wizard = None
