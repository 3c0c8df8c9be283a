"""Signs of a whole run that body, cameras and clouds do not fit each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.run import Run
from stereotrack_core.tracking.settings import Settings

WARNINGS = "warnings"
"""Key of a run's meta."""

MOST_UNEXPLAINED = 0.3
"""Unexplained fraction of the cloud, median over the tracked frames, above which nothing fits:
sound recordings have 0.05 to 0.28, those with wrong calibrations 0.15 to 0.6 (docs/runs.md)."""

MOST_CONTRADICTED = 0.03
"""Share of the points that other views see through, median over the frames that were asked, above
which views do not fit each other: sound recordings have up to 0.015, those with wrong calibrations
mostly 0.04 to 0.7 (docs/runs.md)."""

CHECK = (
    "Check the calibration with `stereotrack info --deep`: whether views or cameras are exchanged, "
    "a rotation is inverted, or a base line or unit is wrong."
)


def misfits(frames: Iterable[TrackedFrame], settings: Settings) -> tuple[str, ...]:
    """What looks wrong about a run, as clauses; :data:`CHECK` is what to do.

    Parameters
    ----------
    frames : iterable of TrackedFrame
        With or without their clouds.
    settings : Settings
        What is unexplained says nothing about trackers whose body has no legs, and about those
        whose model looks for the data.
    """
    every, found = list(frames), []
    views = [frame.contradicted for frame in every if np.isfinite(frame.contradicted)]
    if views and (through := float(np.median(views))) > MOST_CONTRADICTED:
        found.append(
            f"{100 * through:.0f} % of the points of one view lie where another one sees the "
            "background behind them, in sound recordings hardly any; the views do not fit each "
            "other"
        )
    with_legs = settings.tracking.matching == "data_to_model" and settings.body.legs
    shares = [frame.unexplained_fraction for frame in every if frame.tracked]
    if with_legs and shares and (unexplained := float(np.nanmedian(shares))) > MOST_UNEXPLAINED:
        found.append(
            f"{100 * unexplained:.0f} % of the cloud is explained by no part of the body, in sound "
            "recordings 28 % at most; the poses are probably wrong"
        )
    return tuple(found)


def with_warnings(run: Run, frames: Iterable[TrackedFrame], settings: Settings) -> Run:
    """The run, whose meta says what looks wrong about the frames that it was made of."""
    return replace(run, meta={**run.meta, WARNINGS: list(misfits(frames, settings))})
