"""Repair of stretches before clicks in which the tracker had lost a limb or the body.

Where clicks put the body elsewhere, it was lost some frames before. From the clicked frame it is
followed backwards, until both ways agree again, the frame before is clicked too, or it cannot be
followed. Where both ways were explained worst, one gives over to the other.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from stereotrack_core.body.model import landmarks
from stereotrack_core.recording.detections import Detections
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.initialise.people import own_part
from stereotrack_core.tracking.residuals.clicks import contradicted
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.step import PersonModel
from stereotrack_core.tracking.tracking import Tracking

REPAIRED = "repaired"  # key in a run's meta: frames that were followed backwards from a clicked one
_AGREE = 3  # successive frames in which both ways agree before the stretch is taken to be over
_UNTRACKED = 1000.0  # cost of a frame that one way does not have


def repaired(
    run: Tracking, found: Sequence[TrackedFrame], cancelled: Callable[[], bool] = lambda: False
) -> tuple[list[TrackedFrame], list[int]]:
    """Frames with clicks, some exchanged for those followed backwards, and the numbers of these."""
    model, clicks = run.model, run.clouds.spec.clicks or Detections()
    if not isinstance(model, PersonModel):
        return list(found), []
    clicked = [i for i, frame in enumerate(found) if clicks.until(frame.frame)]
    mended: list[TrackedFrame] = []
    for before, i in zip([-1, *clicked], clicked, strict=False):
        if cancelled():
            break
        if found[i].tracked and found[i].estimate.prior is None:
            back = list(_followed_back(run.clouds, model, found, range(i - 1, before, -1), i))
            mended += _better(found, back, i, model, smooth=run.clouds.spec.smooth)
    by_frame = {frame.frame: frame for frame in mended}
    return [by_frame.get(frame.frame, frame) for frame in found], sorted(by_frame)


_Step = tuple[TrackedFrame, float, float]


def _followed_back(
    clouds: Clouds, model: PersonModel, found: Sequence[TrackedFrame], way: range, i: int
) -> Iterator[_Step]:
    """Frames on the way back, the cost of each, and the cost of the pose that was found there."""
    setup, origin, agreed = model.setup, found[i].estimate, 0
    follower, cost = replace(model.finder.follower, judges=True), model.finder.cost
    state = State(origin.pose, origin.P, found[i].frame)
    for j in way:
        whole, _ = clouds.take(found[j].frame)
        if len(whole.points) < setup.parameters.least_points:
            return
        cloud = own_part(whole, setup.body, state.pose, setup.upright)
        state, estimate = follower.step(state, cloud)
        if not estimate.tracked:
            return
        forwards = found[j].pose
        there = _UNTRACKED if forwards is None else cost(forwards, cloud)
        points = landmarks(setup.body, estimate.pose)
        bare = replace(estimate, correspondences=None)
        mended = replace(found[j], estimate=bare, landmarks=points)
        yield mended, cost(estimate.pose, cloud), there
        same = forwards is not None and not contradicted(setup.body, forwards, estimate.pose)
        agreed = agreed + 1 if same else 0
        if agreed == _AGREE:
            return


def _better(
    found: Sequence[TrackedFrame],
    back: Sequence[_Step],
    i: int,
    model: PersonModel,
    *,
    smooth: bool,
) -> list[TrackedFrame]:
    """The frames of the way back, as far as it costs less altogether than the way forwards."""
    gained = np.cumsum([0.0, *(there - here for _, here, there in back)])
    count = int(np.argmax(gained))
    frames = [found[i], *(frame for frame, _, _ in back[:count])]
    if smooth:
        frames = smoothed(frames, model.setup)
    return [replace(one, estimate=replace(one.estimate, prior=None)) for one in frames[1:]]
