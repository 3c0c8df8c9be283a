"""What has to be known before the first frame, found in the first clouds: pose and shape."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.chain import OnPart
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.initialise.finder import PoseFinder, differ, trunks_differ
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.measurements import chosen_data
from stereotrack_core.tracking.residuals.silhouette import edge_maps
from stereotrack_core.tracking.run_spec import Hooks
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape, fitted_surface
from stereotrack_core.tracking.step import PersonModel, PersonState

_BETTER = 6.0  # cost by which a pose that is not the usual one must be better to be taken
_UNUSUAL = 20.0  # the same of one that faces away from it: front and back look much alike
# Cost by which the usual pose may be worse after one step than what was found, to be taken at once:
# where it is right, 25 and less; where the clouds after the first showed another one, 60 and more.
_UNSETTLED = 40.0
_TURN_GAIN = 3.0  # cost by which a body fitted the other way round must be more natural to be taken
_FITTED = 8  # clouds that both ways of facing are followed over; every second one is fitted to


def first_pose_in(
    initialiser: PersonModel, clouds: Sequence[Cloud], told: OnPart = lambda _done, _count: None
) -> Pose | None:
    """Pose in the first of successive clouds in which somebody is tracked; None without anybody.

    The pose in which recordings usually begin, the T pose facing north, is taken at once where it
    leads several views to the pose that is found in the first cloud; a world whose z does not point
    up has no north.

    Else the clouds are followed forwards, until it has shown which of the poses that explain the
    first one is right, and then back to it. Where the usual pose explains the clouds about as
    well, it is taken; a body that is turned round on the way did not face it. At last it is looked
    at from both sides with bodies of their own shape. `told` may raise :class:`Cancelled`.
    """
    steps = _Steps(initialiser, told, 3 * len(clouds) + 2 * len(clouds[:_FITTED]))
    setup, usual = initialiser.setup, None
    state, estimates = initialiser.absent(), list[Estimate]()
    for cloud in clouds:
        state, estimate = steps.step(state, cloud)
        if usual is None and estimate.tracked and setup.upright == Z_UP:
            usual = t_pose_in_cloud(setup.body, cloud.points)
            several = len(cloud.view_names) > 1  # to one view, front and back look too much alike
            if several and _leads_to(steps, usual, cloud, estimate.pose):
                return usual
        estimates.append(estimate)
    tracked = [k for k, estimate in enumerate(estimates) if estimate.tracked]
    if not tracked:
        return None
    first, last = tracked[0], tracked[-1]
    if usual is not None and _explains_as_well(steps, usual, clouds[first:], estimates[first:]):
        return usual
    steps.done = 2 * len(clouds)
    found = _followed_back(steps, clouds[first : last + 1], estimates[first : last + 1])
    steps.done = 3 * len(clouds)
    return facing_right(initialiser, found, clouds[first : last + 1], steps.tell)


@dataclass
class _Steps:
    """Steps of a model, of which somebody is told how many are done."""

    model: PersonModel
    told: OnPart
    count: int
    done: int = 0

    def tell(self) -> None:
        """Tell that one more begins."""
        self.told(self.done, self.count)
        self.done += 1

    def step(self, state: PersonState, cloud: Cloud) -> tuple[PersonState, Estimate]:
        """Do one step."""
        self.tell()
        return self.model.step(state, cloud)


FIT_FRAMES = 12  # frames that the shape is fitted to: more bring nothing (docs/accuracy.md)
_LOOK_AHEAD = 5  # frames in which somebody is looked for, for each that the fit needs
_LEAST_SETTLED = 3  # frames without which a fit would be worse than the default shape


def first_clouds(
    cloud: Callable[[int], Cloud], frames: range, least: int, told: OnPart
) -> list[Cloud]:
    """The first clouds that show somebody: with at least so many points, made frame by frame."""
    found: list[Cloud] = []
    for frame in frames[: _LOOK_AHEAD * FIT_FRAMES]:
        told(len(found), FIT_FRAMES)
        made = cloud(frame)
        if len(made.points) >= least:
            found.append(made)
        if len(found) == FIT_FRAMES:
            break
    return found


def facing(pose: Pose, degrees: float | None, upright: Upright) -> Pose:
    """The pose, or the one turned round where that is nearer to a heading, from north over east."""
    if degrees is None:
        return pose
    wanted = np.array([np.sin(np.radians(degrees)), np.cos(np.radians(degrees)), 0.0])
    faces = upright.rotation @ pose.torso[:, 1]
    return pose if faces @ wanted >= 0.0 else turned_round(pose)


def shape_in(
    initialiser: PersonModel,
    clouds: Sequence[Cloud],
    first_pose: Callable[[Cloud], Pose],
    hooks: Hooks,
) -> BodyShape | None:
    """Shape of who is followed over successive clouds; None where too few show somebody.

    `first_pose` gives the pose in a cloud, from which the person is followed.
    """
    setup, seen, state = initialiser.setup, list[SeenPose](), initialiser.absent()
    for done, cloud in enumerate(clouds):
        hooks.on_preparing("tracking the first frames", done, len(clouds))
        if not seen:
            state = initialiser.first(first_pose(cloud))
        hooks.before_step()
        state, estimate = initialiser.step(state, cloud)
        if estimate.tracked:
            data = chosen_data(setup, cloud)
            seen.append(SeenPose(data, estimate.pose, edge_maps(cloud), setup.upright))
    settled = seen[len(seen) // 3 :: 2]
    if len(settled) < _LEAST_SETTLED:
        return None
    told = partial(hooks.on_preparing, "fitting the body shape")
    return fitted_shape(setup.body, settled, setup.parameters, setup.joints, told)


def _followed_back(steps: _Steps, clouds: Sequence[Cloud], estimates: Sequence[Estimate]) -> Pose:
    """Pose in the first cloud, followed back from the last; both are tracked."""
    state = steps.model.first(estimates[-1].pose, clouds[-1].frame)
    for cloud in reversed(clouds[:-1]):
        state, estimate = steps.step(state, cloud)
        if not estimate.tracked:
            return estimates[0].pose
    return state.pose


def facing_right(
    initialiser: PersonModel, found: Pose, clouds: Sequence[Cloud], told: Callable[[], object]
) -> Pose:
    """The pose, or the one that looks most alike from the other side if that is more natural.

    A body of average shape that faces the wrong way may explain the data better than one that
    faces the right way. With shapes of their own both explain them about as well, but the one
    that faces the wrong way then bends its knees and elbows as nobody can. The pose is that in the
    first of the clouds; `told` is called before every step, and may raise :class:`Cancelled`.
    """
    away = turned_round(found)
    here, there = (
        _gain_of_turning(initialiser, pose, clouds[:_FITTED], told) for pose in (found, away)
    )
    return away if here - there > 2.0 * _TURN_GAIN else found


def _gain_of_turning(
    initialiser: PersonModel, pose: Pose, clouds: Sequence[Cloud], told: Callable[[], object]
) -> float:
    """How much more natural the other way round is, for a body fitted to this way of facing."""
    setup, follower = initialiser.setup, initialiser.follower
    state, poses = follower.first(pose), []
    for cloud in clouds:
        told()
        state, estimate = follower.step(state, cloud)
        poses.append(estimate.pose)
    pairs = list(zip(clouds, poses, strict=True))[len(clouds) > 1 :: 2]
    seen = [SeenPose(chosen_data(setup, c), pose, upright=setup.upright) for c, pose in pairs]
    body, fitted = fitted_surface(setup.body, seen, setup.parameters, setup.joints)
    judge = PoseFinder(replace(setup, body=body))
    gains = [judge.gain_of_turning(p, c) for p, (c, _) in zip(fitted, pairs, strict=True)]
    return float(np.mean(gains))


def _leads_to(steps: _Steps, usual: Pose, cloud: Cloud, found: Pose) -> bool:
    """Whether following from the usual pose gives what was found in the same cloud, or better arms.

    One step has not settled yet, so that it may be somewhat worse.
    """
    _, estimate = steps.step(steps.model.first(usual), cloud)
    if not estimate.tracked or trunks_differ(estimate.pose, found):
        return False
    cost = steps.model.finder.cost
    more = cost(estimate.pose, cloud) - cost(found, cloud)
    return more < (0.0 if differ(estimate.pose, found) else _UNSETTLED)


def _explains_as_well(
    steps: _Steps, usual: Pose, clouds: Sequence[Cloud], found: Sequence[Estimate]
) -> bool:
    """Whether following from the usual pose costs no more than the poses found, or little more."""
    state, more, cost = steps.model.first(usual), [], steps.model.finder.cost
    for cloud, other in zip(clouds, found, strict=True):
        state, estimate = steps.step(state, cloud)
        if not estimate.tracked or estimate.pose.torso[:, 1] @ usual.torso[:, 1] < 0.0:
            return False  # lost, or turned round by following
        if other.tracked:
            more.append(cost(estimate.pose, cloud) - cost(other.pose, cloud))
    forward = [other.pose.torso[:, 1] @ usual.torso[:, 1] for other in found if other.tracked]
    turned_away = min(forward) < 0.0
    return float(np.mean(more)) < (_UNUSUAL if turned_away else _BETTER)
