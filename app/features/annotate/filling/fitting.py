"""The body fitted to the clicks of a whole recording, and what is said of it."""

from __future__ import annotations

import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from stereotrack_core import __version__
from stereotrack_core.annotation.click import Click, measurements
from stereotrack_core.annotation.click_points import click_pixels, click_residuals, limb_residuals
from stereotrack_core.annotation.doubts import what_disagrees, what_to_do
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.limb_axes import SCORED
from stereotrack_core.annotation.reference import Reference, reference_of_fit, without_gaps
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera_agreement import Disagreement
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording

from ....services.tasks.helper_process import HelperProcess
from ....session.counting import counted
from ....widgets.style.limb_colours import limb_words
from ..selection import gaps_of, landmark_gaps_of
from .fit_job import FitJob, frames_done

FITTED = "fitted to clicks"
"""Name of the reference that the window makes."""

OnProgress = Callable[[float, str], None]
_LOOK_SECONDS = 0.15
_TAKING_IN_SECONDS = 1.5


@dataclass(frozen=True, eq=False)
class FitOrder:
    """What shall be fitted.

    Attributes
    ----------
    project : Project
    recording : Recording
    frames : range
    settings : FitSettings
    """

    project: Project
    recording: Recording
    frames: range
    settings: FitSettings = field(default_factory=FitSettings)


@dataclass(frozen=True, eq=False)
class FittedRecording:
    """A fit and what is shown of it.

    Attributes
    ----------
    order : FitOrder
    fit : TrajectoryFit
    reference : Reference
    residuals : (F, 6) float64
        Of each limb's clicks in pixels, over the frames of the fit; NaN without a click.
    """

    order: FitOrder
    fit: TrajectoryFit
    reference: Reference
    residuals: FloatArray


def fit_process() -> HelperProcess:
    """A process that fits; it starts with the first fit and has to be closed."""
    return HelperProcess(f"{FitJob.__module__}:worker")


