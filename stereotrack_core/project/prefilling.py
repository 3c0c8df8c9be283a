"""Predictions for what nobody has clicked: proposals from clicks, a fit, a run.

None of them is a click before a person says so, so there is nothing to undo before; none is made
where a person has said anything already.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from types import MappingProxyType

import numpy as np

from stereotrack_core.annotation.click import Click, Prediction
from stereotrack_core.annotation.detected_body import body_predictions
from stereotrack_core.annotation.fit.results import GAP, TrajectoryFit
from stereotrack_core.annotation.follow import follow_clicks
from stereotrack_core.annotation.landmark_filter import ProposalQuestion
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.predict import projected_landmarks
from stereotrack_core.annotation.propose import (
    ACCEPTED_SIGMA,
    PROPOSED,
    Acceptance,
    Proposer,
    acceptable,
)
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import accept_points
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection, gaps_of, outside_gaps
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.keypoints import Keypoints, of_one_person
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import Run
from stereotrack_core.work import NO_WORK, Work

FIT = "fit"
_LIMB_LENGTH = 0.3  # metres by which the end of a limb moves when it turns by one radian


def from_fit(fit: TrajectoryFit, cameras: Cameras, frames: range) -> Iterator[Prediction]:
    """Landmarks of a fit in every image; between clicked frames they are filled in joint space."""
    known = (fit.kind != GAP) & np.isin(fit.frame, frames)
    numbers, points = fit.frame[known].tolist(), fit.landmarks[known]
    yield from projected_landmarks(numbers, fit.names, points, fit.covariance[known], cameras, FIT)


def from_run(
    run: Run, name: str, cameras: Cameras, landmark_set: LandmarkSet, frames: range
) -> Iterator[Prediction]:
    """The landmarks of a set that a tracker found in every image; the source is ``run NAME``."""
    known = run.tracked & np.isin(run.frame, frames)
    names = [name for name in landmark_set.names if name in run.landmark_names]
    places = [run.landmark_names.index(one) for one in names]
    limbs = [LIMBS.index(landmark_set[one].limb) for one in names]
    spread = _LIMB_LENGTH * np.radians(run.limb_sigma_deg[known][:, limbs])
    covariance = np.square(spread)[..., None, None] * np.eye(3)
    numbers, points = run.frame[known].tolist(), run.landmarks[known][:, places]
    yield from projected_landmarks(numbers, names, points, covariance, cameras, source_of_run(name))


def source_of_run(name: str) -> str:
    """The source of predictions from a run of the project."""
    return f"run {name}"


_AT_ONCE, _FITTED_AT_ONCE = 100, 4  # frames between two looks at whether it shall stop
_SIDE = 10  # clicked frames on each side that a proposal is made of
_FARTHEST = 60  # frames outside the selection within which a click is followed into it


@dataclass(frozen=True, eq=False)
class Filling:
    """Where predictions come from."""

    sources: tuple[str, ...]  # the words under which they are kept
    words: str  # what a person calls it: ``the fit``
    make: Callable[[range], Iterable[Prediction]]  # those of some frames
    at_once: int = _AT_ONCE


def fit_filling(fit: TrajectoryFit, cameras: Cameras) -> Filling:
    """From the body fitted to the clicks of the recording."""
    return Filling((FIT,), "the fit", partial(from_fit, fit, cameras))


def run_filling(run: Run, name: str, cameras: Cameras, project: Project) -> Filling:
    """From a tracker's run, of which the frames that are not tracked are left out."""
    make = partial(from_run, run, name, cameras, project.landmark_set())
    return Filling((source_of_run(name),), f"run “{name}”", make)


def detector_filling(project: Project, cameras: Cameras, proportions: Proportions) -> Filling:
    """From the keypoints of the project's detectors: the landmarks of the body that they show."""

    @cache
    def person() -> Keypoints:
        return of_one_person(project.keypoints.all())  # the same one in all parts of the selection

    def make(frames: range) -> Iterable[Prediction]:
        own = person()
        first, end = np.searchsorted(own.frame, [frames.start, frames.stop])
        rows = own[slice(int(first), int(end))]
        return body_predictions(rows, names, cameras, proportions)

    names, sources = project.landmark_set().names, tuple(project.keypoints.sources())
    return Filling(sources, "the keypoints", make, _FITTED_AT_ONCE)


def fill_in(project: Project, filling: Filling, selection: Selection, work: Work = NO_WORK) -> str:
    """Keep predictions for what is selected and not clicked, outside gaps; in words.

    Raises InputError; Cancelled, with nothing kept.
    """
    frames = selection.frames
    found: list[Prediction] = []
    for first in range(frames.start, frames.stop, filling.at_once):
        work.step((first - frames.start) / len(frames), f"frame {first}")
        part = range(first, min(first + filling.at_once, frames.stop))
        found += (one for one in filling.make(part) if one.frame in part)
    found = outside_gaps(project, found)
    kept = 0
    for source in filling.sources:
        own = [one for one in found if one.source == source]
        kept += _keep_predictions(project, source, own, selection)
    if not kept:
        return f"Nothing to predict from {filling.words} in {selection.words()}."
    return f"{counted(kept, 'point')} predicted from {filling.words}."


