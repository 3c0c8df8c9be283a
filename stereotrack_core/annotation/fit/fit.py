"""The body fitted to clicked landmarks: one frame live, a trajectory, or a whole recording.

In a trajectory, clicks are followed over the frames, forward and backward, and the frames between
them filled. Frames are asked one by one from those whose clicks tell the pose, once in each
direction: from the neighbour's pose, from what was filled in, and from the other way along the line
of sight of a lone camera. What explains clicks, points and movement best is taken, first in each
frame and then of both directions over all frames.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey, Sigmas, measurements
from stereotrack_core.annotation.fit.context import (
    FitContext,
    filled_over_time,
    pose_at,
    triangulated,
)
from stereotrack_core.annotation.fit.live import fitted_frame
from stereotrack_core.annotation.fit.residuals import MEDIAN_SURPRISE
from stereotrack_core.annotation.fit.results import (
    CLICKED,
    GAP,
    INTERPOLATED,
    FrameFit,
    TrajectoryFit,
    exact_residuals,
    reported,
)
from stereotrack_core.annotation.fit.state import FitSettings, Freedom, pose_sigmas
from stereotrack_core.annotation.fit.stretch import (
    Fitted,
    FrameData,
    MeasuredDepth,
    Stretch,
    depth_cost,
    recorded_depth,
)
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray, stretches_of
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import HANGING, Pose, rotation_towards
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.body.skeleton import FOREARMS, PARENTS, SHANKS, THIGHS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import variance_by_cameras
from stereotrack_core.one_thread import one_blas_thread
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader

_ROUNDS_ALONE = 4
_STEP = (0.06, 10.0, 20.0)  # movement in a frame at 10 Hz: metres; degrees of torso, of a joint
_TOLD = (0.05, 8.0, 15.0)  # how far a pose that clicks tell may be off
_LEGS = (*THIGHS, *SHANKS)
_LEG_SIGMA = np.radians(45.0)
_STATED_AT = 10.0  # frames per second
_LARGEST = 25.0  # what one click can cost at most when poses are compared
_ENDS = {
    UPPER_ARMS[0]: "left_elbow",
    UPPER_ARMS[1]: "right_elbow",
    FOREARMS[0]: "left_hand",
    FOREARMS[1]: "right_hand",
}
"""The landmark at the far end of a part of the arms."""


@dataclass(frozen=True, eq=False)
class _Answer:
    """A pose for a frame, with what its measurements and its movement cost."""

    pose: Pose
    measured: float = 0.0
    moved: float = 0.0


def _asked_between(
    stretch: Stretch, data: Sequence[FrameData], poses: Sequence[Pose], known: BoolArray, fps: float
) -> list[Pose]:
    """Poses to begin from; of `known` (K,) frames the clicks tell the pose.

    An arm that is lost stays lost in the frames that are asked after: where one way through a gap
    loses it, the other often does not, and each frame takes what fits together best.
    """
    f = stretch.freedom
    found = [_on_legs(pose) for pose in poses] if f.with_depth else list(poses)
    if not known.any():
        return found
    told_sigma = pose_sigmas(f, *_TOLD)  # where the clicks tell all but the legs
    for at in (f.columns.first[part] for part in _LEGS if f.with_depth):
        told_sigma[at : at + 2] = _LEG_SIGMA
    for k in np.flatnonzero(known).tolist():
        if f.with_depth and data[k].depth is not None:
            found[k] = _asked(stretch, data[k], found[k], found[k], told_sigma).pose
    sigma = pose_sigmas(f, *_STEP) * np.sqrt(_STATED_AT / fps)
    there = _followed(stretch, data, found, known, sigma)
    back = _followed(stretch, data[::-1], found[::-1], known[::-1], sigma)[::-1]
    answers = [[one for one in both if one] for both in zip(there, back, strict=True)]
    return _cheapest(answers, lambda a, b: _moved(stretch, a, b, sigma))


def _followed(
    stretch: Stretch,
    data: Sequence[FrameData],
    filled: Sequence[Pose],
    known: BoolArray,
    sigma: FloatArray,
) -> list[_Answer | None]:
    """Answers of frames asked one after the other; None before the first `known` one."""
    found: list[_Answer | None] = []
    before: Pose | None = None
    for frame, pose, told in zip(data, filled, known, strict=True):
        answer = _Answer(pose) if told or before is not None else None
        deep = frame.depth is not None and stretch.freedom.with_depth
        if before is not None and not told and (len(frame.clicks) or deep):
            starts = [before, pose, *_other_ways(stretch, frame, pose)]
            every = [_asked(stretch, frame, start, before, sigma) for start in starts]
            answer = min(every, key=lambda one: one.measured + one.moved)
        found.append(answer)
        before = answer.pose if answer else None
    return found


def _cheapest(
    answers: Sequence[Sequence[_Answer]], moved: Callable[[Pose, Pose], float]
) -> list[Pose]:
    """One answer's pose of each frame, all together as cheap as can be (Viterbi)."""
    total, steps = np.zeros(1), list[IntArray]()
    for before, own in pairwise((answers[0][:1], *answers)):
        every = total[:, None] + [[moved(b.pose, a.pose) for b in own] for a in before]
        steps.append(every.argmin(axis=0))
        total = every.min(axis=0) + [one.measured for one in own]
    chosen, found = int(total.argmin()), list[Pose]()
    for own, step in zip(reversed(answers), reversed(steps), strict=True):
        found.append(own[chosen].pose)
        chosen = int(step[chosen])
    return found[::-1]