def fit_recording(
    order: FitOrder,
    process: HelperProcess,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> FittedRecording:
    """Fit the body to all clicks of some frames; called off the window's thread.

    Parameters
    ----------
    order : FitOrder
    process : HelperProcess
        Of :func:`fit_process`: fitting computes for minutes, and the window has to be painted.
        It is closed when the fit is stopped.
    on_progress : callable
    cancelled : callable

    Raises
    ------
    InputError
        Where there is no click to fit to.
    Cancelled
        When stopped.
    """
    project, begun = order.project, time.monotonic()
    landmarks = project.landmark_set()
    clicks = project.clicks.between(order.frames.start, order.frames.stop)
    if not any(click.position is not None for click in clicks):
        raise InputError(
            f"there is no click in frames {order.frames.start} to {order.frames.stop - 1}",
            where=project.path.name,
            remedy="Click landmarks in a few frames first.",
        )
    sigma = project.click_sigmas()
    subject = project.subject() or order.recording.subject
    by_frame = {
        frame: measurements(own, landmarks.names, sigma) for frame, own in _by_frame(clicks).items()
    }
    with tempfile.TemporaryDirectory() as folder:
        job = FitJob(
            order.recording, landmarks, proportions_of(subject), order.settings, by_frame,
            order.frames, gaps_of(project), Path(folder) / "progress",
        )  # fmt: skip
        fit = _fit_elsewhere(job, process, on_progress, cancelled)
    clicked = {(click.frame, click.landmark) for click in clicks if click.position is not None}
    fit = without_gaps(fit, landmark_gaps_of(project), clicked)
    meta = {
        "program": "stereotrack",
        "version": __version__,
        "recording": order.recording.name,
        "subject": "" if subject is None else subject.name,
        "clicks": len(clicks),
        "click_sigma_px": sigma,
        "settings": asdict(order.settings),
        "seconds": time.monotonic() - begun,
    }
    return FittedRecording(
        order, fit, reference_of_fit(fit, meta), residuals_of(fit, clicks, order)
    )


def residuals_of(fit: TrajectoryFit, clicks: tuple[Click, ...], order: FitOrder) -> FloatArray:
    """Residuals (F, 6) of each limb's clicks in pixels, over the frames of the fit."""
    pixels = click_pixels(clicks, order.recording.cameras, fit.names)
    away = click_residuals(pixels, fit.frame, fit.landmarks)
    residuals = np.full((len(fit.frame), len(LIMBS)), np.nan)
    _, own, theirs = np.intersect1d(fit.frame, pixels.frame, return_indices=True)
    residuals[own] = limb_residuals(away, order.project.landmark_set())[theirs]
    return residuals


def fit_words(
    fit: TrajectoryFit,
    mistakes: int,
    doubtful: Disagreement | None = None,
    names: Mapping[str, str] | None = None,
) -> str:
    """How good a fit is: ``good to 2.3° (root mean square over the limbs) …``.

    Parameters
    ----------
    fit : TrajectoryFit
    mistakes : int
        Clicks that look like gross mistakes.
    doubtful : Disagreement, optional
        A camera that contradicts the others.
    names : mapping from camera to str, optional
        How people call the cameras.
    """
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
        parts.append(
            f"limb uncertainty {together:.1f}° overall, {scored[worst]:.1f}° for the "
            f"{limb_words(worst)}"
        )
    if doubtful is not None:
        parts.append(what_disagrees(doubtful, names))
    if mistakes:
        verb = "looks like an outlier" if mistakes == 1 else "look like outliers"
        parts.append(f"{counted(mistakes, 'click')} {verb}")
    words = "; ".join(parts) + "."
    return words if doubtful is None else f"{words} {what_to_do(doubtful)}"


def how_far(done: int, of: int, seconds: float) -> tuple[float, str]:
    """How far a fit is: the share, 0 where nobody knows it, and words.

    Parameters
    ----------
    done, of : int
        Frames that are taken in, and all.
    seconds : float
        Since a frame was taken in last: no more of them means that these are being fitted.
    """
    if done == 0:
        return 0.0, "preparing"
    if done < of and seconds < _TAKING_IN_SECONDS:
        return 0.9 * done / of, f"frame {done} of {of} added"
    return 0.0, f"forward and backward pass over the frames, {seconds:.0f} s"


def around(frames: range, clicked: tuple[int, ...], last: int) -> range:
    """Frames with what they hang on: from the clicked frame before to the one after.

    Parameters
    ----------
    frames : range
    clicked : tuple of int
        Frames with clicks.
    last : int
        The recording's last frame.
    """
    before = [frame for frame in clicked if frame < frames.start]
    after = [frame for frame in clicked if frame >= frames.stop]
    return range(
        max(before, default=frames.start), min(min(after, default=frames.stop - 1), last) + 1
    )


def _by_frame(clicks: tuple[Click, ...]) -> dict[int, list[Click]]:
    found: dict[int, list[Click]] = defaultdict(list)
    for click in clicks:
        found[click.frame].append(click)
    return found


def _fit_elsewhere(
    job: FitJob,
    process: HelperProcess,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> TrajectoryFit:
    """Let another process fit, tell how far it is, and end it when that is wanted."""
    over = threading.Event()

    def watch() -> None:
        before, since = 0, time.monotonic()
        while not over.wait(_LOOK_SECONDS):
            if cancelled():
                process.close()
                return
            done, now = frames_done(job), time.monotonic()
            if done != before:
                before, since = done, now
            on_progress(*how_far(done, len(job.frames), now - since))

    watching = threading.Thread(target=watch, name="watch fit", daemon=True)
    watching.start()
    try:
        fit: TrajectoryFit = process(job)
    except EOFError as error:
        if cancelled():
            raise Cancelled from error
        raise InputError(
            "the fit process ended unexpectedly",
            where=job.recording.name,
            remedy="If memory is short, close other programs. Then run the fit again.",
        ) from error
    finally:
        over.set()
        watching.join()
    return fit