def _keep_predictions(
    project: Project, source: str, found: Iterable[Prediction], selection: Selection
) -> int:
    """Let these be the predictions of a source in a selection; how many were kept."""
    frames, kept = selection.frames, project.predictions.of_source(source)
    here = [one for one in found if one.frame in frames and selection.has(one.landmark)]
    others = [one for one in kept if one.frame in frames and not selection.has(one.landmark)]
    return project.predictions.replace(source, [*here, *others], frames=frames) - len(others)


_ACCEPTED_SIGMA = "accepted_sigma_px"


def accepted_sigma(project: Project) -> float:
    """Largest standard deviation of predictions that are accepted, pixels at 480 lines."""
    return float(project.view_settings.get(_ACCEPTED_SIGMA, ACCEPTED_SIGMA))


def set_accepted_sigma(project: Project, limit: float) -> None:
    """Set the largest standard deviation of predictions that are accepted, pixels at 480 lines."""
    project.view_settings.set(_ACCEPTED_SIGMA, limit)


def accept(project: Project, predictions: Sequence[Prediction], cameras: Cameras) -> Acceptance:
    """Choose the predictions within the project's limit of sigma; see :func:`acceptable`."""
    frames = {one.frame for one in predictions}
    around = project.clicks.all()
    if len(frames) == 1:
        around = clicks_around(project, frames.pop(), gaps_of(project))[1]
    return acceptable(predictions, around, cameras, accepted_sigma(project))


def accept_predictions(
    project: Project,
    sources: Sequence[str],
    selection: Selection,
    called: str,
    cameras: Cameras = MappingProxyType({}),
) -> Edit:
    """The edit that makes clicks of what sources, `called` so, have found in the selection.

    The surest of several counts; uncertain ones stay open. Raises InputError without any.
    """
    found: list[Prediction] = []
    for source in sources:
        every = project.predictions.of_source(source)
        here = (p for p in every if p.frame in selection.frames and selection.has(p.landmark))
        found += project.predictions.unclicked(here)
    if not found:
        what = f"there are no {called} in {selection.words()}"
        raise InputError(what, remedy="Predict points for this selection first, then accept them.")
    found.sort(key=lambda one: np.inf if one.sigma is None else one.sigma, reverse=True)
    accepted = accept(project, tuple({one.key: one for one in found}.values()), cameras)
    if not accepted.predictions:
        what = f"none of the {called} in {selection.words()} is certain enough"
        raise InputError(what, remedy=accepted.words())
    return accept_points(accepted.predictions, left_open=accepted.words().removesuffix("."))


def propose_selection(
    project: Project, recording: Recording, selection: Selection, work: Work = NO_WORK
) -> str:
    """Propose what is not clicked in the selection, from clicks in and around it; in words.

    Raises InputError without a click to begin with; Cancelled, with nothing kept.
    """
    frames = selection.frames
    near = project.clicks.used(max(frames.start - _FARTHEST, 0), frames.stop + _FARTHEST)
    if not near:
        what = f"there is no click near {selection.words()} to predict anything from"
        raise InputError(what, remedy="Click landmarks in the first frame of the selection first.")
    gaps = gaps_of(project)
    wanted = [frame for frame in frames if not any(frame in gap for gap in gaps)]
    followed: list[Prediction] = []
    for count, view in enumerate(recording.views):
        work.tell(0.5 * count / len(recording.views), f"view {view.name}")
        with FrameReader(recording, views=[view.name], colour=False) as reader:
            followed += follow_clicks(reader, near, wanted, cancelled=work.stopped)
    proposer, found = Proposer(), list[Prediction]()
    names, sigmas = project.landmark_set().names, project.click_sigmas()
    clicked = {click.camera for click in near} | {view.image.camera for view in recording.views}
    clicked -= project.marks.unused_cameras()
    cameras = {name: one for name, one in recording.cameras.items() if name in clicked}
    for frame in wanted:
        work.step(0.5 + 0.5 * (frame - frames.start) / len(frames), f"frame {frame}")
        own, around = clicks_around(project, frame, gaps)
        there = tuple(one for one in followed if one.frame == frame)
        fps = recording.fps
        question = ProposalQuestion(frame, own, around, there, cameras, names, fps, sigmas)
        found += proposer(question).predictions
    kept = _keep_predictions(project, PROPOSED, outside_gaps(project, found), selection)
    return f"{counted(kept, 'point')} predicted in {selection.words()}."


def clicks_around(
    project: Project, frame: int, gaps: Sequence[range]
) -> tuple[tuple[Click, ...], tuple[Click, ...]]:
    """Clicks of a frame, and those of the clicked frames around it, up to the next gaps."""
    first = max((gap.stop for gap in gaps if gap.stop <= frame), default=0)
    end = min((gap.start for gap in gaps if gap.start > frame), default=2**62)
    frames = [int(one) for one in project.clicks.frames() if first <= one < end]
    before = [one for one in frames if one < frame][-_SIDE:]
    after = [one for one in frames if one > frame][:_SIDE]
    around = (click for one in (*before, *after) for click in project.clicks.used(one, one + 1))
    return project.clicks.used(frame, frame + 1), tuple(around)
