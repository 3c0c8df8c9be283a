"""What errors are measured against, and how good that is itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import IntArray
from stereotrack_core.evaluation.accuracy import reference_quality
from stereotrack_core.recording.landmarks import LandmarkTrajectory

Against: TypeAlias = Literal["recording", "project"]

TORSO_POSITION = "torso_position"


@dataclass(frozen=True, eq=False)
class Truth:
    """A trajectory that is taken as truth."""

    against: Against
    """Whose it is."""
    words: str
    """``the project's reference “fitted to clicks”``."""
    trajectory: LandmarkTrajectory
    reference: Reference | None = None
    """What says how good it is; None where nothing does."""

    def quality(self, frames: IntArray) -> dict[str, float]:
        """How good it is over some frames, by measure; see :func:`reference_quality`."""
        return {} if self.reference is None else reference_quality(self.reference, frames)


def recorded_truth(trajectory: LandmarkTrajectory | None) -> Truth | None:
    """The recording's own reference, which does not say how good it is."""
    if trajectory is None:
        return None
    return Truth("recording", "the recording's reference", trajectory)


def project_truth(name: str, reference: Reference) -> Truth:
    """The reference that a project uses."""
    words = f"the project's reference “{name}”"
    return Truth("project", words, reference.trajectory(), reference)


def measure_of(limb: str) -> str:
    """The measure that a limb's error is; the torso's is its long axis."""
    return "torso_long" if limb == "torso" else limb


def with_quality(error: str, good: float | None, digits: int = 1) -> str:
    """``9.1°, reference good to 2.3``; the error alone where the reference does not say."""
    if good is None or not np.isfinite(good):
        return error
    return f"{error}, reference uncertainty {good:.{digits}f}"
