"""Predictions for what nobody has clicked: from a fit, a run, neighbours, or following.

They are made for a selection, kept under the word of their source, and accepted by an edit. None of
them is a click before a person says so, so there is nothing to undo before; none is made where a
person has said anything already, be it that there is nothing.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey, Prediction, sigma_of
from stereotrack_core.annotation.epipolar import in_image
from stereotrack_core.annotation.fit.results import GAP, TrajectoryFit
from stereotrack_core.annotation.follow import FOLLOWING, FollowedClick, follow_click
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera import Camera, pixel_jacobian
from stereotrack_core.project.clicks import AcceptPredictions
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection, gaps_of, landmark_gaps_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import Run

FIT, NEIGHBOURS = "fit", "neighbours"

_LIMB_LENGTH = 0.3  # metres by which the end of a limb moves when it turns by one radian
_BENT = 0.15
"""How far from the straight line between two clicks a landmark is half way, as a share of it."""

_CONTRADICTION = 4.0  # standard deviations by which following from both sides may differ


def from_fit(
    fit: TrajectoryFit, cameras: Mapping[str, Camera], frames: range | None = None
) -> Iterator[Prediction]:
    """Landmarks of a fit in every image; between clicked frames they are filled in joint space."""
    known = (fit.kind != GAP) & _within(fit.frame, frames)
    yield from _projected(
        fit.frame[known].tolist(),
        fit.names,
        fit.landmarks[known],
        fit.covariance[known],
        cameras,
        FIT,
    )


def from_run(
    run: Run,
    name: str,
    cameras: Mapping[str, Camera],
    landmark_set: LandmarkSet = NINE,
    frames: range | None = None,
) -> Iterator[Prediction]:
    """The landmarks of a set that a tracker found in every image; the source is ``run NAME``."""
    known = run.tracked & _within(run.frame, frames)
    names = [name for name in landmark_set.names if name in run.landmark_names]
    places = [run.landmark_names.index(one) for one in names]
    limbs = [LIMBS.index(landmark_set[one].limb) for one in names]
    spread = _LIMB_LENGTH * np.radians(run.limb_sigma_deg[known][:, limbs])
    covariance = np.square(spread)[..., None, None] * np.eye(3)
    numbers, points = run.frame[known].tolist(), run.landmarks[known][:, places]
    yield from _projected(numbers, names, points, covariance, cameras, source_of_run(name))


def source_of_run(name: str) -> str:
    """The source of predictions from a run of the project."""
    return f"run {name}"


def from_neighbours(
    clicks: Iterable[Click],
    *,
    gaps: Sequence[range] = (),
    longest: int = 30,
    sigma: Mapping[str, float] | float = USUAL_SIGMA,
) -> Iterator[Prediction]:
    """Straight from one click of a landmark in an image to its next one there.

    Deleted clicks and those outside the image end a stretch without a prediction over it, as do
    gaps, and more frames between two clicks than `longest`. `sigma` is the usual standard deviation
    of a click in pixels per axis.
    """
    rows: dict[tuple[str, str], list[Click]] = defaultdict(list)
    for click in clicks:
        if not click.deleted:
            rows[click.camera, click.landmark].append(click)
    for row in rows.values():
        row.sort(key=lambda click: click.frame)
        for one, two in pairwise(row):
            between = range(one.frame + 1, two.frame)
            broken = any(gap.start < two.frame and gap.stop > between.start for gap in gaps)
            if one.position and two.position and len(between) <= longest and not broken:
                yield from _straight(one, two, between, sigma)


def from_following(
    found: Iterable[FollowedClick], *, sigma: Mapping[str, float] | float = USUAL_SIGMA
) -> Iterator[Prediction]:
    """Where patches were followed to, as far as that is reliable.

    What was followed to one place from both sides is averaged by its certainty; where the two
    contradict each other, neither is taken.
    """
    places: dict[ClickKey, list[tuple[FloatArray, float]]] = defaultdict(list)
    for one in found:
        own = sigma_of(one.click, sigma)
        for i in range(1, one.followed.reliable_until):
            key = ClickKey(int(one.frame[i]), one.click.camera, one.click.landmark)
            spread = float(np.hypot(own, one.followed.sigma_px[i]))
            places[key].append((one.followed.pixels[i], spread))
    for key, several in places.items():
        pixels = np.array([pixel for pixel, _ in several])
        weights = np.array([spread for _, spread in several]) ** -2.0
        mean = weights @ pixels / weights.sum()
        apart = np.linalg.norm(pixels - mean, axis=1) * np.sqrt(weights)
        if apart.max() <= _CONTRADICTION:
            position = (float(mean[0]), float(mean[1]))
            yield Prediction(*key, FOLLOWING, position, float(weights.sum() ** -0.5))


def _within(frame: IntArray, frames: range | None) -> BoolArray:
    if frames is None:
        return np.ones(len(frame), dtype=np.bool_)
    return (frame >= frames.start) & (frame < frames.stop)


def _projected(
    frames: Sequence[int],
    names: Sequence[str],
    points: FloatArray,
    covariance: FloatArray,
    cameras: Mapping[str, Camera],
    source: str,
) -> Iterator[Prediction]:
    """Points (F, n, 3) with covariances (F, n, 3, 3) in all images that show them."""
    for name, camera in cameras.items():
        pixels = camera.project(points)
        jacobian = pixel_jacobian(camera, points)
        spread = jacobian @ covariance @ np.swapaxes(jacobian, -1, -2)
        sigma = np.sqrt(0.5 * np.trace(spread, axis1=-2, axis2=-1))
        for row, place in np.argwhere(in_image(camera, pixels)):
            x, y = pixels[row, place].tolist()
            own = float(sigma[row, place])
            yield Prediction(
                frames[row], name, names[place], source, (x, y), own if own > 0 else None
            )


def _straight(
    one: Click, two: Click, between: range, sigma: Mapping[str, float] | float
) -> Iterator[Prediction]:
    start, end = np.array(one.position), np.array(two.position)
    sides = sigma_of(one, sigma), sigma_of(two, sigma)
    for frame in between:
        share = (frame - one.frame) / (two.frame - one.frame)
        x, y = ((1.0 - share) * start + share * end).tolist()
        bent = _BENT * float(np.linalg.norm(end - start)) * 4.0 * share * (1.0 - share)
        spread = np.hypot((1.0 - share) * sides[0] + share * sides[1], bent)
        yield Prediction(frame, one.camera, one.landmark, NEIGHBOURS, (x, y), float(spread))


OnProgress = Callable[[float, str], None]

_AT_ONCE = 100  # frames between two looks at whether it shall stop
_LONGEST = 30  # frames between two clicks over which the straight line is worth while
_FARTHEST = 60  # frames outside the selection within which a click is followed into it


@dataclass(frozen=True, eq=False)
class Filling:
    """Where predictions come from."""

    source: str  # the word under which they are kept
    words: str  # what a person calls it: ``the fit``
    make: Callable[[range], Iterable[Prediction]]
    """Gives those of some frames; others that it gives are left out."""


def fit_filling(fit: TrajectoryFit, cameras: Mapping[str, Camera]) -> Filling:
    """From the body fitted to the clicks of the recording."""
    return Filling(FIT, "the fit", partial(from_fit, fit, cameras))


def run_filling(run: Run, name: str, cameras: Mapping[str, Camera], project: Project) -> Filling:
    """From a tracker's run, of which the frames that are not tracked are left out."""
    make = partial(from_run, run, name, cameras, project.landmark_set())
    return Filling(source_of_run(name), f"run “{name}”", make)


