"""Values of a run beside its measures: failures and the range of motion of every joint angle."""

from __future__ import annotations

from typing import NamedTuple

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, stretches_of
from stereotrack_core.evaluation.joint_angles.motion import motion_of, range_of_motion
from stereotrack_core.evaluation.joint_angles.series import angles_of_run
from stereotrack_core.evaluation.measures import measure_named
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run

_RANGES = ("minimum", "maximum", "range", "mean", "peak_velocity")
_PERCENTILES = {"median": "median", "p95": "95th percentile"}


class Named(NamedTuple):
    """What a value is, as the exported table says it."""

    measure: str
    statistic: str
    unit: str
    """``mm``, ``deg``, ``deg/s``, ``%``, ``s``; ``1`` for a pure number or a count."""


def values_of(run: Run, fps: float, truth: LandmarkTrajectory | None) -> dict[str, float]:
    """Values by name, ``left_elbow_flexion:range``; `fps` are frame sets per second."""
    tracked = float(run.tracked.sum())
    failures = stretches_of(FailureSearch(run, fps, truth))
    by_signs = sum(one.found == "signs" for one in failures)
    found = {"frames_tracked:count": tracked, "failures_by_signs:count": float(by_signs)}
    if truth is not None:
        found["failures_by_error:count"] = float(len(failures) - by_signs)
    if not tracked:
        return found
    angles = angles_of_run(run)
    for one in range_of_motion(angles, motion_of(angles, fps))[0].ranges:
        degrees = one.degrees()
        found |= {f"{one.angle.name}:{statistic}": degrees[statistic] for statistic in _RANGES}
    return found


def named(name: str) -> Named:
    """What a value of this name is."""
    whole, _, statistic = name.partition(":")
    if statistic:
        units = {"count": "1", "peak_velocity": "deg/s"}
        return Named(whole, statistic, units.get(statistic, "deg"))
    measure = measure_named(name)
    unit = measure.unit if measure is not None else ""
    start, _, end = name.rpartition("_")
    if end in _PERCENTILES:
        return Named(start, _PERCENTILES[end], unit)
    return Named(name, "share" if unit == "%" else "mean", unit or "1")
