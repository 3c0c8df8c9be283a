"""Look at clicks from elsewhere before any of them is taken into the project."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import QCheckBox, QPlainTextEdit, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.project.merging import Decision
from stereotrack_core.project.project import Project

from ....services.tasks.task import Task, TaskList
from ....widgets.forms.form_dialog import FormDialog, push_button
from ....widgets.style.building import hbox, label
from ....widgets.tables.decision_table import DecisionTable
from ....widgets.tables.table import selected_rows
from .taking_in import TakeIn

_DECISIONS: dict[Decision, tuple[str, str]] = {
    "mine": ("Keep &mine", "Keep the click in this project (M)"),
    "theirs": ("Use &theirs", "Use the other click (T)"),
    "mean": ("Use mea&n", "Use the midpoint of both clicks, where both have a position (B)"),
}
_WHERE = "Applies to the selected rows, or to all rows if none is selected."


class TakeInDialog(FormDialog):
    """What is new, what is equal, and what contradicts; every contradiction can be decided.

    Parameters
    ----------
    compare : callable
        Compares once more with the project as it is then.
    shown : TakeIn
        The comparison that was made last.
    tasks : TaskList
        Where clicks are written.
    """

    visit_requested = Signal(int, str, str)
    """Frame, camera and landmark of a click that the person wants to see."""
    taken_in = Signal(str)
    """What was done, in words."""

    def __init__(
        self,
        project: Project,
        compare: Callable[[], TakeIn],
        shown: TakeIn,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        title = f"Merge clicks from {shown.incoming.source}"
        super().__init__(title, "Merge", self._take, parent)
        self._project, self._compare, self.shown = project, compare, shown
        self._tasks = tasks
        self.summary = label("", "heading")
        self.problems = QPlainTextEdit(readOnly=True)
        self.problems.setMaximumHeight(92)
        self.problems.setAccessibleName("Lines that cannot be read")
        self._problems_words, self._conflict_words = label(), label()
        self.with_new = QCheckBox()
        self.with_new.toggled.connect(self._on_with_new)
        self.table = DecisionTable()
        self.table.decided.connect(self._on_decided)
        self.table.visit_requested.connect(
            lambda row: self.visit_requested.emit(*self.shown.conflicts[row].key)
        )
        self.outcome = label()
        self.decide_buttons = {
            decision: push_button(
                text, partial(self._on_decide_button, decision), f"{tip}. {_WHERE}"
            )
            for decision, (text, tip) in _DECISIONS.items()
        }
        self._deciding = QWidget()
        self._deciding.setLayout(hbox((self._conflict_words, 1), *self.decide_buttons.values()))
        self.lay_out(
            self.summary, self._problems_words, self.problems, self.with_new, self._deciding,
            (self.table, 1), None, self.outcome, size=(860, 560 if shown.conflicts else 200),
        )  # fmt: skip
        self._show(shown)

    def _show(self, shown: TakeIn) -> None:
        self.shown = shown
        self.summary.setText(shown.summary())
        count, new, conflicts = len(shown.problems), len(shown.incoming.new), len(shown.conflicts)
        verb = "cannot be read and is" if count == 1 else "cannot be read and are"
        self._problems_words.setText(f"{counted(count, 'line')} {verb} skipped:")
        self.problems.setPlainText("\n".join(shown.problem_words()))
        self.with_new.setText(f"Add {counted(new, 'new click')}")
        self.with_new.setChecked(shown.with_new)
        self._conflict_words.setText(
            f"{counted(conflicts, 'click')} of the project would change. Your clicks are kept "
            "unless you choose otherwise."
        )
        for widget, number in (
            (self._problems_words, count), (self.problems, count), (self.with_new, new),
            (self._deciding, conflicts), (self.table, conflicts),
        ):  # fmt: skip
            widget.setVisible(number > 0)
        self.table.show_rows(shown.conflicts, shown.decision)
        self._tell_outcome()

    def _tell_outcome(self) -> None:
        self.table.show_decisions()
        words = self.shown.what_happens()
        self.outcome.setText(words or "Nothing will be written.")
        self.accept_button.setEnabled(bool(words))
        self.say("")

    @Slot(bool)
    def _on_with_new(self, checked: bool) -> None:
        self.shown.with_new = checked
        self._tell_outcome()

    def _on_decide_button(self, decision: Decision) -> None:
        rows = selected_rows(self.table) or range(len(self.shown.conflicts))
        self._on_decided(list(rows), decision)

    @Slot(list, str)
    def _on_decided(self, rows: list[int], decision: Decision) -> None:
        self.shown.decide(rows, decision)
        self._tell_outcome()

    def _take(self) -> None:
        """Compare once more and write, beside the window's thread."""
        project, compare, shown = self._project, self._compare, self.shown
        edit = shown.edit()

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
            self._show(result.with_decisions_of(self.shown))
            self._complain(
                "The project has changed in the meantime. Check the comparison again, then merge."
            )

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self._set_busy(busy=False)
        self._complain(str(error))

    def _set_busy(self, *, busy: bool) -> None:
        for widget in (self.table, self._deciding, self.with_new, self.accept_button):
            widget.setEnabled(not busy)
        self._tell_outcome()
        if busy:
            self.accept_button.setEnabled(False)
            self.outcome.setText("Writing …")

    def _complain(self, text: str) -> None:
        self.say(text, error=True)
        self.words.setFocus(Qt.FocusReason.OtherFocusReason)
