"""Predictions that a person asks for: by following the image, from the fit, a run, neighbours."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal, TypeAlias

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.annotation.prefill import FIT, FOLLOWING, NEIGHBOURS, source_of_run
from stereotrack_core.errors import InputError
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording

from ....services.actions import Command
from ....services.tasks.task import Task
from ....session.runs import RunEntry
from ..panels import AnnotationPanels
from ..selection import Selection
from .following import FollowedSelection, follow_selection
from .prefilling import (
    FilledSelection,
    Filling,
    accept_filled,
    fill_in,
    fit_filling,
    neighbour_filling,
    run_filling,
)

Source: TypeAlias = Literal["following", "fit", "run", "neighbours"]

_REMEDIES: dict[Source, tuple[str, str]] = {
    "following": ("no followed points in", "No followed points. Run Follow image patch first."),
    "fit": ("no points from the fit in", "No points from the fit. Fill from the fit first."),
    "run": ("no points from the run in", "No points from the run. Fill from the active run first."),
    "neighbours": (
        "no points from neighbouring clicks in",
        "No points from neighbouring clicks. Fill from neighbouring clicks first.",
    ),
}


class PredictionWork(QObject):
    """Fills in the selection beside the window's thread, one source after the other.

    Parameters
    ----------
    panels : AnnotationPanels

    Signals
    -------
    found : str
        Other predictions are kept than before; what was done, in words.
    busy_changed : ()
    """

    found = Signal(str)
    busy_changed = Signal()

    def __init__(self, panels: AnnotationPanels) -> None:
        super().__init__(panels)
        self._p = panels
        panels.leaving.connect(self.cancel)
        self.busy_changed.connect(panels.changed)
        self.found.connect(panels.said)
        self.found.connect(panels.repeat_changed)
        self._task: Task | None = None
        self._run: RunEntry | None = None

    @property
    def busy(self) -> bool:
        """Whether predictions are being made."""
        return self._task is not None

    @property
    def run(self) -> RunEntry | None:
        """The tracker's run to fill in from."""
        return self._run

    def set_run(self, run: RunEntry | None) -> None:
        """Fill in from another run, which does not grow; None where there is none."""
        self._run = run
        self.busy_changed.emit()

    def cancel(self) -> None:
        """Stop; nothing is kept then."""
        if self._task is not None:
            self._task.cancel()

    # ---- making them

    def why_not(self, source: Source) -> str:
        """Why nothing can be filled in from there, as a sentence; empty where it can."""
        if self.busy:
            return "Predictions are already being computed. Wait for them to finish."
        return self._why_no_project() or self._why_no_source(source)

    def follow(self) -> None:
        """Follow the patches around clicks over the selection."""
        project, recording, selection = self._p.project, self._p.recording, self._p.selection()
        if project is None or recording is None or self.busy:
            return
        self._begin(
            "following clicks",
            lambda task: follow_selection(
                project, recording, selection, task.report, task.token.cancelled
            ),
        )

    def fill(self, source: Source) -> None:
        """Fill in the selection from the fit, from the run, or from neighbouring clicks."""
        project, recording, selection = self._p.project, self._p.recording, self._p.selection()
        if project is None or recording is None or self.why_not(source):
            return
        make = self._filling(source, project, recording)
        self._begin(
            "filling predictions",
            lambda task: fill_in(project, make(), selection, task.report, task.token.cancelled),
        )

    def _filling(
        self, source: Source, project: Project, recording: Recording
    ) -> Callable[[], Filling]:
        """What is filled in from, as it is now; put together in the other thread."""
        cameras = {
            view.image.camera: recording.cameras[view.image.camera] for view in recording.views
        }
        now, entry = self._p.reference.now, self._run
        name, held = ("", None) if entry is None else (entry.name, entry.now())

        def make() -> Filling:
            if source == "fit" and now is not None and now.fit is not None:
                return fit_filling(now.fit, cameras)
            run = held.run() if source == "run" and held is not None else None
            if run is not None:
                return run_filling(run, name, cameras, project.landmark_set())
            if source == "neighbours":
                return neighbour_filling(project)
            raise InputError(
                "no source for predictions",
                remedy="Choose a run that was tracked here or read from a file.",
            )

        return make

    def _begin(
        self, title: str, work: Callable[[Task], FollowedSelection | FilledSelection]
    ) -> None:
        self._task = self._p.tasks.begin(title, work, self._on_found)
        self._task.ended.connect(self._on_ended)
        self.busy_changed.emit()

    @Slot(object)
    def _on_found(self, made: FollowedSelection | FilledSelection) -> None:
        self.found.emit(made.words)

    @Slot()
    def _on_ended(self) -> None:
        self._task = None
        self.busy_changed.emit()

    # ---- taking them

    def why_no_accept(self, source: Source) -> str:
        """Why nothing can be taken from there, as a sentence; empty where it can."""
        return self._why_no_project() or (self._why_no_source(source) if source == "run" else "")

    def accept(self, source: Source) -> None:
        """Let what a source has found in the selection be clicks: one edit."""
        project, chosen = self._p.project, self._p.selection()
        if project is not None:
            name = self._name(source)
            self._p.do(
                lambda: accept_from(project, chosen, source, name), frames=len(chosen.frames)
            )

    def _name(self, source: Source) -> str:
        """The word under which a source's predictions are kept."""
        if source == "run":
            return source_of_run(self._run.name) if self._run is not None else ""
        return {"following": FOLLOWING, "fit": FIT, "neighbours": NEIGHBOURS}[source]

    # ---- reasons

    def _why_no_project(self) -> str:
        project = self._p.project
        if project is None:
            return "No project is open. Open or create one first."
        return "The project is open read-only." if project.read_only else ""

    def _why_no_source(self, source: Source) -> str:
        now = self._p.reference.now
        if source == "fit" and (now is None or now.fit is None):
            return "The whole recording has not been fitted yet. Choose Fit whole recording first."
        if source == "run" and self._run is None:
            return "There is no finished run. Run the tracker first."
        return ""


