"""Poses of somebody of whom nothing is known, and how much speaks against each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TypeVar

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import ARM_PARTS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import angle_between, vector_from_rotation
from stereotrack_core.tracking.arm_search.arms import arm_of_pose
from stereotrack_core.tracking.arm_search.score import anatomy_cost
from stereotrack_core.tracking.arm_search.search import ArmSearch, Evidence
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.initialise.people import people_in
from stereotrack_core.tracking.initialise.seeds import seeds_in, upright_pose
from stereotrack_core.tracking.initialise.trunk import (
    facing_cost,
    trunk_sight_cost,
    turned_round,
    unexplained_by_trunk,
)
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.residuals.surface import surface_distances, unexplained_fraction
from stereotrack_core.tracking.state import Setup, State

_ALL_DATA = 450.0  # weight of all data against the search's cost of those near the shoulders
_COARSE_DATA = 300  # data that seeds are judged by
_FINE_DATA = 600  # data that the best of them are followed with
_TRIED = 10  # seeds that are followed
_SEARCHED = 5  # those of them whose arms are looked for
_REPEATED = 2  # those whose arms are looked for again
_PAIRS = 4  # pairs of arms that differ and are refined
_FAR = np.radians(40.0)  # angle from which two limbs are taken to be in different places
_NATURAL_ARMS = 3.0  # factor on what speaks against the anatomy of arms, as in the search for them
TURN_GAIN = 3.0  # cost by which a pose must be more natural the other way round to be turned
_KEYPOINTS = 25.0  # weight of the keypoints' cost: 0.5 and more for a pose the other way round
by_cost = attrgetter("cost")  # what speaks against a candidate
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose on trial."""

    state: State  # state of the filter that follows it
    before: State  # the same before its last step; equal to `state` before the first
    cost: float  # sum of costs over the frames so far

    @property
    def pose(self) -> Pose:
        """Pose that is on trial."""
        return self.state.pose


