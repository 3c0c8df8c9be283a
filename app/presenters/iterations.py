"""What happens inside one step of the tracker, iteration by iteration."""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import dataclass
from typing import Any

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Correspondences, Estimate
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.thesis import ThesisTracker


@dataclass(frozen=True, eq=False)
class Iteration:
    """The model after some iterations of one frame.

    Attributes
    ----------
    frame : int
    words : str
        What it shows.
    body : BodyModel
    pose : Pose
    correspondences : Correspondences or None
        Pairs that the next iteration will use.
    cloud : Cloud
    """

    frame: int
    words: str
    body: BodyModel
    pose: Pose
    correspondences: Correspondences | None
    cloud: Cloud


class Iterations:
    """The prediction for one frame and what each iteration makes of it; the tracker itself stays.

    The step is repeated on copies of the tracker with one iteration, two, and so on. A copy
    carries its random numbers along, so the first i iterations are the same every time.

    Parameters
    ----------
    pipeline : Pipeline
        Between two frames.
    cloud : Cloud
        Of the frame that the tracker does next.
    started : bool
        Whether the tracker has a pose already.
    """

    def __init__(self, pipeline: Pipeline, cloud: Cloud, *, started: bool) -> None:
        self.frame = cloud.frame
        self._body = pipeline.body
        self._cloud = cloud
        # what both trackers have in common beyond the protocol is known at run time only
        tracker: Any = pipeline.tracker
        self._tracker = copy.deepcopy(tracker)
        if not started and len(cloud.points):
            self._tracker.start(pipeline.first_pose(cloud))
        self._count = int(self._tracker.parameters.iterations)
        self._pose = _predicted_pose(self._tracker)
        self._done = -1

    def next(self) -> Iteration | None:
        """The model after one iteration more, the prediction first; None after the last one."""
        self._done += 1
        if self._done > self._count:
            return None
        pose, pairs = self._pose, None
        if self._done < self._count:
            estimate = self._after(self._done + 1)
            if estimate.tracked:
                pairs, self._pose = estimate.correspondences, estimate.pose
            else:
                self._done = self._count
        words = f"iteration {self._done} of {self._count}" if self._done else "predicted model"
        return Iteration(self.frame, words, self._body, pose, pairs, self._cloud)

    def _after(self, iterations: int) -> Estimate:
        twin = copy.deepcopy(self._tracker)
        twin.parameters = dataclasses.replace(twin.parameters, iterations=iterations)
        estimate: Estimate = twin.step(self._cloud)
        return estimate


def _predicted_pose(tracker: Any) -> Pose:
    twin = copy.deepcopy(tracker)
    twin.predict()
    if isinstance(twin, ThesisTracker):
        return pose_of_state(twin.x, THESIS_JOINTS)
    pose: Pose = twin.pose
    return pose