def accept_from(project: Project, chosen: Selection, source: Source, name: str) -> Edit:
    """The edit that takes what is kept under `name`.

    Raises
    ------
    InputError
        Where there is nothing of it in the selection.
    """
    happened, remedy = _REMEDIES[source]
    return accept_filled(project, chosen, name, happened=happened, remedy=remedy)


_FILL: tuple[tuple[Source, str, str], ...] = (
    ("fit", "Fill from the fit", "Predict landmarks in the selected frames from the body "
    "fitted to the clicks. Predictions do not become clicks until you accept them."),
    ("run", "Fill from the active run", "Predict landmarks in the selected frames from the "
    "tracker's active run. Predictions do not become clicks until you accept them."),
    ("neighbours", "Fill from neighbouring clicks",
    "Predict landmarks in the selected frames by linear "
    "interpolation between two clicks in the same view. Predictions do not become clicks until "
    "you accept them."),
)  # fmt: skip

_ACCEPT: tuple[tuple[Source, str, str, str], ...] = (
    ("following", "annotate-accept", "Accept followed points", "following the image patch found"),
    ("fit", "annotate-accept-fit", "Accept points from the fit", "was filled from the fit"),
    ("run", "annotate-accept-run", "Accept points from the active run",
     "was filled from the tracker's active run"),
    ("neighbours", "annotate-accept-neighbours", "Accept points from neighbouring clicks",
     "was filled from neighbouring clicks"),
)  # fmt: skip


def prediction_commands(work: PredictionWork, menu: str) -> list[Command]:
    """All of them, in the order of their menu."""

    def named(words: str) -> str:
        """``Fill in from run “2: accurate”``, where there is one."""
        name = "" if work.run is None else f"run “{work.run.name}”"
        return words.replace("the active run", name) if name else words

    fill = [
        Command(
            f"annotate-fill-{source}", menu, text, tip, partial(work.fill, source),
            icon="prediction", why_not=partial(work.why_not, source), says=partial(named, text),
        )
        for source, text, tip in _FILL
    ]  # fmt: skip
    accept = [
        Command(
            name, menu, text, f"Turn what {what} in the selection into clicks, as one edit. "
            "Existing clicks do not change.", partial(work.accept, source), icon="accept",
            why_not=partial(work.why_no_accept, source), says=partial(named, text),
            section=source == "following",
        )
        for source, name, text, what in _ACCEPT
    ]  # fmt: skip
    follow = Command(
        "annotate-follow", menu, "Follow image patch", "Follow the image patch around each click "
        "through the selected frames. The points found are predictions until you accept them.",
        work.follow,
        icon="prediction", why_not=partial(work.why_not, "following"),
    )  # fmt: skip
    return [follow, *fill, *accept]