class PoseFinder:
    """Finds poses in single clouds, and compares poses by how well they explain one.

    Its `follower` is a filter of the same body, without colours and detections between frames.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self._arms = ArmSearch(setup.body, setup.parameters, free=True)
        self.follower = Follower(setup, judges=False)

    def poses_in(self, cloud: Cloud, last: Pose) -> list[Candidate]:
        """Find poses of everybody in a cloud that differ, best first."""
        points = self.setup.upright.points(cloud.points)
        people = people_in(points, self.setup.parameters.least_points)
        return distinct(
            [found for members in people for found in self.poses_of(cloud.part(members), last)]
        )

    def poses_of(self, cloud: Cloud, last: Pose) -> list[Candidate]:
        """Find poses of the one person in a cloud, from coarse to fine."""
        coarse = _thinned(cloud.points, _COARSE_DATA)
        data = _thinned(cloud.points, _FINE_DATA)
        fine = Measurements(self.setup, cloud, data)
        seeds = [last, *seeds_in(self.setup.body, cloud.points, self.setup.upright)]
        tried = _spread(self._ranked(cloud, coarse, seeds), _TRIED, trunks_differ)
        followed = [self._followed(pose, fine) for pose in tried]
        spread = _spread(self._ranked(cloud, coarse, followed), _SEARCHED, trunks_differ)
        found = sorted((self._with_arms(pose, fine) for pose in spread), key=by_cost)
        return found + [self._with_arms(each.pose, fine) for each in found[:_REPEATED]]

    def cost(self, pose: Pose, cloud: Cloud) -> float:
        """What speaks against a pose in a cloud."""
        rng = np.random.default_rng((self.setup.seed, cloud.frame, 2))
        return self._cost_at(pose, cloud, self._arms.evidence(cloud, pose, rng))

    def gain_of_turning(self, pose: Pose, cloud: Cloud) -> float:
        """How much more natural a pose is the other way round; negative where it is less."""
        return self._unnatural(pose, cloud) - self._unnatural(turned_round(pose), cloud)

    def _ranked(self, cloud: Cloud, data: FloatArray, poses: Sequence[Pose]) -> list[Pose]:
        """Poses by what speaks against their trunks, least first."""
        body, facing = self.setup.body, [self._facing_cost(pose, cloud) for pose in poses]
        unexplained = unexplained_by_trunk(data, body, poses)
        cost = _ALL_DATA * unexplained + trunk_sight_cost(cloud, body, poses) + facing
        return [poses[k] for k in np.argsort(cost, kind="stable")]

    def _facing_cost(self, pose: Pose, cloud: Cloud) -> float:
        """What speaks against the way a pose faces, without keypoints."""
        body, upright = self.setup.body, self.setup.upright
        points, cameras = upright.points(cloud.points), upright.points(self.setup.cameras)
        return facing_cost(body, upright_pose(pose, upright), points, cameras)

    def _heading_cost(self, pose: Pose, cloud: Cloud) -> float:
        """What speaks against the way a pose faces; keypoints tell left from right."""
        cost, sigma = self._facing_cost(pose, cloud), self.setup.parameters.keypoint_sigma
        fit = KeypointObservation(cloud.keypoints, sigma).fitted(self.setup.body, pose)
        return cost if fit is None else cost + _KEYPOINTS * fit.independence * fit.cost()

    def _followed(self, pose: Pose, measured: Measurements) -> Pose:
        start = self.setup.first_state(pose)
        return self.follower.follow(measured, start, start)[1].pose

    def _with_arms(self, pose: Pose, measured: Measurements) -> Candidate:
        """Look for the arms of a body whose trunk is where a pose has it."""
        cloud, P = measured.cloud, self.setup.first_state(pose).P
        rng = measured.random(1)
        evidence = self._arms.evidence(cloud, pose, rng)
        best, least = pose, self._cost_at(pose, cloud, evidence)
        pairs = self._arms.best_pairs(evidence, pose, pose, rng)
        for proposed in _spread(pairs, _PAIRS, _arms_differ):
            refined = self.follower.refine(measured, proposed, P).pose
            cost = self._cost_at(refined, cloud, evidence)
            if cost < least:
                best, least = refined, cost
        found = self._followed(best, measured)
        if self.gain_of_turning(found, cloud) > TURN_GAIN:
            found = turned_round(found)
        state = self.follower.first(found, cloud.frame)
        return Candidate(state, state, self.cost(found, cloud))

    def arms_cost(self, pose: Pose) -> float:
        """What speaks against the anatomy of both arms of a pose."""
        body = self.setup.body
        frames = body.frames(pose)
        shapes = self._arms.placed_shapes(frames)
        arms = [anatomy_cost(body, s, arm_of_pose(frames, s.side))[0] for s in shapes]
        return float(np.sum(arms))

    def _unnatural(self, pose: Pose, cloud: Cloud) -> float:
        return _NATURAL_ARMS * self.arms_cost(pose) + self._heading_cost(pose, cloud)

    def _cost_at(self, pose: Pose, cloud: Cloud, evidence: Evidence) -> float:
        body = self.setup.body
        data = _thinned(cloud.points, self.setup.parameters.data_points)
        return float(
            self._arms.cost(evidence, pose, pose)
            + _ALL_DATA * unexplained_fraction(surface_distances(data, body, pose))
            + trunk_sight_cost(cloud, body, [pose])[0]
            + self._heading_cost(pose, cloud)
        )


def distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of all candidates whose poses are nearly the same, best first."""
    best = sorted(candidates, key=by_cost)
    return _spread(best, len(best), lambda one, other: differ(one.pose, other.pose))


def differ(a: Pose, b: Pose) -> bool:
    """Whether two poses differ by more than following would make up for."""
    return trunks_differ(a, b) or _arms_differ(a, b)


def _thinned(points: FloatArray, count: int) -> FloatArray:
    return points[:: max(1, len(points) // count)]


def _spread(found: Sequence[_T], count: int, differ: Callable[[_T, _T], bool]) -> list[_T]:
    """The first ones that differ from each other."""
    result: list[_T] = []
    for one in found:
        if all(differ(one, other) for other in result):
            result.append(one)
        if len(result) == count:
            break
    return result


def trunks_differ(a: Pose, b: Pose) -> bool:
    """Whether two poses differ by more than 20 degrees or 15 cm of the trunk."""
    turn = float(np.linalg.norm(vector_from_rotation(a.torso @ b.torso.T)))
    return turn > np.radians(20.0) or float(np.linalg.norm(a.position - b.position)) > 0.15


def _arms_differ(a: Pose, b: Pose) -> bool:
    return bool(
        np.max(angle_between(a.rotations[ARM_PARTS, :, 2], b.rotations[ARM_PARTS, :, 2])) > _FAR
    )
