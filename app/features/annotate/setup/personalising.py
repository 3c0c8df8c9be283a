"""A personalised body from a few clicked frames: estimated in the background, used as one edit."""

from collections.abc import Callable
from dataclasses import replace

from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.personal_subject import (
    FEWEST,
    Personalise,
    PersonalSubject,
    lean_words,
    left_out_words,
)
from stereotrack_core.counting import counted
from stereotrack_core.project.entries import UseSubject
from stereotrack_core.tracking.frame import Run

from ....context import Context
from ....services.actions import Command, Menu
from ....session.changes import Part
from ....session.jobs import Job, NewestJob
from ....session.messages import Message
from ..filling.retracking import ClickedFrames, in_process

ORIGIN = "personalised"  # what the project says of where such a subject comes from


class Personalising:
    """Has the subject's offsets estimated, and lets the project use them."""

    def __init__(
        self, context: Context, clicked: ClickedFrames, fit_settings: Callable[[], FitSettings]
    ) -> None:
        self._context, self._session = context, context.session
        self._clicked, self._settings = clicked, fit_settings
        self._job = NewestJob(context.tasks)
        context.session.changes.watch(Part.PROJECT_CLOSING, self._job.cancel)

    def why_not(self) -> str:
        why_not = self._session.no_recording() or self._session.project.why_no_edit()
        recording = self._session.document.recording
        if why_not or recording is None:
            return why_not
        if recording.guessed:
            return "The calibration is a guess. Replace it with a calibration of these cameras."
        if self._job.busy:
            return "The body is being personalised. Wait for it, or stop it."
        count = len(self._clicked.frames())
        if count < FEWEST:
            todo = f"Click all landmarks in {FEWEST} frames first, in two views or more"
            return f"{todo}; {counted(count, 'frame')} clicked so far."
        if self._run() is None and not self._session.clouds.available:
            return "Track the recording first: without depth it cannot be tracked here."
        return ""

    def begin(self) -> None:
        recording, project = self._session.document.recording, self._session.project.project
        if self.why_not() or recording is None or project is None:
            return
        todo = Personalise(
            replace(recording, reference=None, subject=self._session.project.subject()),
            project.clicks.all(), project.click_sigmas(), self._settings(), project.path.name,
            self._run(),
        )  # fmt: skip
        process, last = self._session.processes.trials, max(self._clicked.frames()) + 1

        def use(found: PersonalSubject) -> None:
            if project is self._session.project.project:
                self._session.project.apply(UseSubject(found.subject, ORIGIN))
                self._context.notifier.show(_message(found))

        title = "personalising the body"
        self._job.run(Job(title, lambda task: in_process(process, todo, task, last), use))

    def _run(self) -> Run | None:
        """The active run where it is finished and tracked in clicked frames enough."""
        if (entry := self._session.finished_run) is None:
            return None
        known = [entry.at(frame) for frame in self._clicked.frames()]
        if sum(one is not None and one.pose is not None for one in known) < FEWEST:
            return None
        return entry.run()


def _message(found: PersonalSubject) -> Message:
    frames = counted(len(found.found.frames), "clicked frame")
    left_out = "".join(f" {one[:1].upper()}{one[1:]}." for one in left_out_words(found))
    remedy = (
        f"{lean_words(found)}{left_out} The next run uses it: landmarks and angles change, the "
        "tracked surface stays. Undo takes it back; Annotate, Subject … saves it to a file."
    )
    return Message("note", f"the body is personalised from {frames}", remedy=remedy)


def personal_command(personalising: Personalising) -> Command:
    """Command of the menu Annotate."""
    return Menu("&Annotate", personalising.why_not).command(
        "annotate-personalise", "Personalise body", "Estimate from the clicked frames where this "
        "person's joints lie in the tracked body, and use it for the next run. You can undo this.",
        personalising.begin, icon="ruler",
    )  # fmt: skip
