"""The trajectory that is fitted to a project's clicks: made in the background, kept, shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.doubts import doubtful_camera, own_mistakes
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.reference import Reference, fit_of_reference, merged_reference
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.reference_quality import reference_quality
from stereotrack_core.project.clicks import (
    AcceptPredictions,
    DeleteClicks,
    MarkClicks,
    MoveClicks,
    PlaceClicks,
    SwapLandmarks,
)
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.project.setups import load_reference, save_reference
from stereotrack_core.recording.description import Recording

from ....services.tasks.helper_process import HelperProcess
from ....services.tasks.task import Task, TaskList
from ....session.camera_doubts import view_names
from ....session.truth import arms_good_to
from .fitting import (
    FITTED,
    FitOrder,
    FittedRecording,
    around,
    fit_process,
    fit_recording,
    fit_words,
    residuals_of,
)

_MANY_FRAMES = 50
_CLICK_EDITS = frozenset(
    edit.kind
    for edit in (
        PlaceClicks,
        MoveClicks,
        DeleteClicks,
        MarkClicks,
        SwapLandmarks,
        AcceptPredictions,
    )
)
_LOOKED_BACK = 500


@dataclass(frozen=True, eq=False)
class ShownReference:
    """The project's reference, and what follows from it.

    Attributes
    ----------
    name : str
    reference : Reference
    fit : TrajectoryFit or None
        None where it was not fitted to the project's landmarks.
    residuals : (frames, 6) float64 or None
        Of each limb's clicks in pixels, over the frames of the recording.
    words : str
        How good it is.
    mistakes : tuple of ClickKey
        Clicks that look like gross mistakes.
    edits_since : int
        Edits of clicks that it does not know.
    """

    name: str
    reference: Reference
    fit: TrajectoryFit | None
    residuals: FloatArray | None
    words: str
    mistakes: tuple[ClickKey, ...] = ()
    edits_since: int = 0


class ReferenceWork(QObject):
    """Fits, saves the result as an edit, and shows the reference that the project uses.

    Attributes
    ----------
    settings : FitSettings
        Of the next fit.

    Signals
    -------
    shown : ShownReference or None
    residuals_changed : list of int, (K, 6) float64
        Residuals of the limbs' clicks at K frames are others after an edit.
    busy_changed : ()
    failed : Exception
    """

    shown = Signal(object)
    residuals_changed = Signal(list, object)
    busy_changed = Signal()
    failed = Signal(object)

    def __init__(self, tasks: TaskList, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._tasks = tasks
        self._project: Project | None = None
        self._recording: Recording | None = None
        self._frames = 0
        self._fitting: Task | None = None
        self._reading: Task | None = None
        self._wanted: range | None = None
        self._now: ShownReference | None = None
        self._clicks_since = 0
        self.settings = FitSettings()
        self._process: HelperProcess | None = None

    @property
    def fitting(self) -> bool:
        """Whether a fit is under way."""
        return self._fitting is not None

    @property
    def now(self) -> ShownReference | None:
        """The reference that is shown."""
        return self._now

    def words(self) -> str:
        """How good the reference is, and how many edits of clicks it does not know yet."""
        if self._now is None:
            return "No trajectory has been fitted to the clicks yet. Choose Fit whole recording."
        if not self._clicks_since:
            return self._now.words
        edits = f"{self._clicks_since} edit{'' if self._clicks_since == 1 else 's'} of clicks"
        return f"{self._now.words} Does not include the last {edits}; fit again."

    def set_project(
        self, project: Project | None, recording: Recording | None, frames: int
    ) -> None:
        """Work on another project, or on none."""
        self.cancel()
        self._end_process()
        self._project, self._recording, self._frames = project, recording, frames
        self._show_stored()

    def set_frame_count(self, frames: int) -> None:
        """The number of frames is known better."""
        if frames != self._frames:
            self._frames = frames
            self._show_stored()

    def why_not(self) -> str:
        """Why nothing can be fitted now, as a sentence; empty where it can."""
        if self._project is None or self._recording is None:
            return "No project is open. Open or create one first."
        if self._project.read_only:
            return "The project is open read-only."
        if self._fitting is not None:
            return "A fit is already running. Wait for it, or stop it."
        return ""

    def fit(self, frames: range | None = None) -> None:
        """Fit the whole recording, or only these frames with what they hang on."""
        if self.why_not() or self._project is None or self._recording is None:
            return
        self._wanted = frames
        every = range(self._frames)
        if frames is not None:
            clicked = tuple(int(k) for k in self._project.clicks.frames())
            every = around(frames, clicked, self._frames - 1)
        order = FitOrder(self._project, self._recording, every, self.settings)
        process = self._process = self._process or fit_process()

        def work(own: Task) -> FittedRecording:
            return fit_recording(order, process, own.report, own.token.cancelled)

        task = self._fitting = self._tasks.begin("fitting the body to the clicks", work, self._keep)
        task.stopped.connect(self._end_process)
        task.ended.connect(self._on_ended)
        self.busy_changed.emit()

    @Slot()
    def cancel(self) -> None:
        """Stop a fit; nothing changes then."""
        if self._fitting is not None:
            self._fitting.cancel()

    @Slot()
    def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.close()

    def follow(self, changed: Changed) -> None:
        """Take note of an edit."""
        if changed.tables & {"reference", "choice", "landmark_set"}:
            self._show_stored()
        elif "click" in changed.tables:
            self._clicks_since += 1
            self._measure_again(sorted(changed.frames()))

    def _measure_again(self, frames: list[int]) -> None:
        """Tell how far the clicks of some frames lie from the fit now."""
        project, recording, now = self._project, self._recording, self._now
        if project is None or recording is None or now is None or now.fit is None:
            return
        known = [frame for frame in frames if frame < self._frames]
        if known and len(known) <= _MANY_FRAMES:
            order = FitOrder(project, recording, range(self._frames))
            clicks = tuple(click for frame in known for click in project.clicks.at(frame))
            rows = residuals_of(now.fit, clicks, order)
            values = np.full((len(known), len(LIMBS)), np.nan)
            _, own, theirs = np.intersect1d(known, now.fit.frame, return_indices=True)
            values[own] = rows[theirs]
            self.residuals_changed.emit(known, values)

    @Slot()
    def _on_ended(self) -> None:
        self._fitting = None
        self.busy_changed.emit()

    @Slot(object)
    def _keep(self, found: FittedRecording) -> None:
        """Save a fit, and let the project use it."""
        project = self._project
        if project is None or found.order.project is not project:
            return
        reference = found.reference
        try:
            if self._wanted is not None:
                old = load_reference(project.references, FITTED) if self._has_fitted() else None
                reference = merged_reference(old, reference, self._wanted)
            edit = save_reference(FITTED, reference, replacing=True)
            project.apply(edit)
            if project.chosen(project.references) != FITTED:
                project.apply(Choose(REFERENCE.name, FITTED))
        except InputError as error:
            self.failed.emit(error)

    def _has_fitted(self) -> bool:
        return self._project is not None and FITTED in self._project.references.names()

    def _show_stored(self) -> None:
        """Read the reference that the project uses; beside the window's thread."""
        project, recording, frames = self._project, self._recording, self._frames
        name = None if project is None else project.chosen(project.references)
        self._reading = None
        if project is None or recording is None or name is None:
            self._take(None)
            return
        chosen = name
        self._reading = self._tasks.begin(
            "reading the reference",
            lambda _task: read_reference(project, recording, chosen, frames),
            self._on_read,
        )

    @Slot(object)
    def _on_read(self, found: ShownReference) -> None:
        if self.sender() is self._reading:  # else another one was asked for since
            self._reading = None
            self._take(found)

    def _take(self, found: ShownReference | None) -> None:
        self._now = found
        self._clicks_since = found.edits_since if found is not None else 0
        self.shown.emit(found)


