"""Clicks from a file or another project: which file, what is in it, and what becomes of them."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from PySide6.QtWidgets import QFormLayout, QPlainTextEdit, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, stated_names
from stereotrack_core.interop.labels import LABEL_SUFFIXES
from stereotrack_core.interop.landmark_file import world_from_axes
from stereotrack_core.interop.run_file import TRAJECTORY_SUFFIXES
from stereotrack_core.project.merging import Decision, Incoming
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording

from ....context import Context
from ....session.jobs import Job, Task
from ....widgets.forms.form_dialog import FormDialog, ask_to_open, files_of, line_edit, push_button
from ....widgets.style.building import choice, hbox, label

_FILES = ";;".join(
    (
        files_of("Labels and references", (*LABEL_SUFFIXES, *TRAJECTORY_SUFFIXES)),
        files_of("Labels", LABEL_SUFFIXES),
        files_of("Trajectories", TRAJECTORY_SUFFIXES),
    )
)
_WORDS = (
    "Clicks, DeepLabCut labels and COCO keypoints are compared with the project before anything "
    "is written. A trajectory is added as a reference of the project."
)
_AS_STATED = "as stated in the file"
_AXES = ("x,y,z", "-x,-y,z", "z,x,y", "x,-z,y", "x,z,-y")


class ImportDialog(FormDialog):
    """A file, the camera that it is of, and what its landmarks are called here."""

    def __init__(
        self,
        recording: Recording,
        landmarks: Sequence[str],
        folder: str,
        use: Callable[[LabelSource], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import clicks", "Compare …", self._on_accepted, parent)
        self._use = use
        self._recording, self._landmarks, self._folder = recording, landmarks, folder
        cameras = dict.fromkeys((*(view.name for view in recording.views), *recording.cameras))
        self.path = line_edit("File")
        self.camera = choice(
            "Camera",
            [("", "as stated in the file"), *((name, name) for name in cameras)],
            "DeepLabCut and COCO files often hold a single camera.",
        )
        self.names = line_edit(
            "Names",
            placeholder="left_wrist=left_hand, nose=head",
            tip="Landmark names in the file and their names here, where they differ",
        )
        self.axes = choice(
            "Axes",
            [("", _AS_STATED), *((axes, axes) for axes in _AXES)],
            "Of a trajectory: the file's axes that point east, north and up, such as x,-z,y.",
        )
        self.axes.setEditable(True)
        self.path.textChanged.connect(self._check)
        self.names.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("File", hbox((self.path, 1), push_button("&Choose …", self._ask)))
        for field in (self.camera, self.names, self.axes):
            form.addRow(field.accessibleName(), field)
        self.lay_out(label(_WORDS, "muted"), form, None, size=(560, 280))
        self._check()

    def ask_again(self, source: LabelSource, complaint: str) -> None:
        self.path.setText(str(source.path))
        self.names.setText(", ".join(f"{one}={two}" for one, two in (source.names or {}).items()))
        self.axes.setCurrentText(source.axes or _AS_STATED)
        self.axes.setFocus()
        self.say(complaint, error=True)

    def _ask(self) -> None:
        use = self.path.setText
        ask_to_open(self, "Import clicks", self._folder, _FILES, lambda path: use(str(path)))

    def _check(self) -> None:
        self.say("")
        self.accept_button.setEnabled(bool(self.path.text().strip()))

    def _on_accepted(self) -> None:
        path = Path(self.path.text().strip())

        def take() -> None:
            names = stated_names(self.names.text().split(","))
            if not path.is_file():
                remedy = "Choose another file."
                raise InputError("there is no such file", where=str(path), remedy=remedy)
            camera = self.camera.currentData() or None
            axes = self.axes.currentText().strip().replace(_AS_STATED, "")
            if axes:
                world_from_axes(axes, "Axes")
            known = self._recording, self._landmarks
            self._use(LabelSource(path, *known, camera, names, axes))

        if self.attempt(take):
            self.accept()


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

    `compare` repeats the comparison `shown`; `problems` are errors of reading.
    """

    def __init__(
        self,
        project: Project,
        compare: Callable[[], Incoming],
        shown: Incoming,
        problems: Iterable[InputError],
        context: Context,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(f"Clicks of {shown.source}", "Merge", self._take, parent)
        self._project, self._compare, self._shown = project, compare, shown
        self._context = context
        problems = tuple(problems)
        self.summary = label(_summary(shown), "heading")
        self.problems = QPlainTextEdit("\n".join(_problem_words(problems)), readOnly=True)
        self.problems.setMaximumHeight(92)
        self.problems.setAccessibleName("Lines that cannot be read")
        verb = "cannot be read and is" if len(problems) == 1 else "cannot be read and are"
        problem_words = label(f"{counted(len(problems), 'line')} {verb} skipped:")
        conflict_words = label(_conflict_words(shown))
        self.decision = choice("Clicks that differ", _DECISIONS)
        self.decision.currentIndexChanged.connect(self._show_outcome)
        self.outcome = label()
        self.lay_out(
            self.summary, problem_words, self.problems, conflict_words, self.decision, None,
            self.outcome, size=(560, 240),
        )  # fmt: skip
        for there, widgets in (
            (problems, (problem_words, self.problems)),
            (shown.conflicts, (conflict_words, self.decision)),
        ):
            for widget in widgets:
                widget.setVisible(bool(there))
        self._show_outcome()

    def _show_outcome(self) -> None:
        shown = self._shown
        taken = len(shown.taken(self.decision.currentData()))
        kept = len(shown.conflicts) + len(shown.new) - taken
        verb = "keeps" if kept == 1 else "keep"
        left = f", {counted(kept, 'conflict')} {verb} the project's click" if kept else ""
        words = f"{counted(taken, 'click')} will be written{left}." if taken else ""
        self.outcome.setText(words or "Nothing will be written.")
        self.accept_button.setEnabled(taken > 0)
        self.say("")

    def _take(self) -> None:
        """Compare once more, as the project may have changed, and write in the background."""
        project, compare = self._project, self._compare
        decision: Decision = self.decision.currentData()

        def work(_task: Task) -> str:
            edit = compare().edit(decision)
            project.apply(edit)
            return edit.words

        def done(words: str) -> None:
            self._context.notifier.say(words)
            self.accept()

        def failed(error: Exception) -> None:
            self._show_outcome()
            self.say(str(error), error=True)

        self.accept_button.setEnabled(False)
        self.outcome.setText("Writing …")
        self._context.tasks.write(Job("merging clicks", work, done, failed))


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
    verb = "differs" if len(incoming.conflicts) == 1 else "differ"
    return f"{counted(len(incoming.conflicts), 'click')} {verb} from the project's."


def _problem_words(problems: tuple[InputError, ...]) -> list[str]:
    shown = problems[:_SHOWN_PROBLEMS]
    words = [f"{problem.what}. {problem.remedy}".strip() for problem in shown]
    if (more := len(problems) - len(words)) > 0:
        words.append(f"and {more} more")
    return words
