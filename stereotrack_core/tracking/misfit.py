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

MOST_UNEXPLAINED = 0.26
"""Unexplained fraction of the cloud, median over the tracked frames, above which nothing fits:
sound recordings have 0.05 to 0.24, those with wrong calibrations mostly 0.27 to 0.6
(docs/runs.md)."""

MOST_ASIDE = 0.3
"""Share of the points that are left aside as nobody's, median over the tracked frames: sound
recordings have none, views that show the person in different places 0.4 to 0.8 (docs/runs.md)."""

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
        The bounds hold for trackers whose data look for a body with legs; of others nothing is
        said.
    """
    signs = [
        (frame.unexplained_fraction, frame.estimate.aside) for frame in frames if frame.tracked
    ]
    p = settings
    if not signs or p.tracking.matching != "data_to_model" or not p.body.legs:
        return ()
    unexplained, aside = np.nanmedian(signs, axis=0).tolist()
    found = []
    if unexplained > MOST_UNEXPLAINED:
        found.append(
            f"{100 * unexplained:.0f} % of the cloud is explained by no part of the body, in sound "
            "recordings 24 % at most; the poses are probably wrong"
        )
    if aside > MOST_ASIDE:
        found.append(
            f"{100 * aside:.0f} % of the points are not the person's who is tracked: somebody or "
            "something else is in the working volume, or the views show the person in different "
            "places"
        )
    return tuple(found)


def with_warnings(run: Run, frames: Iterable[TrackedFrame], settings: Settings) -> Run:
    """The run, whose meta says what looks wrong about the frames that it was made of."""
    return replace(run, meta={**run.meta, WARNINGS: list(misfits(frames, settings))})
