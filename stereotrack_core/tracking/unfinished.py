"""A run that was stopped, and goes on from there."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.frame import Run, TrackedFrame, assembled
from stereotrack_core.tracking.saved_state import Arrays
from stereotrack_core.tracking.stored import shape_of_meta

INCOMPLETE = "incomplete"  # key of a run's meta: whether frames are still to come


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """State of a run between two frames."""

    frame: int  # last frame that it has seen
    started: bool  # whether somebody has been there, so that it was given a first pose
    arrays: Arrays  # see :meth:`Tracking.saved`


@dataclass(frozen=True, eq=False)
class UnfinishedRun:
    """Frames and saved state of a run that was stopped."""

    frames: tuple[TrackedFrame, ...]  # ascending; without clouds
    state_names: tuple[str, ...]
    meta: Mapping[str, Any]  # as a complete run has it
    wall_seconds: float  # that were spent on it
    checkpoint: Checkpoint | None = None  # last one before any missing frame
    keypoints: Keypoints | None = None  # that the run was given, of all frames that were asked for

    @property
    def asked(self) -> range:
        """Frames that were asked for."""
        first, end = self.meta["frames"]
        return range(int(first), int(end))

    @property
    def done(self) -> tuple[TrackedFrame, ...]:
        """Frames that need not be tracked again."""
        if self.checkpoint is None:
            return ()
        return tuple(frame for frame in self.frames if frame.frame <= self.checkpoint.frame)

    def rest_of(self, frames: range) -> range:
        """Frames that are still to be tracked."""
        if self.checkpoint is None:
            return frames
        return frames[frames.index(self.checkpoint.frame) + 1 :]

    @property
    def resumed_at(self) -> tuple[int, ...]:
        """Frames with which tracking has gone on, and now goes on."""
        return (*self.meta.get("resumed_at", ()), *self.rest_of(self.asked)[:1])

    @property
    def shape(self) -> BodyShape:
        """Of the body that was tracked."""
        return shape_of_meta(self.meta)

    def run(self) -> Run:
        """The frames that there are, as a run that says that it is incomplete."""
        more = {"wall_seconds": self.wall_seconds, INCOMPLETE: len(self.frames) < len(self.asked)}
        return assembled(self.frames, self.state_names, {**self.meta, **more}, self.keypoints)

    def changed_by(self, again: TrackedFrame) -> bool:
        """Whether a frame that is tracked again comes out otherwise than it was kept."""
        for frame in self.frames:
            if frame.frame == again.frame:
                before, now = (np.r_[f.x, f.P.ravel(), f.landmarks.ravel()] for f in (frame, again))
                return not np.array_equal(before, now, equal_nan=True)
        return False