def neighbour_filling(project: Project) -> Filling:
    """Straight between a click and the next one of the same landmark in the same image."""
    gaps, sigma = gaps_of(project), project.click_sigmas()

    def make(frames: range) -> Iterable[Prediction]:
        first = max(frames.start - _LONGEST - 1, 0)
        clicks = project.clicks.between(first, frames.stop + _LONGEST + 1)
        return from_neighbours(clicks, gaps=gaps, longest=_LONGEST, sigma=sigma)

    return Filling(NEIGHBOURS, "neighbouring clicks", make)


def fill_in(
    project: Project,
    filling: Filling,
    selection: Selection,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> str:
    """Keep predictions for what is selected and nobody has clicked; gaps are left empty.

    Raises InputError where the project cannot be written to; Cancelled when stopped; nothing is
    kept then.

    Returns
    -------
    str
        What was done, in words.
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
            and one.frame not in barred
            and one.frame not in of_landmarks.get(one.landmark, ())
        ]
    kept = _keep_predictions(project, filling.source, found, selection)
    if not kept:
        return f"Nothing to fill from {filling.words} in {selection.words()}."
    return f"{counted(kept, 'point')} filled from {filling.words}."


def _keep_predictions(
    project: Project, source: str, found: Iterable[Prediction], selection: Selection
) -> int:
    """Let these be the predictions of a source in a selection; how many were kept.

    What the source says of other landmarks stays.
    """
    frames, kept = selection.frames, project.predictions.of_source(source)
    here = [one for one in found if one.frame in frames and selection.has(one.landmark)]
    others = [one for one in kept if one.frame in frames and not selection.has(one.landmark)]
    return project.predictions.replace(source, [*here, *others], frames=frames) - len(others)


def accept_predictions(project: Project, source: str, selection: Selection) -> AcceptPredictions:
    """The edit that makes clicks of what a source has found in the selection.

    Raises InputError where there is nothing to take.
    """
    edit = project.predictions.acceptance(source, selection.frames, selection.landmarks)
    if edit is None:
        called = {
            FOLLOWING: "followed points",
            FIT: "points from the fit",
            NEIGHBOURS: "points from neighbouring clicks",
        }.get(source, "points from the run")
        raise InputError(
            f"there are no {called} in {selection.words()}",
            remedy="Predict points for this selection first, then accept them.",
        )
    return edit


@dataclass(frozen=True)
class _Way:
    """A click and the frames that it is followed over, the first of which is its own."""

    click: Click
    frames: range


def follow_selection(
    project: Project,
    recording: Recording,
    selection: Selection,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> str:
    """Follow clicks into the selection and keep what is found as predictions, not as clicks.

    Raises InputError where there is no click to begin with, or the project cannot be written to;
    Cancelled when stopped; nothing is kept then.

    Returns
    -------
    str
        What was done, in words.
    """
    ways = [(view, tuple(_ways(project, view.image.camera, selection))) for view in recording.views]
    count = sum(len(some) for _, some in ways)
    if not count:
        raise InputError(
            f"there is no click near {selection.words()} to follow",
            remedy="Click landmarks in the first frames of the selection first.",
        )
    found: list[FollowedClick] = []
    for view, some in ways:
        if not some:
            continue
        with FrameReader(recording, views=[view.name], colour=False) as reader:
            for way in some:
                if cancelled():
                    raise Cancelled
                words = f"{way.click.landmark.replace('_', ' ')} in {way.click.camera}"
                on_progress(len(found) / count, words)
                found.append(follow_click(reader, way.click, way.frames, cancelled=cancelled))
    predictions = from_following(found, sigma=project.click_sigmas())
    kept = _keep_predictions(project, FOLLOWING, predictions, selection)
    return f"{counted(kept, 'point')} found by following {counted(count, 'click')}."


def _ways(project: Project, camera: str, selection: Selection) -> Iterator[_Way]:
    """Forward and backward from every click in or near the selection, as far as the next one."""
    frames = selection.frames
    near = project.clicks.between(max(frames.start - _FARTHEST, 0), frames.stop + _FARTHEST)
    rows: dict[str, list[Click]] = defaultdict(list)
    for click in near:
        if click.camera == camera and click.position is not None and selection.has(click.landmark):
            rows[click.landmark].append(click)
    for row in rows.values():
        numbers = [click.frame for click in row]
        following = [*numbers[1:], frames.stop]
        before = [frames.start - 1, *numbers[:-1]]
        for click, after, last in zip(row, following, before, strict=True):
            end, back = min(after, frames.stop), max(last, frames.start - 1)
            if end > max(click.frame + 1, frames.start):
                yield _Way(click, range(click.frame, end))
            if back < min(click.frame - 1, frames.stop - 1):
                yield _Way(click, range(click.frame, back, -1))
