"""A personalised body from a few clicked frames: estimated in the background, shown, taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from PySide6.QtCore import QObject, Qt, Slot
from PySide6.QtWidgets import QWidget

from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.personal_subject import (
    FEWEST,
    Personalise,
    PersonalSubject,
    lean_words,
    left_out_words,
    length_table,
    offset_table,
)
from stereotrack_core.counting import counted
from stereotrack_core.project.entries import UseSubject
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Subject
from stereotrack_core.tracking.frame import Run

from ....context import Context
from ....services.actions import Command, Menu
from ....services.tasks.task import Task
from ....widgets.forms.form_dialog import FormDialog
from ....widgets.style.building import label
from ....widgets.tables.table import PlainTable
from ..clicking.clicked_frames import ClickedFrames

ORIGIN = "personalised"
"""What the project says of where such a subject comes from."""

_FILES = "Subject (*.toml)"
_ABOUT = (
    "Where shoulders, hips, head, elbows and hands of this person lie in the tracked body, with "
    "standard deviations. The next run uses them: landmarks and angles change, the tracked surface "
    "stays. You can undo this."
)


class PersonalDialog(FormDialog):
    """What the clicks say of a person, to be taken or not."""

    def __init__(
        self, found: PersonalSubject, known: Subject | None, project: Project, parent: QWidget
    ) -> None:
        super().__init__("Personalised body", "&Use for this project", self._use, parent)
        self._found, self._project = found, project
        self.lengths, self.offsets = PlainTable("Lengths, mm"), PlainTable("Offsets, mm", most=9)
        self.lengths.show_table(length_table(found, known))
        self.offsets.show_table(offset_table(found))
        said = [
            lean_words(found),
            *(f"{one[:1].upper()}{one[1:]}." for one in left_out_words(found)),
        ]
        self.lean = label("\n".join(said))
        parts = (self.offsets, self.lean, self.lengths, label(_ABOUT, "muted"))
        self.lay_out(*parts, size=(560, 600))
        self.accept_button.setEnabled(not project.read_only)

    def _use(self) -> None:
        edit = UseSubject(self._found.subject, ORIGIN)
        if self.attempt(lambda: self._project.apply(edit)):
            self.accept()


class Personalising(QObject):
    """Has the offsets estimated, and shows what they come to."""

    def __init__(
        self, context: Context, clicked: ClickedFrames, fit_settings: Callable[[], FitSettings]
    ) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._clicked, self._settings = clicked, fit_settings
        self._task: Task | None = None
        context.session.project.closing.connect(self.cancel)

    # ---- what can be done

    @Slot()
    def cancel(self) -> None:
        """Stop the estimate that is under way."""
        if self._task is not None:
            self._task.cancel()

    def why_not(self) -> str:
        """Why no body can be personalised now, as a sentence; empty where it can."""
        recording = self._session.document.recording
        why_not = self._session.no_recording() or self._session.project.why_no_edit()
        if why_not or recording is None:
            return why_not
        if recording.guessed:
            return "The calibration is a guess. Replace it with a calibration of these cameras."
        if self._task is not None:
            return "The body is being personalised. Wait for it, or stop it."
        count = len(self._clicked.frames())
        if count < FEWEST:
            return (
                f"Click all landmarks in {FEWEST} frames first, in two views or more; "
                f"{counted(count, 'frame')} clicked so far."
            )
        if self._run() is None and not self._session.clouds.available:
            return "Track the recording first: without depth it cannot be tracked here."
        return ""

    # ---- doing it

    def begin(self) -> None:
        """Estimate in the background, with the active run or, without one, a new one."""
        recording, project = self._session.document.recording, self._session.project.project
        if self.why_not() or recording is None or project is None:
            return
        subject = self._session.subject()
        todo = Personalise(
            replace(recording, reference=None, subject=subject), project.clicks.all(),
            project.click_sigmas(), self._settings(), project.path.name, self._run(),
        )  # fmt: skip
        last = max(self._clicked.frames()) + 1
        process, done = self._session.processes.trials, 0

        def work(task: Task) -> PersonalSubject:
            def hear(more: int) -> None:
                nonlocal done
                done += more
                task.report(done / last, f"tracking frame {done} of {last}")

            found: PersonalSubject = process(todo, hear, task.token.cancelled)
            return found

        def show(found: PersonalSubject) -> None:
            if project is self._session.project.project:
                self.show(found, subject, project)

        self._task = self._context.tasks.begin("personalising the body", work, show)
        self._task.ended.connect(self._on_ended)
        self._context.actions.refresh_soon()

    @Slot()
    def _on_ended(self) -> None:
        self._task = None
        self._context.actions.refresh_soon()

    def _run(self) -> Run | None:
        """The active run where it is finished and tracked in clicked frames enough."""
        entry = self._session.runs.active
        if entry is None or entry is self._session.track.entry:
            return None
        known = [entry.at(frame) for frame in self._clicked.frames()]
        if sum(one is not None and one.pose is not None for one in known) < FEWEST:
            return None
        return entry.run()

    def show(self, found: PersonalSubject, known: Subject | None, project: Project) -> None:
        """Show what was found beside the subject that is known."""
        parent = self._context.docks.dialog_parent
        dialog = PersonalDialog(found, known, project, parent)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        project_closing = self._session.project.closing
        project_closing.connect(dialog.close)
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()


def personal_commands(personalising: Personalising) -> list[Command]:
    """Commands of the menu Annotate."""
    command = Menu("&Annotate").command
    return [
        command("annotate-personalise", "Personalise body", "Estimate from the clicked frames "
                "where this person's joints lie in the tracked body, and show it before it is "
                "used.", personalising.begin, icon="ruler", why_not=personalising.why_not),
    ]  # fmt: skip