def read_reference(
    project: Project, recording: Recording, name: str, frames: int
) -> ShownReference:
    """The reference of that name, with what follows from it and the present clicks."""
    reference = load_reference(project.references, name)
    clicks = project.clicks.all()
    fit = fit_of_reference(reference, project.landmark_set(), clicks, recording.cameras)
    if fit is None:
        good = arms_good_to(reference_quality(reference, reference.frame))
        says = f"arm uncertainty {good:.1f}°" if good == good else "uncertainty unknown"
        words = f"“{name}”: {len(reference.frame)} frames, {says}."
        return ShownReference(name, reference, None, None, words)
    residuals = np.full((frames, len(LIMBS)), np.nan)
    inside = fit.frame < frames
    order = FitOrder(project, recording, range(frames))
    residuals[fit.frame[inside]] = residuals_of(fit, clicks, order)[inside]
    doubtful = doubtful_camera(clicks, recording.cameras, project.landmark_set())
    mistakes = own_mistakes(fit.flagged(), doubtful, clicks, recording.cameras)
    words = f"“{name}”: {fit_words(fit, len(mistakes), doubtful, view_names(recording))}"
    since = _edits_since(project, name)
    return ShownReference(name, reference, fit, residuals, words, mistakes, since)


def _edits_since(project: Project, name: str) -> int:
    """Edits of clicks since a reference was saved; only the last edits are looked at."""
    saved = f"save reference {name}"
    count = 0
    for entry in project.history.entries(_LOOKED_BACK):
        if entry.words == saved and entry.state == "done":
            return count
        count += entry.state == "done" and entry.kind in _CLICK_EDITS
    return count
