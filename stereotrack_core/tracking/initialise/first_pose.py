"""What has to be known before the first frame, found in the first clouds: pose and shape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.residuals.silhouette import edge_maps
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape, fitted_surface
from stereotrack_core.tracking.tracker import PersonTracker

_BETTER = 6.0
"""Cost by which a pose that is not the usual one must be better to be taken."""

_UNUSUAL = 20.0
"""Cost by which a first pose that faces away from the usual one must be better: front and back look
much alike."""

_TURN_GAIN = 3.0
"""Cost by which a body fitted the other way round must be more natural to be taken."""

_FITTED = 8
"""Clouds that both ways of facing are followed over; every second one is fitted to."""


Told = Callable[[int, int], object]
"""Is told how many of how many parts are done."""


def first_pose_in(
    initialiser: PersonTracker, clouds: Sequence[Cloud], told: Told = lambda _done, _count: None
) -> Pose | None:
    """Pose in the first of successive clouds in which somebody is tracked; None without anybody.

    The clouds are followed forwards, until it has shown which of the poses that explain the first
    one is right, and then back to it. Where the pose in which recordings usually begin, the T
    pose facing north, explains the clouds about as well, it is taken; a world whose z does not
    point up has no north, and a body that is turned round on the way did not face it. At last it
    is looked at from both sides with bodies of their own shape. Nothing of the initialiser is left
    as it was. `told` may raise :class:`Cancelled`.
    """
    step = _Steps(initialiser, told, 3 * len(clouds) + 2 * len(clouds[:_FITTED]))
    initialiser.reinitialise()
    estimates = [step(cloud) for cloud in clouds]
    tracked = [k for k, estimate in enumerate(estimates) if estimate.tracked]
    if not tracked:
        return None
    first, last = tracked[0], tracked[-1]
    if initialiser.setup.upright == Z_UP:
        usual = t_pose_in_cloud(initialiser.setup.body, clouds[first].points)
        if _explains_as_well(initialiser, usual, clouds[first:], estimates[first:], step):
            return usual
    step.done = 2 * len(clouds)
    found = _followed_back(initialiser, clouds, estimates, first, last, step)
    step.done = 3 * len(clouds)
    return facing_right(initialiser, found, clouds[first : last + 1], step.tell)


class _Steps:
    """Steps of a tracker, of which somebody is told how many are done."""

    def __init__(self, tracker: PersonTracker, told: Told, count: int) -> None:
        self._tracker, self._told, self._count = tracker, told, count
        self.done = 0

    def tell(self) -> None:
        """One more begins."""
        self._told(self.done, self._count)
        self.done += 1

    def __call__(self, cloud: Cloud) -> Estimate:
        self.tell()
        return self._tracker.step(cloud)


def search_chain(reader: FrameReader, chosen: DepthParameters, views: Sequence[str]) -> DepthChain:
    """The way to clouds in which a preset that does not search in its own looks for the first pose.

    Parameters keep their defaults, except those that differ in `chosen` from the preset ``thesis``.
    """
    usual = {row.name: row.presets.get("thesis", row.default) for row in DepthParameters.rows()}
    changed = {name: value for name, value in chosen.values().items() if value != usual[name]}
    wanted = DepthParameters().replaced(**changed)
    return DepthChain(
        reader.recording, settled(reader.recording, wanted, reader, views), views=views
    )


def first_pose_from_images(
    initialiser: PersonTracker,
    chain: DepthChain,
    reader: FrameReader,
    frames: Sequence[int],
    learned_from: range,
    told: Told = lambda _done, _count: None,
) -> Pose | None:
    """First pose for a tracker whose own clouds are not made for search, followed to its place.

    Parameters
    ----------
    initialiser : PersonTracker
        Of the default shape; nothing of it is left as it was.
    chain : DepthChain
        See :func:`search_chain`; it is closed.
    frames : sequence of int
        Successive frames.
    learned_from : range
        Frames from which the background is learned where there are no images of it.
    told : callable
        As for :func:`first_pose_in`.
    """
    try:
        chain.learn_background(reader, learned_from)
        clouds = [chain.process(reader.frame_set(frame)) for frame in frames]
    finally:
        chain.close()
    found = first_pose_in(initialiser, clouds, told)
    if found is None:
        return None
    initialiser.start(found)
    estimates = [initialiser.step(cloud) for cloud in clouds]
    return next((estimate.pose for estimate in estimates if estimate.tracked), found)


FIT_FRAMES = 12
"""Frames that the shape is fitted to: more bring nothing (docs/accuracy.md)."""

_LOOK_AHEAD = 5
"""Frames in which somebody is looked for to fit the shape, for each frame that it needs."""


def first_clouds(
    cloud: Callable[[int], Cloud], frames: range, least: int, told: Told
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


_LEAST_SETTLED = 3
"""Frames without which a fit would be worse than the default shape."""


def shape_in(
    initialiser: PersonTracker,
    clouds: Sequence[Cloud],
    first_pose: Callable[[Cloud], Pose],
    before_step: Callable[[Cloud], object],
    on_preparing: Callable[[str, int, int], None],
) -> BodyShape | None:
    """Shape of who is followed over successive clouds; None where too few show somebody.

    Parameters
    ----------
    initialiser : PersonTracker
        Of which nothing is left as it was.
    first_pose : callable
        Where the person is in the first cloud.
    before_step : callable
        Called before every step; may raise :class:`Cancelled`.
    on_preparing : callable
        Is told the stage, and how many of how many of its parts are done.
    """
    setup, seen = initialiser.setup, list[SeenPose]()
    for done, cloud in enumerate(clouds):
        on_preparing("tracking the first frames", done, len(clouds))
        if not seen:
            initialiser.start(first_pose(cloud))
        before_step(cloud)
        estimate = initialiser.step(cloud)
        if estimate.tracked:
            data = initialiser.leader.correspondences.choose(cloud)
            seen.append(SeenPose(data, estimate.pose, edge_maps(cloud), setup.upright))
    settled = seen[len(seen) // 3 :: 2]
    if len(settled) < _LEAST_SETTLED:
        return None
    told = partial(on_preparing, "fitting the body shape")
    return fitted_shape(setup.body, settled, setup.parameters, setup.joints, told)


def _followed_back(
    initialiser: PersonTracker,
    clouds: Sequence[Cloud],
    estimates: Sequence[Estimate],
    first: int,
    last: int,
    step: _Steps,
) -> Pose:
    initialiser.start(estimates[last].pose, clouds[last].frame)
    for cloud in reversed(clouds[first:last]):
        estimate = step(cloud)
        if not estimate.tracked:
            return estimates[first].pose
    return initialiser.pose


def facing_right(
    initialiser: PersonTracker,
    found: Pose,
    clouds: Sequence[Cloud],
    told: Callable[[], object] = lambda: None,
) -> Pose:
    """The pose, or the one that looks most alike from the other side if that is more natural.

    A body of average shape that faces the wrong way may explain the data better than one that
    faces the right way. With shapes of their own both explain them about as well, but the one
    that faces the wrong way then bends its knees and elbows as nobody can.

    Parameters
    ----------
    found : Pose
        In the first of the clouds.
    clouds : sequence of Cloud
        At least one.
    told : callable
        Called before every step; may raise :class:`Cancelled`.
    """
    away = turned_round(found)
    here = _gain_of_turning(initialiser, found, clouds[:_FITTED], told)
    there = _gain_of_turning(initialiser, away, clouds[:_FITTED], told)
    return away if here - there > 2.0 * _TURN_GAIN else found


def _gain_of_turning(
    initialiser: PersonTracker, pose: Pose, clouds: Sequence[Cloud], told: Callable[[], object]
) -> float:
    """How much more natural the other way round is, for a body fitted to this way of facing."""
    setup = initialiser.setup
    follower = initialiser.finder.follower(pose)
    poses = []
    for cloud in clouds:
        told()
        poses.append(follower.step(cloud).pose)
    pairs = list(zip(clouds, poses, strict=True))[len(clouds) > 1 :: 2]
    seen = [
        SeenPose(initialiser.leader.correspondences.choose(c), pose, upright=setup.upright)
        for c, pose in pairs
    ]
    body, fitted = fitted_surface(setup.body, seen, setup.parameters, setup.joints)
    judge = PoseFinder(replace(setup, body=body))
    gains = [judge.gain_of_turning(p, c) for p, (c, _) in zip(fitted, pairs, strict=True)]
    return float(np.mean(gains))


def _explains_as_well(
    initialiser: PersonTracker,
    usual: Pose,
    clouds: Sequence[Cloud],
    found: Sequence[Estimate],
    step: _Steps,
) -> bool:
    """Whether following from the usual pose costs no more than what was found, or little more."""
    initialiser.start(usual)
    more = []
    for cloud, other in zip(clouds, found, strict=True):
        estimate = step(cloud)
        if not estimate.tracked:
            return False
        if estimate.pose.torso[:, 1] @ usual.torso[:, 1] < 0.0:
            return False  # following has turned it round
        if other.tracked:
            cost = initialiser.finder.cost
            here, there = cost(estimate.pose, cloud), cost(other.pose, cloud)
            more.append(here - there)
    forward = [other.pose.torso[:, 1] @ usual.torso[:, 1] for other in found if other.tracked]
    turned_away = min(forward) < 0.0
    return float(np.mean(more)) < (_UNUSUAL if turned_away else _BETTER)
