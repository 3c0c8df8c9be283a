"""Clicks from a file or another project beside the project's, and what becomes of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import QCheckBox, QPlainTextEdit, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import PlaceClicks
from stereotrack_core.project.merging import Incoming
from stereotrack_core.project.project import Project

from ....services.tasks.task import Task, TaskList
from ....widgets.forms.form_dialog import FormDialog
from ....widgets.style.building import choice, label

_SHOWN_PROBLEMS = 50
_KINDS = {
    "only first": "deleted on one side",
    "only second": "deleted on one side",
    "seen differently": "different visibility",
}
_DECISIONS = (
    ("mine", "Keep mine"),
    ("theirs", "Use theirs"),
    ("mean", "Use the mean of both, or mine where there is none"),
)


class TakeInDialog(FormDialog):
    """Counts new, equal and differing clicks; one choice decides all that differ.

    Parameters
    ----------
    compare : callable
        Compares once more with the project as it is then.
    shown : Incoming
        The comparison that was made last.
    problems : iterable of InputError
        What could not be read at all.
    """

    taken_in = Signal(str)
    """What was done, in words."""

    def __init__(
        self,
        project: Project,
        compare: Callable[[], Incoming],
        shown: Incoming,
        problems: Iterable[InputError],
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(f"Merge clicks from {shown.source}", "Merge", self._take, parent)
        self._project, self._compare, self.shown = project, compare, shown
        self._tasks = tasks
        problems = tuple(problems)
        self.summary = label("", "heading")
        self.problems = QPlainTextEdit("\n".join(_problem_words(problems)), readOnly=True)
        self.problems.setMaximumHeight(92)
        self.problems.setAccessibleName("Lines that cannot be read")
        verb = "cannot be read and is" if len(problems) == 1 else "cannot be read and are"
        problem_words = label(f"{counted(len(problems), 'line')} {verb} skipped:")
        self.with_new = QCheckBox()
        self.with_new.setChecked(True)
        self.with_new.toggled.connect(self._tell_outcome)
        self._conflict_words = label()
        self.decision = choice("Clicks that differ", _DECISIONS)
        self.decision.currentIndexChanged.connect(self._tell_outcome)
        self.outcome = label()
        self.lay_out(
            self.summary, problem_words, self.problems, self.with_new, self._conflict_words,
            self.decision, None, self.outcome, size=(560, 240),
        )  # fmt: skip
        for widget in (problem_words, self.problems):
            widget.setVisible(bool(problems))
        self._show(shown)

    def _show(self, shown: Incoming) -> None:
        self.shown = shown
        self.summary.setText(_summary(shown))
        self.with_new.setText(f"Add {counted(len(shown.new), 'new click')}")
        self.with_new.setVisible(bool(shown.new))
        self._conflict_words.setText(_conflict_words(shown))
        for widget in (self._conflict_words, self.decision):
            widget.setVisible(bool(shown.conflicts))
        self._tell_outcome()

    def _edit(self) -> PlaceClicks:
        return self.shown.edit(self.decision.currentData(), with_new=self.with_new.isChecked())

    @Slot()
    def _tell_outcome(self) -> None:
        taken = len(self._edit().clicks)
        kept = len(self.shown.conflicts) + len(self.shown.new) * self.with_new.isChecked() - taken
        verb = "keeps" if kept == 1 else "keep"
        left = f", {counted(kept, 'conflict')} {verb} the project's click" if kept else ""
        words = f"{counted(taken, 'click')} will be written{left}." if taken else ""
        self.outcome.setText(words or "Nothing will be written.")
        self.accept_button.setEnabled(taken > 0)
        self.say("")

    def _take(self) -> None:
        """Compare once more and write, beside the window's thread."""
        project, compare, shown = self._project, self._compare, self.shown
        edit = self._edit()

        def work(_task: Task) -> Incoming | str:
            now = compare()
            if now != shown:
                return now
            project.apply(edit)
            return edit.words()

        self._set_busy(busy=True)
        task = self._tasks.write("merging clicks", work, self._on_worked)
        task.failed.connect(self._on_failed)

    @Slot(object)
    def _on_worked(self, result: Incoming | str) -> None:
        self._set_busy(busy=False)
        if isinstance(result, str):
            self.taken_in.emit(result)
            self.accept()
        else:
            self._show(result)
            self._complain(
                "The project has changed in the meantime. Check the comparison again, then merge."
            )

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self._set_busy(busy=False)
        self._complain(str(error))

    def _set_busy(self, *, busy: bool) -> None:
        for widget in (self.decision, self.with_new):
            widget.setEnabled(not busy)
        self._tell_outcome()
        if busy:
            self.accept_button.setEnabled(False)
            self.outcome.setText("Writing …")

    def _complain(self, text: str) -> None:
        self.say(text, error=True)
        self.words.setFocus(Qt.FocusReason.OtherFocusReason)


def _summary(incoming: Incoming) -> str:
    """``412 new, 1208 equal, 4 differ (3 moved, 1 different visibility)``."""
    parts = [f"{len(incoming.new)} new", f"{len(incoming.same)} equal"]
    if incoming.conflicts:
        found = Counter(_KINDS.get(one.kind, "moved") for one in incoming.conflicts)
        names = ("moved", "different visibility", "deleted on one side")
        said = ", ".join(f"{found[name]} {name}" for name in names if found[name])
        parts.append(f"{len(incoming.conflicts)} differ ({said})")
    return f"{incoming.source}: {', '.join(parts)}."


def _conflict_words(incoming: Incoming) -> str:
    """How many clicks contradict the project's, and which of them is the farthest off."""
    verb = "differs" if len(incoming.conflicts) == 1 else "differ"
    words = f"{counted(len(incoming.conflicts), 'click')} {verb} from the project's."
    apart = [(one.distance, one.key) for one in incoming.conflicts if one.distance is not None]
    if not apart:
        return words
    distance, (frame, camera, landmark) = max(apart)
    where = f"{landmark.replace('_', ' ')} in {camera}, frame {frame}"
    return f"{words} Farthest apart: {where}, {distance:.1f} px."


def _problem_words(problems: tuple[InputError, ...]) -> list[str]:
    """Errors of reading, one per line."""
    shown = problems[:_SHOWN_PROBLEMS]
    words = [f"{problem.what}. {problem.remedy}".strip() for problem in shown]
    if (more := len(problems) - len(words)) > 0:
        words.append(f"and {more} more")
    return words
