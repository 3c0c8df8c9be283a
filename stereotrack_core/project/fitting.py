"""The body fitted to a project's clicks: as a reference of the project, and what is said of it."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.annotation import doubts
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.click_gains import SCORED
from stereotrack_core.annotation.fit.fit import FitRequest, fit_reference
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.reference import (
    FITTED_TO,
    MAX_SIGMA,
    FittedClicks,
    Reference,
    checksums,
    fit_of_reference,
    fitted_clicks,
    merged_reference,
    origin_of,
    reference_of_fit,
    without_gaps,
)
from stereotrack_core.arrays import stretches_of
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import counted, spread_words
from stereotrack_core.evaluation.accuracy import arms_good_to, reference_quality
from stereotrack_core.geometry.camera_agreement import Disagreement
from stereotrack_core.project.entries import choose, load_reference, save_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.project.selection import gaps_of, landmark_gaps_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import check_calibrated
from stereotrack_core.worker_processes import Asker

FITTED = "fitted to clicks"  # name of the reference that the window makes


def fit_elsewhere(fit: Callable[..., TrajectoryFit], asker: Asker) -> TrajectoryFit:
    """Call :func:`fit_reference`, given with all but ``on_frame``, in a :class:`TaskProcess`."""
    return fit(on_frame=lambda _frame: asker.on_frames(1))


def fit_project(
    project: Project,
    recording: Recording,
    frames: range,
    settings: FitSettings,
    do: Callable[[Callable[..., TrajectoryFit]], TrajectoryFit],
    *,
    between: bool = True,
) -> Reference:
    """Fit the body to all clicks of some frames, by the project's landmarks, subject and gaps.

    Without `between`, frames that are not clicked are left unknown, which takes a fraction of the
    time.

    `do` calls :func:`fit_reference`, given with all but ``on_frame``. Raises InputError, Cancelled.
    """
    check_calibrated(recording)
    begun, landmarks = time.monotonic(), project.landmark_set()
    clicks = project.clicks.used(frames.start, frames.stop)
    sigma, subject = project.click_sigmas(), project.subject() or recording.subject
    gaps = [*gaps_of(project)]
    if not between:
        own = np.isin(frames, [click.frame for click in clicks])
        gaps += [frames[one.start : one.stop] for one in stretches_of(~own)]
    where = project.path.name
    request = FitRequest(frames, None, settings, landmarks, sigma, source=where, gaps=gaps)
    fit = do(partial(fit_reference, replace(recording, subject=subject), clicks, request))
    clicked = {(click.frame, click.landmark) for click in clicks if click.position is not None}
    meta = {
        **origin_of(recording, len(clicks), sigma, settings),
        FITTED_TO: [list(row) for row in sorted(checksums(clicks).items())],
        "subject": "" if subject is None else subject.name,
        "seconds": time.monotonic() - begun,
    }
    return reference_of_fit(without_gaps(fit, landmark_gaps_of(project), clicked), meta, clicks)


def keep_fitted(project: Project, reference: Reference, frames: range | None) -> None:
    """Save a fit, in some frames or altogether, and let the project use it."""
    if frames is not None:
        known = FITTED in project.references.names()
        old = load_reference(project.references, FITTED) if known else None
        reference = merged_reference(old, reference, frames)
    project.apply(save_reference(FITTED, reference, replacing=True))
    if project.chosen(project.references) != FITTED:
        project.apply(choose(REFERENCE, FITTED))


def frames_around(frames: range, clicked: tuple[int, ...], last: int) -> range:
    """Frames from the clicked one before to the one after, up to the recording's last."""
    before = [frame for frame in clicked if frame < frames.start]
    after = [frame for frame in clicked if frame >= frames.stop]
    end = min(min(after, default=frames.stop - 1), last) + 1
    return range(max(before, default=frames.start), end)


@dataclass(frozen=True, eq=False)
class ShownReference:
    """The project's reference, and what follows from it."""

    name: str
    reference: Reference
    fit: TrajectoryFit | None  # None where it was not fitted to the project's landmarks
    words: str  # how good it is
    outliers: tuple[ClickKey, ...] = ()  # clicks that look like outliers
    clicks: FittedClicks | None = None  # that it was fitted to, and changes; None if unknown


def read_reference(project: Project, recording: Recording, name: str) -> ShownReference:
    """The reference of that name, with what follows from it and the present clicks."""
    reference, landmarks = load_reference(project.references, name), project.landmark_set()
    clicks, cameras = project.clicks.used(), recording.cameras
    fit = fit_of_reference(reference, landmarks, clicks, cameras)
    if fit is None:
        good = arms_good_to(reference_quality(reference, reference.frame))
        says = f"arm uncertainty {spread_words(good)}"
        words = f"“{name}”: {len(reference.frame)} frames, {says}. {reference.left_out(MAX_SIGMA)}"
        return ShownReference(name, reference, None, words.strip())
    doubtful = doubts.doubtful_camera(clicks, cameras, landmarks)
    outliers = doubts.own_outliers(fit.flagged(), doubtful, clicks, cameras)
    words = f"“{name}”: {_words(fit, len(outliers), doubtful, recording.camera_names())}"
    words += f" {reference.left_out(MAX_SIGMA)}"
    known = fitted_clicks(reference.meta, clicks)
    return ShownReference(name, reference, fit, words.strip(), outliers, known)


def _words(
    fit: TrajectoryFit, outliers: int, doubtful: Disagreement | None, names: Mapping[str, str]
) -> str:
    """How good a fit is: ``30 frames: 6 clicked …; limb uncertainty 2.3° overall …``."""
    kinds = {kind: int((fit.kind == kind).sum()) for kind in (CLICKED, INTERPOLATED, GAP)}
    known = fit.kind != GAP
    parts = [
        f"{counted(len(fit.frame), 'frame')}: {kinds[CLICKED]} clicked,"
        f" {kinds[INTERPOLATED]} interpolated, {kinds[GAP]} in gaps"
    ]
    if known.any():
        rms = np.sqrt(np.nanmean(np.square(fit.limb_sigma_deg[known]), axis=0))
        scored = {limb: float(rms[LIMBS.index(limb)]) for limb in SCORED}
        worst = max(scored, key=lambda limb: scored[limb])
        together = float(np.sqrt(np.mean(np.square(list(scored.values())))))
        arm = f"{spread_words(scored[worst])} for the {worst.replace('_', ' ')}"
        parts.append(f"limb uncertainty {spread_words(together)} overall, {arm}")
    if doubtful is not None:
        parts.append(doubts.what_disagrees(doubtful, names))
    if outliers:
        verb = "looks like an outlier" if outliers == 1 else "look like outliers"
        parts.append(f"{counted(outliers, 'click')} {verb}")
    words = "; ".join(parts) + "."
    return words if doubtful is None else f"{words} {doubts.what_to_do(doubtful)}"
