"""Do a frame of a recording once more, with a trace of what the step did."""

from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import body_model
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.model import TrackModel, TrackState, initialiser, step
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.thesis import ThesisModel
from stereotrack_core.tracking.trace import StepTrace

STORED = (
    "Starts from the pose and covariance stored for the previous frame, not from the original "
    "tracker. The rest of its state, such as {besides}, is not stored."
)
_DRAWN = "its random numbers (other model points are sampled)"
_LEARNED = "alternative poses of its first frames and learned colours"
FIRST = (
    "The run has no pose for the previous frame. The step therefore starts from the run's pose of "
    "this frame, with the uncertainty of an initial pose."
)
NOBODY = "No pose is known for the previous frame, so the pose is initialised automatically."


@dataclass(frozen=True, eq=False)
class RecordedStep:
    """Record of a step, its cloud, and a sentence on where the step began."""

    trace: StepTrace
    cloud: Cloud
    words: str


def beginning_at(
    model: TrackModel, cloud: Cloud, before: Estimate | None = None, here: Estimate | None = None
) -> tuple[TrackState, str]:
    """State before a frame, by the run's estimates before and `here`, and a sentence on it."""
    if before is not None and before.tracked:
        P = before.P if np.isfinite(before.P).all() else None
        besides = _DRAWN if isinstance(model, ThesisModel) else _LEARNED
        return model.first(before.pose, P=P), STORED.format(besides=besides)
    if here is not None and here.tracked:
        return model.first(here.pose), FIRST
    if isinstance(model, ThesisModel):
        # The thesis's own body, without legs, cannot be looked for.
        body, p = body_model(model.setup.body.skeleton.proportions), TrackingParameters()
        finder = initialiser(replace(model.setup, body=body, parameters=p, volume=None))
        return model.first(finder.step(finder.absent(), cloud)[1].pose), NOBODY
    return model.absent(), NOBODY


def explain(
    model: TrackModel, state: TrackState, cloud: Cloud, truth: FloatArray | None = None
) -> StepTrace:
    """Do the step from a state to a cloud, and record it; it gives the same as without a record.

    With true landmarks (9, 3) the record also says what the true arms would have cost.
    """
    recorder = StepRecorder(model.setup, Belief(state.pose, state.P), truth)
    return recorder.trace(cloud.frame, step(model, state, cloud, recorder)[1])
