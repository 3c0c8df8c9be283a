"""The trajectory that is fitted to a project's clicks: made in the background, kept, shown."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.reference import Reference, fit_of_reference
from stereotrack_core.counting import in_words
from stereotrack_core.errors import InputError
from stereotrack_core.project.fitting import (
    ShownReference,
    fit_elsewhere,
    fit_project,
    frames_around,
    keep_fitted,
    read_reference,
)
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.worker_processes import TaskProcess

from ....session.jobs import Job, NewestJob, Task, TaskList

_TAKING_IN_SECONDS = 1.5
_SHORT_SECONDS = 10.0  # a fit under way for less is begun again without regret
_DEPTH_SECONDS, _CLICK_SECONDS = 1.2, 0.05  # a frame, where nothing has been measured yet


class ReferenceWork:
    """Fits, saves the result as an edit, and reads the reference that the project uses.

    `shown` is called when that is another one; `aged` when other frames of it are old: their
    clicks have changed since the fit.
    """

    def __init__(
        self, tasks: TaskList, shown: Callable[[], None], aged: Callable[[], None]
    ) -> None:
        self._tasks, self._shown, self._aged = tasks, shown, aged
        self._project: Project | None = None
        self._recording: Recording | None = None
        self._frames = 0
        self._fitting, self._reading = NewestJob(tasks), NewestJob(tasks)
        self._quick, self._quick_process = NewestJob(tasks), TaskProcess()
        self.now: ShownReference | None = None
        self.settings = FitSettings()
        self._process = TaskProcess()

    @property
    def fitting(self) -> bool:
        return self._fitting.busy

    def lost_words(self) -> str:
        """A fit that takes long and is not finished; empty without one."""
        task = self._fitting.task if self.fitting else None
        if task is None or task.seconds < _SHORT_SECONDS:
            return ""
        return f"the fit of the body to the clicks, under way for {in_words(task.seconds)}"

    def set_project(
        self, project: Project | None, recording: Recording | None, frames: int
    ) -> None:
        for job, process in ((self._fitting, self._process), (self._quick, self._quick_process)):
            job.cancel()
            process.end()
        self._project, self._recording, self._frames = project, recording, frames
        self._show_stored()

    def set_frame_count(self, frames: int) -> None:
        self._frames = frames

    def why_not(self) -> str:
        if self._project is None or self._recording is None:
            return "No project is open. Open or create one first."
        if self._project.read_only:
            return "The project is open read-only."
        if self._recording.guessed:
            return "The calibration is a guess. Replace it with a calibration of these cameras."
        return "A fit is already running. Wait for it, or stop it." if self.fitting else ""

    def how_long(self) -> str:
        """``about 6 min``: time that a fit of the whole recording takes, by the last one made."""
        views = () if self._recording is None else self._recording.views
        depth = self.settings.use_depth and any(view.kind != "mono" for view in views)
        each = _DEPTH_SECONDS if depth else _CLICK_SECONDS
        made = self.now.reference if self.now is not None else None
        if made is not None and made.meta.get("settings", {}).get("use_depth") == depth:
            each = float(made.meta.get("seconds", 0.0)) / max(len(made.frame), 1) or each
        words = in_words(each * self._frames)
        return words if words.startswith("under") else f"about {words}"

    def fit(self, frames: range | None = None) -> None:
        """Fit the whole recording, or only these frames with what they hang on."""
        project, recording, settings = self._project, self._recording, self.settings
        if self.why_not() or project is None or recording is None:
            return
        every = range(self._frames)
        if frames is not None:
            clicked = tuple(int(k) for k in project.clicks.frames())
            every = frames_around(frames, clicked, self._frames - 1)

        def work(task: Task) -> Reference:
            def do(fit: Callable[..., TrajectoryFit]) -> TrajectoryFit:
                return _fitted(fit, len(every), self._process, task)

            return fit_project(project, recording, every, settings, do)

        def keep(reference: Reference) -> None:
            if project is self._project:
                try:
                    keep_fitted(project, reference, frames)
                except InputError as error:
                    self._tasks.failed(error)

        self._fitting.run(Job("fitting the body to the clicks", work, keep))

    def fit_clicked(self, done: Callable[[TrajectoryFit | None], None]) -> None:
        """Fit the clicked frames alone, each from its clicks; a fraction of the time."""
        project, recording = self._project, self._recording
        if self.why_not() or project is None or recording is None:
            return
        every, settings = range(self._frames), replace(self.settings, use_depth=False)

        def work(task: Task) -> TrajectoryFit | None:
            def do(fit: Callable[..., TrajectoryFit]) -> TrajectoryFit:
                cancelled, ask = task.token.cancelled, partial(fit_elsewhere, fit)
                found: TrajectoryFit = self._quick_process(
                    ask, lambda _frame: None, cancelled, listens=False
                )
                return found

            made = fit_project(project, recording, every, settings, do, between=False)
            clicks, landmarks = project.clicks.used(), project.landmark_set()
            return fit_of_reference(made, landmarks, clicks, recording.cameras)

        def keep(fit: TrajectoryFit | None) -> None:
            if project is self._project and self.now is None:
                done(fit)

        self._quick.run(Job("fitting the clicked frames", work, keep))

    def follow(self, changed: Changed) -> None:
        if changed.tables & {"reference", "choice", "landmark_set", "camera_use"}:
            self._show_stored()
        elif "click" in changed.tables:
            self._look_what_is_old(sorted(changed.frames()))

    def _look_what_is_old(self, frames: list[int]) -> None:
        if self._project is None or self.now is None or self.now.clicks is None:
            return
        used = self._project.clicks.used
        clicks = [click for frame in frames for click in used(frame, frame + 1)]
        self.now = replace(self.now, clicks=self.now.clicks.after_edit(frames, clicks))
        self._aged()

    def _show_stored(self) -> None:
        """Read the reference that the project uses; beside the window's thread."""
        project, recording = self._project, self._recording
        name = None if project is None else project.chosen(project.references)
        self._reading.give_up()
        if project is None or recording is None or name is None:
            self._take(None)
            return
        read = partial(read_reference, project, recording, name)

        self._reading.run(Job("reading the reference", lambda _: read(), self._take))

    def _take(self, found: ShownReference | None) -> None:
        self.now = found
        self._shown()


def how_far(done: int, of: int, seconds: float) -> tuple[float, str]:
    """Share of a fit that is done, 0 if unknown, and words.

    `done` of all frames are added, the last one `seconds` ago; after a while they are being fitted.
    """
    if done == 0:
        return 0.0, "preparing"
    if done < of and seconds < _TAKING_IN_SECONDS:
        return 0.9 * done / of, f"step 1 of 2, frame {done} of {of} added"
    return 0.0, f"step 2 of 2, forward and backward pass over the frames, {seconds:.0f} s"


def _fitted(
    fit: Callable[..., TrajectoryFit], count: int, process: TaskProcess, task: Task
) -> TrajectoryFit:
    """Let the process fit so many frames, and say how far it is; it computes for minutes."""
    done, since = 0, time.monotonic()

    def hear(more: int) -> None:
        nonlocal done, since
        done, since = done + more, time.monotonic()

    def cancelled() -> bool:
        task.report(*how_far(done, count, time.monotonic() - since))
        return task.token.cancelled()

    found: TrajectoryFit = process(partial(fit_elsewhere, fit), hear, cancelled, listens=False)
    return found