def _on_legs(pose: Pose) -> Pose:
    """The pose with legs that go straight down, however the trunk bends."""
    rotations = pose.rotations.copy()
    down = pose.torso.T @ np.array([0.0, 0.0, -1.0])
    for part in _LEGS[:2]:
        rotations[part] = rotation_towards(HANGING, down)
    for part in _LEGS[2:]:
        rotations[part] = np.eye(3)
    return Pose(pose.position, rotations)


def _asked(
    stretch: Stretch, frame: FrameData, start: Pose, expected: Pose, sigma: FloatArray
) -> _Answer:
    found = stretch.fit([frame], [start], expected, sigma, rounds=_ROUNDS_ALONE)
    pose = found.states[0].pose
    measured = float(np.minimum(found.judgements[0].surprise, _LARGEST).sum())
    if frame.depth is not None and stretch.freedom.with_depth:
        measured += depth_cost(stretch, frame.depth.points, pose)
    return _Answer(pose, measured, _moved(stretch, pose, expected, sigma))


def _moved(stretch: Stretch, pose: Pose, expected: Pose, sigma: FloatArray) -> float:
    moved = stretch.freedom.pose_difference(pose, expected) / sigma
    return float(moved @ moved)


def _cameras(stretch: Stretch, frame: FrameData) -> IntArray:
    """In how many cameras each landmark (L,) of a frame is clicked."""
    return np.bincount(frame.clicks.landmark, minlength=len(stretch.freedom.parts))


def _other_ways(stretch: Stretch, frame: FrameData, pose: Pose) -> list[Pose]:
    """The pose with one part the other way along the line of sight of the one camera."""
    f, names = stretch.freedom, stretch.freedom.landmark_set.names
    cameras = _cameras(stretch, frame)
    frames, found = f.body.frames(pose), []
    for part, name in _ENDS.items():
        i = names.index(name)
        if cameras[i] != 1:
            continue
        click = int(np.flatnonzero(frame.clicks.landmark == i)[0])
        rotation = frame.clicks.rotations[click]
        sight = rotation.T @ np.append(frame.clicks.normalised[click], 1.0)
        sight /= np.linalg.norm(sight)
        along = frames.rotations[part][:, 2]
        turned = along - 2.0 * (along @ sight) * sight
        rotations = pose.rotations.copy()
        local = frames.rotations[PARENTS[part]].T @ turned
        rotations[part] = rotation_towards(rotations[part], local)
        found.append(Pose(pose.position, rotations))
    return found


_LONGEST_FILL = 2.0  # seconds from every clicked frame within which frames are filled without depth
_ROUNDS = 8
_ANYWHERE = (2.0, 120.0, 90.0)  # error of a first pose: metres; degrees of torso and joints
Clouds = Callable[[int], Cloud | MeasuredDepth | None]  # depth of a frame; None where there is none


