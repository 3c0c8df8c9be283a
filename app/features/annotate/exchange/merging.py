"""Clicks from a file or another project beside the project's, and what becomes of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from functools import partial

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import QCheckBox, QPlainTextEdit, QWidget

from stereotrack_core.annotation.agreement import Difference, farthest_first
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import PlaceClicks
from stereotrack_core.project.merging import Decision, Incoming, has_mean
from stereotrack_core.project.project import Project

from ....services.tasks.task import Task, TaskList
from ....widgets.forms.form_dialog import FormDialog, push_button
from ....widgets.style.building import hbox, label
from ....widgets.tables.decision_table import DecisionTable
from ....widgets.tables.table import selected_rows

_SHOWN_PROBLEMS = 50
_KINDS = {
    "only first": "deleted on one side",
    "only second": "deleted on one side",
    "seen differently": "different visibility",
}


class TakeIn:
    """What would be merged, decided click by click; nothing is written before :meth:`edit`.

    Attributes
    ----------
    problems : tuple of InputError
        What could not be read at all.
    """

    def __init__(self, incoming: Incoming, problems: Iterable[InputError] = ()) -> None:
        self.incoming, self.problems = incoming, tuple(problems)
        worst = farthest_first(incoming.conflicts)
        known = {one.key for one in worst}
        others = (one for one in incoming.conflicts if one.key not in known)
        self.conflicts: tuple[Difference, ...] = (*worst, *others)
        """What contradicts, the worst first."""
        self._decisions: dict[ClickKey, Decision] = {}
        self.with_new = True
        """Whether clicks that the project says nothing about are taken."""

    def decision(self, row: int) -> Decision:
        """What becomes of a conflict; the project's click stays until something else is said."""
        return self._decisions.get(self.conflicts[row].key, "mine")

    def decide(self, rows: Iterable[int], decision: Decision) -> None:
        """Decide conflicts; where there is no mean, the decision stays as it was."""
        for row in rows:
            conflict = self.conflicts[row]
            if decision != "mean" or has_mean(conflict):
                self._decisions[conflict.key] = decision

    def with_decisions_of(self, other: TakeIn) -> TakeIn:
        """The comparison itself, with what was decided in another one of the same clicks."""
        known = {one.key for one in self.conflicts}
        self._decisions = {key: d for key, d in other._decisions.items() if key in known}
        self.with_new = other.with_new
        return self

    def edit(self) -> PlaceClicks:
        """The one edit that does what was decided; of no click where nothing would change."""
        return self.incoming.edit(self._decisions, with_new=self.with_new)

    def summary(self) -> str:
        """``412 new, 1208 equal, 4 differ (3 moved, 1 different visibility)``."""
        parts = [f"{len(self.incoming.new)} new", f"{len(self.incoming.same)} equal"]
        if self.conflicts:
            found = Counter(_KINDS.get(one.kind, "moved") for one in self.conflicts)
            names = ("moved", "different visibility", "deleted on one side")
            said = ", ".join(f"{found[name]} {name}" for name in names if found[name])
            parts.append(f"{len(self.conflicts)} differ ({said})")
        return f"{self.incoming.source}: {', '.join(parts)}."

    def what_happens(self) -> str:
        """What :meth:`edit` would do, in words; empty for nothing."""
        taken = len(self.edit().clicks)
        kept = len(self.conflicts) - (taken - len(self.incoming.new) * self.with_new)
        words = f"{counted(taken, 'click')} will be written"
        left = f", {counted(kept, 'conflict')} keep the project's click" if kept else ""
        return f"{words}{left}." if taken else ""

    def problem_words(self) -> tuple[str, ...]:
        """What could not be read, line by line."""
        shown = self.problems[:_SHOWN_PROBLEMS]
        words = [f"{problem.what}. {problem.remedy}".strip() for problem in shown]
        if (more := len(self.problems) - len(words)) > 0:
            words.append(f"and {more} more")
        return tuple(words)


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
        task = self._tasks.write("merging clicks", work, self._on_worked)
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
