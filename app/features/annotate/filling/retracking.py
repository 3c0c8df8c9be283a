"""Clicked frames for the tracker: a failure tracked again, a body estimated."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from stereotrack_core.annotation.click import click_detections
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.personal_subject import (
    FEWEST,
    Personalise,
    PersonalSubject,
    lean_words,
    left_out_words,
)
from stereotrack_core.counting import counted, frames_in_words
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.segment import limbs_words
from stereotrack_core.project.entries import use_subject
from stereotrack_core.project.history import Changed
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.prepare import Start
from stereotrack_core.tracking.repeating import StoredSpec, stored_spec
from stereotrack_core.tracking.retrack import Retrack, Retracked
from stereotrack_core.tracking.stored import shape_of_meta
from stereotrack_core.worker_processes import ProcessTask, TaskProcess

from ....context import Context
from ....services.actions import Command, Menu
from ....session.changes import PROJECT, Part
from ....session.jobs import Job, NewestJob, Task
from ....session.messages import Message
from ....session.runs import RunEntry
from ....session.session import Session
from ....widgets.tables.panels import BodyPanel

_MARGIN_S = 0.5  # seconds before and after a failure that are tracked again too
_ALONE_S = 1.0  # the same around a clicked frame in which no failure was detected
_SOON_MS = 200


class ClickedFrames:
    """Which frames of the project have a click; read once between edits of clicks."""

    def __init__(self, session: Session) -> None:
        self._project = session.project
        self._frames: set[int] | None = None
        session.changes.hear(Part.EDIT, self._on_edited)
        session.changes.watch(PROJECT, self._forget)

    def frames(self) -> set[int]:
        project = self._project.project
        if project is None:
            return set()
        if self._frames is None:
            self._frames = set(map(int, project.clicks.frames()))
        return self._frames

    def within(self, frames: range) -> bool:
        return not self.frames().isdisjoint(frames)

    def _on_edited(self, changed: Changed) -> None:
        if "click" in changed.tables:
            self._forget()

    def _forget(self) -> None:
        self._frames = None


class Retracking:
    """Knows in which failure the frame that is shown lies, and has it tracked again.

    `body`: the panel that shows a hint on the failure.
    """

    def __init__(self, context: Context, clicked: ClickedFrames, body: BodyPanel) -> None:
        self._context, self._session, self._clicked = context, context.session, clicked
        self._body = body
        self._job = NewestJob(context.tasks)
        self._refused: tuple[object, str] = None, ""
        self._soon = context.session.later(self._show_hint, _SOON_MS)
        watch = context.session.changes.watch
        watch(PROJECT | Part.EDIT | Part.FRAME | Part.FAILURES, self._soon.start)
        watch(Part.LEAVING, self._job.cancel)

    # ---- what there is

    def entry(self) -> RunEntry | None:
        entry = self._session.finished_run
        return entry if entry is not None and entry.kind == "run" else None

    def failure(self) -> tuple[range, str] | None:
        """Frames of the failures around the frame that is shown, and their limbs in words."""
        frame, found = self._session.document.frame, self._session.failures.found
        every = () if found is None or self.entry() is None else found.failures
        here = [one for one in every if frame in one.frames]
        if not here:
            return None
        frames = range(min(one.first for one in here), max(one.last for one in here) + 1)
        return frames, limbs_words(tuple({limb for one in here for limb in one.limbs}))

    def stretch(self) -> range | None:
        """Frames that would be tracked again; None where no click here could change anything."""
        found, entry = self.failure(), self.entry()
        recording, frame = self._session.document.recording, self._session.document.frame
        if entry is None or recording is None:
            return None
        here = self._clicked.within(range(frame, frame + 1))
        frames = found[0] if found is not None else range(frame, frame + 1)
        if not self._clicked.within(frames) or (not here and found is None):
            return None
        margin = max(1, round((_MARGIN_S if found else _ALONE_S) * recording.fps))
        numbers = entry.numbers()
        first = max(frames.start - margin, int(numbers[0]))
        return range(first, min(frames.stop + margin, int(numbers[-1]) + 1))

    def _show_hint(self) -> None:
        found, hint = self.failure(), ""
        if found is not None:
            todo = "Click all landmarks of a frame near the middle, in two views or more."
            if self._clicked.within(found[0]):
                todo = "Re-track it around the clicks."
            hint = f"The run fails here: {frames_in_words(found[0])}, {found[1]}. {todo}"
        self._body.show_hint(hint)
        self._context.actions.refresh_soon()

    def why_not(self) -> str:
        why_not = self._session.no_recording() or self._session.project.why_no_edit()
        if why_not:
            return why_not
        if self._job.busy:
            return "A stretch is being tracked again. Wait for it."
        entry = self.entry()
        if entry is None:
            return "There is no finished run. Run the tracker first."
        if self.stretch() is None:
            found = self.failure()
            if found is not None:
                return f"No landmark is clicked in the failure ({frames_in_words(found[0])})."
            return "Click landmarks of this frame first, or go to a failure with Next failure."
        # asked with every refresh, and the answer takes all frames of the run to be put together
        key = entry, len(entry.frames)
        if self._refused[0] != key:
            self._refused = key, _why_not_with_clicks(entry)
        return self._refused[1]

    # ---- doing it

    def begin(self) -> None:
        entry, stretch, recording = self.entry(), self.stretch(), self._session.document.recording
        if self.why_not() or entry is None or stretch is None or recording is None:
            return
        run = entry.run()
        if run is None:
            return
        todo = self._task_of(entry, run, stretch, recording)
        process = self._session.processes.trials

        def work(task: Task) -> tuple[Retracked, Run]:
            found: Retracked = in_process(process, todo, task, len(stretch))
            return found, found.into(run, list(entry.ordered()))

        title, take = f"re-tracking {frames_in_words(stretch)}", partial(self._take, entry, stretch)
        self._job.run(Job(title, work, lambda found: take(*found)))

    def _task_of(self, entry: RunEntry, run: Run, stretch: range, recording: Recording) -> Retrack:
        project, stored = self._session.project.project, _stored(entry)
        assert project is not None  # noqa: S101 - nothing is clicked without
        clicks = project.clicks.used(stretch.start, stretch.stop)
        used = click_detections(
            [one for one in clicks if one.camera in recording.cameras],
            recording.cameras, project.click_sigmas(), str(project.path.resolve()),
        )  # fmt: skip
        spec = stored.spec if entry.origin is None else (entry.spec() or stored.spec)
        before, here = entry.at(stretch.start - 1), entry.at(stretch.start)
        start, shape = None, shape_of_meta(run.meta)
        if before is not None and before.pose is not None:
            start = Start(before.pose, before.P, shape)
        elif here is not None and here.pose is not None and stretch.start > min(entry.frames):
            start = Start(here.pose, shape=shape)
        return Retrack(
            replace(recording, reference=None, subject=stored.subject),
            replace(spec, frames=stretch, clicks=used, smooth=False),
            spec.frames or entry.wanted,
            start,
        )

    def _take(self, before: RunEntry, stretch: range, found: Retracked, run: Run) -> None:
        """Show the run with the stretch in its place, and hide the run as it was."""
        runs = self._session.runs
        if before not in runs.entries:
            return
        frames = {**before.frames, **{one.frame: one for one in found.frames}}
        name = runs.free_name(f"{before.name}, re-tracked {stretch.start}–{stretch.stop - 1}")
        entry = RunEntry(
            name, before.preset, before.settings, before.body, before.wanted, frames,
            stored=run, wall_seconds=before.wall_seconds,
        )  # fmt: skip
        runs.add(entry)
        runs.show(before, visible=False)
        self._context.notifier.say(
            f"Tracked again: {frames_in_words(stretch)}, {len(found.mended)} of them followed "
            f"backwards from clicks. The run as it was is hidden: {before.name}."
        )


def in_process(process: TaskProcess, todo: ProcessTask, task: Task, frames: int) -> Any:
    """Do something in a process that tells its frames, and report how many of them are done."""
    done = 0

    def hear(more: int) -> None:
        nonlocal done
        done += more
        task.report(done / frames, f"tracking frame {done} of {frames}")

    return process(todo, hear, task.token.cancelled)


def _stored(entry: RunEntry) -> StoredSpec:
    """How a run was made; raises InputError where that is not known."""
    run = entry.run()
    if run is None:
        raise InputError("how this run was made is not known", where=entry.name)
    return stored_spec(run)


def _why_not_with_clicks(entry: RunEntry) -> str:
    try:
        stored = _stored(entry)
    except InputError as error:
        return f"{error.what[:1].upper()}{error.what[1:]}."
    if stored.spec.settings.tracking.matching != "data_to_model":
        return f"The tracker of preset {entry.preset} does not use clicks."
    elsewhere = stored.keypoints is not None and stored.spec.keypoints is None
    if entry.origin is None and elsewhere:
        return "The run used keypoints of a file. Track the recording again first."
    return ""


def retrack_command(retracking: Retracking) -> Command:
    """Command of the menu Annotate."""
    return Menu("&Annotate", retracking.why_not).command(
        "annotate-retrack", "Re-track around the clicks", "Track the failure at this frame again, "
        "with the clicks in it as measurements. The rest of the run stays. You can undo this.",
        retracking.begin, "Shift+F10", "run-tracker", section=True,
    )  # fmt: skip


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
            project.clicks.used(), project.click_sigmas(), self._settings(), project.path.name,
            self._run(),
        )  # fmt: skip
        process, last = self._session.processes.trials, max(self._clicked.frames()) + 1

        def use(found: PersonalSubject) -> None:
            if project is self._session.project.project:
                self._session.project.apply(use_subject(found.subject, ORIGIN))
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
