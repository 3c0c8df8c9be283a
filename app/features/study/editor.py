"""A study whose every edit is saved at once and can be undone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.study.file import Study
from stereotrack_core.study.stored import StoredStudy

from ...session.edits import EditStack, Moved, WindowEdit
from ...widgets.forms.message import Message


class StudyEditor(QObject):
    """Makes edits, saves them, and takes them back.

    Attributes
    ----------
    stack : EditStack
        What undo and redo do next.
    """

    changed = Signal()
    """The study is another one."""
    said = Signal(str, bool)
    """What was undone or redone, or why it could not be: whether it is an error."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._stored = StoredStudy(Study(Path()), "")
        self.stack = EditStack(self)
        self.stack.moved.connect(self._on_moved)
        self.stack.message.connect(self._on_message)

    @property
    def study(self) -> Study:
        """The study as it is saved."""
        return self._stored.study

    @property
    def is_current(self) -> bool:
        """Whether the file is as this program has read or written it."""
        return self._stored.is_current

    def show(self, stored: StoredStudy) -> None:
        """Go on with a study as it was read; edits of the one before can no longer be undone."""
        self._stored = stored
        self.stack.clear()

    def do(self, words: str, edit: Callable[[Study], Study]) -> bool:
        """Make an edit and save it; False where nothing is different.

        Raises InputError where it makes no sense or cannot be saved; then nothing has changed.
        """
        before = self.study
        after = edit(before)
        if after == before:
            return False
        self.stack.do(WindowEdit(words, self._put, before, after, is_data=True))
        return True

    def _put(self, study: Study) -> None:
        self._stored = self._stored.saved(study)
        self.changed.emit()

    @Slot(object)
    def _on_moved(self, moved: Moved) -> None:
        self.said.emit(f"{moved.how.capitalize()}: {moved.words}.", False)

    @Slot(object)
    def _on_message(self, message: Message) -> None:
        self.said.emit(message.sentence(), True)
