"""Look at clicks from elsewhere before any of them is taken into the project."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.project.merging import Decision
from stereotrack_core.project.project import Project

from ....services.tasks.task import Task, TaskList
from ....session.counting import counted
from ....widgets.tables.decision_table import DecisionTable
from ....widgets.tables.table import selected_rows
from .taking_in import TakeIn

_DECISIONS: dict[Decision, tuple[str, str]] = {
    "mine": ("Keep &mine", "Keep the click in this project (M)"),
    "theirs": ("Use &theirs", "Use the other click (T)"),
    "mean": ("Use mea&n", "Use the midpoint of both clicks, where both have a position (B)"),
}


class TakeInDialog(QDialog):
    """What is new, what is equal, and what contradicts; every contradiction can be decided.

    Parameters
    ----------
    project : Project
    compare : callable
        Compares once more with the project as it is then.
    shown : TakeIn
        The comparison that was made last.
    tasks : TaskList
        Where clicks are written.

    Signals
    -------
    visit_requested : int, str, str
        Frame, camera and landmark of a click that the person wants to see.
    taken_in : str
        What was done, in words.
    """

    visit_requested = Signal(int, str, str)
    taken_in = Signal(str)

    def __init__(
        self,
        project: Project,
        compare: Callable[[], TakeIn],
        shown: TakeIn,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Merge clicks from {shown.incoming.source}")
        self._project, self._compare, self._shown = project, compare, shown
        self._tasks = tasks
        self.summary = QLabel()
        self.summary.setWordWrap(True)
        self.summary.setProperty("role", "heading")
        self.problems = QPlainTextEdit()
        self.problems.setReadOnly(True)
        self.problems.setMaximumHeight(92)
        self.problems.setAccessibleName("Lines that cannot be read")
        self._problems_words = QLabel()
        self._problems_words.setWordWrap(True)
        self.with_new = QCheckBox()
        self.with_new.toggled.connect(self._on_with_new)
        self._conflict_words = QLabel()
        self._conflict_words.setWordWrap(True)
        self.table = DecisionTable()
        self.table.decided.connect(self._on_decided)
        self.table.visit_requested.connect(self._on_visit)
        self.outcome = QLabel()
        self.outcome.setWordWrap(True)
        self.failure = QLabel()
        self.failure.setWordWrap(True)
        self.failure.setProperty("role", "error")
        self.failure.hide()
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.take_button = self.buttons.addButton("Merge", QDialogButtonBox.ButtonRole.AcceptRole)
        self.buttons.accepted.connect(self._on_take)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(self.summary)
        layout.addWidget(self._problems_words)
        layout.addWidget(self.problems)
        layout.addWidget(self.with_new)
        self._deciding = self._deciding_row()
        layout.addWidget(self._deciding)
        layout.addWidget(self.table, 1)
        layout.addStretch()
        layout.addWidget(self.outcome)
        layout.addWidget(self.failure)
        layout.addWidget(self.buttons)
        self._show(shown)
        self.resize(860, 560 if shown.conflicts else 200)

    @property
    def shown(self) -> TakeIn:
        """The comparison that is shown."""
        return self._shown

    def _deciding_row(self) -> QWidget:
        box = QWidget()
        row = QHBoxLayout(box)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self._conflict_words, 1)
        self.decide_buttons: dict[Decision, QPushButton] = {}
        for decision, (text, tip) in _DECISIONS.items():
            button = QPushButton(text)
            button.setToolTip(
                f"{tip}. Applies to the selected rows, or to all rows if none is selected."
            )
            button.setAutoDefault(False)
            button.clicked.connect(lambda _=False, one=decision: self._on_decide_button(one))
            row.addWidget(button)
            self.decide_buttons[decision] = button
        return box

    def _show(self, shown: TakeIn) -> None:
        self._shown = shown
        kinds = shown.kinds()
        self.summary.setText(shown.summary())
        words = shown.problem_words()
        self._problems_words.setVisible(bool(words))
        self.problems.setVisible(bool(words))
        count = len(shown.problems)
        verb = "cannot be read and is" if count == 1 else "cannot be read and are"
        self._problems_words.setText(f"{counted(count, 'line')} {verb} skipped:")
        self.problems.setPlainText("\n".join(words))
        self.with_new.setVisible(kinds.new > 0)
        self.with_new.setText(f"Add {counted(kinds.new, 'new click')}")
        self.with_new.setChecked(shown.with_new)
        self._deciding.setVisible(kinds.conflicts > 0)
        self.table.setVisible(kinds.conflicts > 0)
        self._conflict_words.setText(
            f"{counted(kinds.conflicts, 'click')} of the project would change. Your clicks are "
            "kept unless you choose otherwise."
        )
        self.table.show_rows(shown.conflicts, shown.decision)
        self._tell_outcome()

    def _tell_outcome(self) -> None:
        self.table.show_decisions()
        taken = self._shown.taken()
        self.outcome.setText(self._shown.what_happens() if taken else "Nothing will be written.")
        self.take_button.setEnabled(taken > 0)
        self.failure.hide()

    @Slot(bool)
    def _on_with_new(self, checked: bool) -> None:
        self._shown.with_new = checked
        self._tell_outcome()

    def _on_decide_button(self, decision: Decision) -> None:
        rows = selected_rows(self.table) or range(len(self._shown.conflicts))
        self._on_decided(list(rows), decision)

    @Slot(list, str)
    def _on_decided(self, rows: list[int], decision: Decision) -> None:
        self._shown.decide(rows, decision)
        self._tell_outcome()

    @Slot(int)
    def _on_visit(self, row: int) -> None:
        self.visit_requested.emit(*self._shown.conflicts[row].key)

    @Slot()
    def _on_take(self) -> None:
        """Compare once more and write, beside the window's thread."""
        project, compare, shown = self._project, self._compare, self._shown
        try:
            edit = shown.edit()
        except InputError as error:
            self._say(str(error))
            return

        def work(_task: Task) -> TakeIn | str:
            now = compare()
            if now.incoming != shown.incoming:
                return now
            project.apply(edit)
            return edit.words()

        self._set_busy(busy=True)
        task = self._tasks.begin("merging clicks", work, self._on_worked)
        task.failed.connect(self._on_failed)

    @Slot(object)
    def _on_worked(self, result: TakeIn | str) -> None:
        self._set_busy(busy=False)
        if isinstance(result, str):
            self.taken_in.emit(result)
            self.accept()
        else:
            self._show(result.with_decisions_of(self._shown))
            self._say(
                "The project has changed in the meantime. Check the comparison again, then merge."
            )

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self._set_busy(busy=False)
        self._say(str(error))

    def _set_busy(self, *, busy: bool) -> None:
        for widget in (self.table, self._deciding, self.with_new, self.take_button):
            widget.setEnabled(not busy)
        if busy:
            self.outcome.setText("Writing …")
            self.failure.hide()
        else:
            self._tell_outcome()

    def _say(self, words: str) -> None:
        self.failure.setText(words)
        self.failure.show()
        self.failure.setFocus(Qt.FocusReason.OtherFocusReason)