def _connected_stretches(
    context: FitContext, clicked: Mapping[int, Sequence[Click]], gaps: Sequence[range], deep: bool
) -> list[range]:
    """Frames that hang together: between gaps, and near enough to a clicked frame."""
    frames = range(min(clicked), max(clicked) + 1) if clicked else range(0)
    near = np.array([not any(frame in gap for gap in gaps) for frame in frames], dtype=np.bool_)
    own = np.array([bool(clicked[frame]) for frame in frames], dtype=np.bool_)
    found: list[range] = []
    for run in stretches_of(near):
        inside = np.flatnonzero(own[run.start : run.stop]) + run.start
        if not len(inside):
            continue
        reach = len(frames)
        if not deep:
            reach = int(_LONGEST_FILL * context.fps)
        away = np.abs(np.arange(run.start, run.stop)[:, None] - inside).min(axis=1)
        kept = stretches_of(away <= reach)
        found += [frames[run.start + one.start : run.start + one.stop] for one in kept]
    return found


def _fitted_stretch(context: FitContext, data: Sequence[FrameData]) -> tuple[Freedom, Fitted]:
    """Fit the clicks alone, and with what that gives to begin from, clicks and depth."""
    seen = [triangulated(one.clicks, len(context.whole.names)) for one in data]
    points = filled_over_time(np.array(seen))
    start = [pose_at(point, context.body, context.whole, context.usual) for point in points]
    stretch = context.by_clicks
    wanted = len(context.asked.landmarks)
    # their clicks tell the pose where the landmarks that are asked for are in two cameras each
    known: BoolArray = np.array([_cameras(stretch, one)[:wanted].min() > 1 for one in data])
    found = _together(stretch, data, start)
    if not known.all():
        start = [state.pose for state in found.states]
        start = _asked_between(stretch, data, start, known, context.fps)
        found = _together(stretch, data, start)
    if not any(one.depth is not None for one in data):
        return stretch.freedom, found
    start = [state.pose for state in found.states]
    context = context.shaped(data, start, np.flatnonzero(known))
    stretch = context.by_depth
    start = _asked_between(stretch, data, start, known, context.fps)
    return stretch.freedom, _together(stretch, data, start)


def _together(stretch: Stretch, data: Sequence[FrameData], start: Sequence[Pose]) -> Fitted:
    sigma = pose_sigmas(stretch.freedom, *_ANYWHERE)
    return stretch.fit(data, start, start[0], sigma, rounds=_ROUNDS)


def _put_together(
    context: FitContext,
    clicked: Mapping[int, Sequence[Click]],
    frames: range,
    filled: Sequence[tuple[range, Freedom, Fitted]],
) -> TrajectoryFit:
    """Arrange fitted stretches as one trajectory; frames in none of them are gaps."""
    names, count = context.asked.names, len(frames)
    places = np.full((count, len(names), 3), np.nan)
    covariance = np.full((count, len(names), 3, 3), np.nan)
    limbs, nine = np.full((count, len(LIMBS)), np.nan), np.full((count, len(LANDMARKS), 3), np.nan)
    kind = np.full(count, GAP, dtype="U12")
    residual: dict[ClickKey, FloatArray] = {}
    outlier: dict[ClickKey, float] = {}
    surprise: list[FloatArray] = []
    clicking = {one.camera for own in clicked.values() for one in own}
    rig = variance_by_cameras([context.cameras[name] for name in sorted(clicking)]) * np.eye(3)
    for stretch, freedom, found in filled:
        for i, frame in enumerate(stretch):
            k, own = frames.index(frame), clicked[frame]
            report = reported(freedom, found.states[i], found.P[i], len(names))
            places[k], covariance[k] = report.places, report.covariance + rig
            limbs[k], nine[k] = report.limb_sigma_deg, report.nine
            kind[k] = CLICKED if own else INTERPOLATED
            off = exact_residuals(own, names, report.places, context.cameras)
            judgement = found.judgements[i]
            surprise.append(judgement.surprise)
            for one, miss, p in zip(own, off, judgement.outlier_probability, strict=True):
                residual[one.key], outlier[one.key] = miss, float(p)
    squared = np.concatenate([np.zeros(0), *surprise])
    factor = float(np.sqrt(np.median(squared) / MEDIAN_SURPRISE)) if len(squared) else np.nan
    numbers = np.array(frames, dtype=np.int64)
    return TrajectoryFit(
        names, numbers, places, covariance, limbs, kind, nine, residual, outlier, factor
    )


