"""Shows the wizard for whatever is no recording yet, and opens what was made."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Qt, Slot

from ....context import Context
from ....services.tasks.task import Task
from ....widgets.forms.form_dialog import ask_for_folder
from .looking import Looked, look
from .wizard import ImportWizard


class ImportController(QObject):
    """From dropped videos, or a folder without a recording.toml, to an open recording."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context = context
        self._looking: Task | None = None
        self.wizard: ImportWizard | None = None
        """The one that is shown."""
        context.session.opening.import_wanted.connect(self.offer)

    def ask_for_videos(self) -> None:
        """Let the person choose the folder of the videos."""
        parent = self._context.docks.dialog_parent
        recent = self._context.session.opening.recent()
        start = recent[0].parent if recent else Path.home()
        ask_for_folder(
            parent, "Folder of the videos or images", start, lambda path: self.offer((path,))
        )

    @Slot(object)
    def offer(self, paths: tuple[Path, ...]) -> None:
        """Look at videos and images, and show the wizard."""
        if self.wizard is not None:  # what is being filled in is not thrown away
            self.wizard.raise_()
            return
        self._looking = self._context.tasks.begin(
            "looking at the videos", lambda _task: look(paths), self._show
        )

    @Slot(object)
    def _show(self, looked: Looked) -> None:
        if self.sender() is not self._looking or self.wizard is not None:
            return
        wizard = ImportWizard(looked, self._context.tasks, self._context.docks.dialog_parent)
        wizard.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        wizard.made.connect(self._context.session.opening.open)
        wizard.finished.connect(self._on_finished)
        self.wizard = wizard
        wizard.open()

    @Slot()
    def _on_finished(self) -> None:
        self.wizard = None
