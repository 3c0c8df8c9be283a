"""Predictions for a selection: from the fit, from a run, from neighbours; kept, not clicked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.prefill import (
    FIT,
    NEIGHBOURS,
    from_fit,
    from_neighbours,
    from_run,
    source_of_run,
)
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project
from stereotrack_core.tracking.frame import Run

from ....session.counting import counted
from ..selection import Selection, gaps_of, landmark_gaps_of

OnProgress = Callable[[float, str], None]

_AT_ONCE = 100
"""Frames between two looks at whether it shall stop."""

LONGEST = 30
"""Frames between two clicks over which the straight line is worth while."""


@dataclass(frozen=True, eq=False)
class Filling:
    """Where predictions come from.

    Attributes
    ----------
    source : str
        The word under which they are kept.
    words : str
        What a person calls it: ``the fit``.
    make : callable
        Gives those of some frames; others that it gives are left out.
    """

    source: str
    words: str
    make: Callable[[range], Iterable[Prediction]]


@dataclass(frozen=True)
class FilledSelection:
    """What became of it.

    Attributes
    ----------
    predictions : int
        Places that can be accepted now.
    words : str
    """

    predictions: int
    words: str


def fit_filling(fit: TrajectoryFit, cameras: Mapping[str, Camera]) -> Filling:
    """From the body fitted to the clicks of the recording."""

    def make(frames: range) -> Iterable[Prediction]:
        inside = (fit.frame >= frames.start) & (fit.frame < frames.stop)
        part = replace(
            fit,
            frame=fit.frame[inside],
            landmarks=fit.landmarks[inside],
            covariance=fit.covariance[inside],
            limb_sigma_deg=fit.limb_sigma_deg[inside],
            kind=fit.kind[inside],
            nine=fit.nine[inside],
        )
        return from_fit(part, cameras)

    return Filling(FIT, "the fit", make)


def run_filling(
    run: Run, name: str, cameras: Mapping[str, Camera], landmark_set: LandmarkSet
) -> Filling:
    """From a tracker's run, of which the frames that are not tracked are left out."""

    def make(frames: range) -> Iterable[Prediction]:
        inside = (run.frame >= frames.start) & (run.frame < frames.stop) & run.tracked
        part = replace(
            run,
            frame=run.frame[inside],
            landmarks=run.landmarks[inside],
            limb_sigma_deg=run.limb_sigma_deg[inside],
        )
        return from_run(part, name, cameras, landmark_set)

    return Filling(source_of_run(name), f"run “{name}”", make)


def neighbour_filling(project: Project) -> Filling:
    """Straight between a click and the next one of the same landmark in the same image."""
    gaps, sigma = gaps_of(project), project.click_sigmas()

    def make(frames: range) -> Iterable[Prediction]:
        first = max(frames.start - LONGEST - 1, 0)
        clicks = project.clicks.between(first, frames.stop + LONGEST + 1)
        return from_neighbours(clicks, gaps=gaps, longest=LONGEST, sigma=sigma)

    return Filling(NEIGHBOURS, "neighbouring clicks", make)


def fill_in(
    project: Project,
    filling: Filling,
    selection: Selection,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> FilledSelection:
    """Keep predictions for what is selected and nobody has clicked; called off the window's thread.

    Over gaps nothing is filled in.

    Raises
    ------
    InputError
        Where the project cannot be written to.
    Cancelled
        When stopped; nothing is kept then.
    """
    frames = selection.frames
    found: list[Prediction] = []
    barred = {frame for gap in gaps_of(project) for frame in gap}
    of_landmarks = landmark_gaps_of(project)
    for first in range(frames.start, frames.stop, _AT_ONCE):
        if cancelled():
            raise Cancelled
        on_progress((first - frames.start) / len(frames), f"frame {first}")
        part = range(first, min(first + _AT_ONCE, frames.stop))
        found += [
            one
            for one in filling.make(part)
            if one.frame in part
            and selection.has(one.landmark)
            and one.frame not in barred
            and one.frame not in of_landmarks.get(one.landmark, ())
        ]
    kept = keep_found(project, filling.source, found, selection)
    words = f"{counted(kept, 'point')} filled from {filling.words}."
    if not kept:
        words = f"Nothing to fill from {filling.words} in {selection.words()}."
    return FilledSelection(kept, words)


def keep_found(
    project: Project, source: str, found: Iterable[Prediction], selection: Selection
) -> int:
    """Keep what was found in a selection; what its source says of other landmarks stays.

    Returns
    -------
    int
        Number of those places that can be accepted.
    """
    here = [one for one in found if one.frame in selection.frames]
    others = [
        one
        for one in project.predictions.of_source(source)
        if one.frame in selection.frames and not selection.has(one.landmark)
    ]
    project.predictions.replace(source, [*here, *others], frames=selection.frames)
    said = project.clicks.keys()
    return sum(one.key not in said for one in here)


def accept_filled(
    project: Project, chosen: Selection, source: str, *, happened: str, remedy: str
) -> Edit:
    """The edit that makes clicks of what a source has found in the selection.

    Raises
    ------
    InputError
        Where it has found nothing there.
    """
    edit = project.predictions.acceptance(source, chosen.frames, chosen.landmarks)
    if edit is None:
        raise InputError(f"{happened} {chosen.words()}", remedy=remedy)
    return edit