class ClickFit(FitContext):
    """Fits one person's body to clicks."""

    def frame(
        self, measurements: Sequence[Click], *, cloud: Cloud | MeasuredDepth | None = None
    ) -> FrameFit:
        """Fit one frame to clicks, which may be few or none, and to measured points.

        What they do not decide is as in the usual pose. Raises KeyError for an unknown camera.
        """
        with one_blas_thread():
            return fitted_frame(self, measurements, cloud)

    def trajectory(
        self,
        measurements_by_frame: Mapping[int, Sequence[Click]],
        frames: range,
        *,
        clouds: Clouds | None = None,
        gaps: Sequence[range] = (),
        on_frame: Callable[[int], None] = lambda _frame: None,
    ) -> TrajectoryFit:
        """Follow the clicks forward and backward, not over gaps."""
        clicked = {frame: tuple(measurements_by_frame.get(frame, ())) for frame in frames}
        clouds = clouds if self.settings.use_depth else None
        filled = []
        with one_blas_thread():
            for stretch in _connected_stretches(self, clicked, gaps, clouds is not None):
                data = []
                for frame in stretch:
                    data.append(self.data(clicked[frame], clouds(frame) if clouds else None))
                    on_frame(frame)
                filled.append((stretch, *_fitted_stretch(self, data)))
            return _put_together(self, clicked, frames, filled)


@dataclass(frozen=True)
class FitRequest:
    """Frames to fit, and the clicks that count; all frames and views if not given.

    Examples
    --------
    >>> FitRequest(range(20, 60), views=("N", "S"), sigma=2.0)
    """

    frames: range | None = None
    views: Sequence[str] | None = None
    settings: FitSettings = field(default_factory=FitSettings)
    landmarks: LandmarkSet = NINE
    sigma: Sigmas = USUAL_SIGMA  # of a click, pixels per axis
    source: str = "clicks"  # of the clicks, for messages
    gaps: Sequence[range] = ()  # frames that are left unknown


def fit_reference(
    recording: Recording,
    clicks: Sequence[Click],
    request: FitRequest | None = None,
    *,
    on_frame: Callable[[int], None] = lambda _frame: None,
) -> TrajectoryFit:
    """Fit the body to clicked landmarks, forward and backward over the frames.

    The recording's depth is used where it has any; frames between clicked ones are filled.
    `on_frame` is told every frame whose depth is read.

    Raises InputError where none of these frames is clicked in these views.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> fit = fit_reference(recording, read_clicks(Path("clicks.csv"), recording).checked())
    >>> fit.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (120, 9, 3)
    """
    r = FitRequest() if request is None else request
    frames = r.frames
    if frames is None:
        with FrameReader(recording, views=r.views, read_ahead=0) as reader:
            frames = range(reader.frame_count)
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in measurements(clicks_in(recording, clicks, r.views), r.landmarks.names, r.sigma):
        if click.frame in frames:
            by_frame[click.frame].append(click)
    if not by_frame:
        where = "" if r.views is None else " of these views"
        what = f"there is no click in frames {frames.start} to {frames.stop - 1}{where}"
        remedy = "Click a few frames first, or choose other frames or views."
        raise InputError(what, r.source, remedy)
    person = proportions_of(recording.subject)
    fitting = ClickFit(recording.cameras, r.landmarks, person, r.settings, recording.fps)
    with recorded_depth(recording, r.settings, r.views) as depth:
        return fitting.trajectory(by_frame, frames, clouds=depth, gaps=r.gaps, on_frame=on_frame)


def clicks_in(
    recording: Recording, clicks: Sequence[Click], views: Sequence[str] | None
) -> list[Click]:
    """Clicks in the cameras of the chosen views; all where none are chosen."""
    if views is None:
        return list(clicks)
    cameras = {s.camera for name in views for s in recording.view(name).streams().values()}
    return [click for click in clicks if click.camera in cameras]
