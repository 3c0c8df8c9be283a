"""Measures of a run, as the tables of sweeps and studies have them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation import summary
from stereotrack_core.evaluation.summary import at_frames, doubts_against, errors_against
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.sighted_keypoints import keypoints_in_views
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.run_checks import keypoint_fits
from stereotrack_core.tracking.stored import body_of_run, pose_of_run


@dataclass(frozen=True)
class Measure:
    """One column of numbers in a sweep's table."""

    name: str  # heading of the column
    label: str  # for people
    unit: str
    more_is_better: bool = False
    short: str = ""  # label where there is little room

    @property
    def title(self) -> str:
        """Label with its unit: ``forearms, mean [deg]``."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


def _errors() -> Iterator[Measure]:
    for name, label, unit in summary.ERROR_MEASURES:
        yield Measure(name, f"{label}, mean", unit, short=label)
        yield Measure(f"{name}_median", f"{label}, median", unit)
        yield Measure(f"{name}_p95", f"{label}, 95 %", unit)


MEASURES: tuple[Measure, ...] = (
    *_errors(),
    Measure("lost", "arm segments lost", "%", short="lost"),
    Measure("not_tracked", "frames of the reference not tracked", "%", short="not tracked"),
    Measure("lost_precision", "flagged segments that are lost", "%", more_is_better=True),
    Measure("lost_recall", "lost segments that are flagged", "%", more_is_better=True),
    Measure("gaps", "frames without a pose", "%", short="no pose"),
    Measure("unexplained_fraction", "unexplained fraction", "%", short="unexplained"),
    Measure("residual", "residual", "mm"),
    Measure("keypoint_error", "keypoint error, median", "px", short="keypoints"),
    Measure("innovation", "normalised innovation", ""),
    Measure("limb_sigma", "uncertainty of the limbs", "deg", short="uncertain"),
    Measure("limb_lost", "mean failure probability of arm segments", "%", short="flagged as lost"),
    Measure("frames_per_second", "frames per second", "", more_is_better=True, short="fps"),
    Measure("seconds", "computing time in seconds", "s"),
)
"""Errors against the reference as ``evaluate`` gives them, then the tracker's own signs."""


def measure_named(name: str) -> Measure | None:
    """The measure of that name, or of a named stretch: ``crossing/forearms``; else None."""
    segment, slash, whole = name.rpartition("/")
    found = next((measure for measure in MEASURES if measure.name == whole), None)
    if found is None or not slash:
        return found
    label, short = f"{segment}: {found.label}", f"{segment}: {found.short or found.label}"
    return replace(found, name=name, label=label, short=short)


def of_segments(
    run: Run, reference: LandmarkTrajectory | None, segments: Sequence[Segment]
) -> dict[str, float]:
    """Mean errors of a run over named stretches, such as ``crossing/forearms``."""
    if reference is None or not len(run.frame):
        return {}
    errors = errors_against(run.trajectory(), at_frames(reference, run.frame))
    found = {}
    for part in summary.summarise_segments(errors, segments):
        found[f"{part.name}/lost"] = 100.0 * part.lost
        for measure in part.measures:
            found[f"{part.name}/{measure.name}"] = measure.statistics.mean
    return found


def measured(
    run: Run,
    reference: LandmarkTrajectory | None,
    recording: Recording | None = None,
    keypoints: Keypoints | None = None,
) -> dict[str, float]:
    """All measures of a run but its times, without a reference its signs; NaN if unknown.

    Recording and keypoints are those that the run was tracked with.
    """
    found = {**_errors_of(run, reference), **_signs(run)}
    if recording is not None and keypoints is not None:
        found["keypoint_error"] = keypoint_error(run, recording, keypoints)
    return found


def _errors_of(run: Run, reference: LandmarkTrajectory | None) -> Mapping[str, float]:
    if reference is None or not len(run.frame):
        return {}
    errors = errors_against(run.trajectory(), at_frames(reference, run.frame))
    if not len(errors.frame):
        return {}
    pooled = summary.summarise(errors)
    values = {
        f"{measure.name}{end}": getattr(measure.statistics, figure)
        for measure in pooled.measures
        for end, figure in (("", "mean"), ("_median", "median"), ("_p95", "p95"))
    }
    doubts = doubts_against(run.frame, run.limb_lost, errors)
    return values | {
        "lost": 100.0 * pooled.lost,
        "not_tracked": 100.0 * pooled.not_tracked / pooled.frames,
        "lost_precision": 100.0 * doubts.precision,
        "lost_recall": 100.0 * doubts.recall,
    }


def _signs(run: Run) -> Mapping[str, float]:
    tracked = run.tracked
    arms = run.limb_lost[tracked][:, [*UPPER_ARMS, *FOREARMS]]
    return {
        "gaps": 100.0 * float(1.0 - tracked.mean()) if len(tracked) else float("nan"),
        "unexplained_fraction": 100.0 * _mean(run.unexplained_fraction[tracked]),
        "residual": 1000.0 * _mean(run.residual[tracked]),
        "innovation": _mean(run.innovation[tracked]),
        "limb_sigma": _mean(run.limb_sigma_deg[tracked]),
        "limb_lost": 100.0 * _mean(arms),
    }


def _mean(values: FloatArray) -> float:
    return summary.statistics(values).mean


def keypoint_error(run: Run, recording: Recording, keypoints: Keypoints) -> float:
    """Median distance in pixels of keypoints, sides corrected, from the poses; NaN without."""
    there = {view.name for view in recording.views}
    views = [name for name in run.meta.get("views", ()) if name in there]
    seen, body = keypoints_in_views(recording, views, keypoints), body_of_run(run)
    poses = ((frame, pose_of_run(run, i)) for i, frame in enumerate(run.frame.tolist()))
    tracked = ((frame, pose) for frame, pose in poses if pose is not None)
    fits = keypoint_fits(tracked, body, seen)
    found = (np.linalg.norm(fit.seen.pixel - fit.predicted, axis=2).ravel() for fit in fits)
    every = np.concatenate([np.empty(0), *found])
    known = every[np.isfinite(every)]
    return float(np.median(known)) if len(known) else float("nan")
