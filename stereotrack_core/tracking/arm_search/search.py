"""Propose arms, score both jointly, hand the best pairs on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    ArmShape,
    arm_of_pose,
    arm_shape,
    arms_around,
    joined,
    proposals,
    with_arm,
)
from stereotrack_core.tracking.arm_search.keypoints import ArmKeypoints, arm_keypoints
from stereotrack_core.tracking.arm_search.picture import SeenPicture, outline_cones, seen_pictures
from stereotrack_core.tracking.arm_search.score import (
    anatomy_cost,
    arm_distances,
    change_cost,
    crossing_cost,
    pair_sums,
)

if TYPE_CHECKING:
    from stereotrack_core.tracking.parameters import TrackingParameters

# Costs by which a pair must be better than the tracked arms. Keypoints and silhouettes alone hardly
# tell arms before the trunk: with 3, 32 % of the arms that cross are lost, with 8 6 %.
_GAIN, _GAIN_WITHOUT_RANGES = 3.0, 8.0
# Square of the metres at which a datum counts as half unexplained: less than an arm's radius, so
# that an arm on the torso is told from the torso.
_SQUARED_SCALE = 0.035**2
_UNEXPLAINED = 0.09  # metres from every cone beyond which a datum is unexplained
_MOST_DATA = 450  # points near the shoulders that arms are scored by
_KEPT = 8  # best candidates per arm of which all pairs are scored
_ON_LIMB = 0.05  # metres from a limb's surface up to which a datum may be measured on it
_PICTURE_STEP = 3  # every so many pixels are compared: arms are several of these wide
_UNLIKE = 0.5  # pixels by which a disparity is off that counts half (docs/silhouettes.md)
# Where nothing is expected of the arms:
_FREE_KEPT, _FREE_PAIRS = 10, 20  # best candidates per arm, and pairs that are handed on
_APART = np.radians(30.0)  # angle from which two places of an arm differ
_ANYWHERE = np.radians(90.0)  # spread of further candidates
_NATURAL = 3.0  # factor on what speaks against an arm's anatomy: no history could outweigh it


@dataclass(frozen=True, eq=False)
class Evidence:
    """Data that speak about the arms at one instant."""

    points: FloatArray  # (N, 3), torso's frame. Within reach of a shoulder.
    body_distance: FloatArray  # (N,), metres. From torso, head and legs.
    shapes: tuple[ArmShape, ArmShape]  # of the left and the right arm, from where the shoulders are
    frames: PartFrames  # of the present pose; proposals are in its torso's frame
    pictures: tuple[SeenPicture, ...]  # what the views saw, thinned out; none if not compared
    keypoints: tuple[ArmKeypoints, ArmKeypoints] | None = None  # of the left and the right arm
    gain: float = _GAIN  # a pair replaces the tracked arms if its cost is lower by more than this

    @cached_property
    def side_by_side(self) -> FloatArray:
        """The points' coordinates (3, N)."""
        return np.ascontiguousarray(self.points.T)


class ArmSearch:
    """Search for arms of one body.

    Of the arms of a body that has just been found nothing is expected: then it is `free`, the best
    places differ, and change costs nothing.
    """

    def __init__(
        self, body: BodyModel, parameters: TrackingParameters, *, free: bool = False
    ) -> None:
        self.body = body
        self._free = free
        self.parameters = parameters
        self._shapes = (arm_shape(body, LEFT), arm_shape(body, RIGHT))
        of_arm = [np.isin(body.cones["part"], [UPPER_ARMS[s], FOREARMS[s]]) for s in (LEFT, RIGHT)]
        self._arms = [replace(body, cones=body.cones[chosen]) for chosen in of_arm]
        self._trunk = replace(body, cones=body.cones[~(of_arm[LEFT] | of_arm[RIGHT])])
        self._reach = max(shape.reach for shape in self._shapes) + 0.1

    def evidence(self, cloud: Cloud, pose: Pose, rng: np.random.Generator) -> Evidence:
        """Choose the data near the shoulders and measure how the rest of the body explains them."""
        frames = self.body.frames(pose)
        torso = (cloud.points - frames.origins[TORSO]) @ frames.rotations[TORSO]
        shapes = self.placed_shapes(frames)
        off = [np.linalg.norm(torso - shape.shoulder, axis=1) for shape in shapes]
        near = np.flatnonzero(np.minimum(*off) < self._reach)
        if len(near) > _MOST_DATA:
            near = np.sort(rng.choice(near, _MOST_DATA, replace=False))
        closest = nearest_on_surface(cloud.points[near], placed_cones(self._trunk, frames), np.inf)
        return Evidence(
            np.ascontiguousarray(torso[near]),
            np.abs(closest.distance),
            shapes,
            frames,
            seen_pictures(cloud, _PICTURE_STEP) if self.parameters.picture_cost > 0.0 else (),
            arm_keypoints(cloud.keypoints, self.parameters.keypoint_sigma, self.body, pose),
            _GAIN if len(cloud.points) else _GAIN_WITHOUT_RANGES,
        )

    def best_pairs(
        self,
        evidence: Evidence,
        predicted: Pose,
        pose: Pose,
        rng: np.random.Generator,
        tell: Callable[[int, Arms, Arms, Arms, FloatArray], object] | None = None,
    ) -> list[Pose]:
        """Poses with the best pairs of arms, best first; the body stays as in `pose`.

        `tell` is told a side, its places, those kept, the expected one and how far the other is.
        """
        frames, before = self.body.frames(pose), self.body.frames(predicted)
        present = [arm_of_pose(frames, side) for side in (LEFT, RIGHT)]
        expected = [arm_of_pose(before, side) for side in (LEFT, RIGHT)]
        at_present = [self._distances(evidence, s, present[s.side])[0] for s in evidence.shapes]
        explained = np.minimum(evidence.body_distance, np.minimum(*at_present))
        unexplained = evidence.points[explained > _UNEXPLAINED]
        kept = []
        for shape in evidence.shapes:
            seen = None if evidence.keypoints is None else evidence.keypoints[shape.side]
            targets = unexplained[:0] if seen is None else seen.near_hand(evidence.points)
            proposed = proposals(
                shape,
                expected[shape.side],
                present[shape.side],
                targets if len(targets) else unexplained,
                self.parameters.search_proposals,
                rng,
            )
            shown = None if seen is None else seen.proposals(shape)
            proposed = proposed if shown is None else joined(proposed, shown)
            other = at_present[1 - shape.side]
            kept.append(self._best_of(evidence, shape, proposed, expected[shape.side], other))
            if tell is not None:
                tell(shape.side, proposed, kept[-1][0], expected[shape.side], other)
        return self._pairs(evidence, kept, pose)

    def cost(self, evidence: Evidence, predicted: Pose, pose: Pose) -> float:
        """Cost of one pose by the same measure, with the body where `pose` has it."""
        return sum(self.terms(evidence, predicted, pose).values())

    def terms(self, evidence: Evidence, predicted: Pose, pose: Pose) -> dict[str, float]:
        """Terms of :meth:`cost` by name."""
        frames, before = self.body.frames(pose), self.body.frames(predicted)
        arms = [arm_of_pose(frames, side) for side in (LEFT, RIGHT)]
        found = dict.fromkeys(("data", "keypoints", "anatomy", "change"), 0.0)
        nearest = evidence.body_distance
        for shape, arm in zip(evidence.shapes, arms, strict=True):
            expected = arm_of_pose(before, shape.side)
            for name, cost in self._own_terms(evidence, shape, arm, expected).items():
                found[name] += float(cost[0])
            nearest = np.minimum(nearest, self._distances(evidence, shape, arm)[0])
        squared = nearest**2
        found["data"] = float(np.sum(squared / (squared + _SQUARED_SCALE)))
        found["crossing"] = float(self._crossing(evidence, *arms)[0, 0])
        found["pictures"] = float(self._unlike(evidence, frames, frames, frames)[0, 0])
        return found

    def points_on(self, evidence: Evidence, pose: Pose) -> IntArray:
        """Numbers (4,) of data on each limb of the arms and not on the trunk, as ``LIMBS[2:]``."""
        frames, found = self.body.frames(pose), np.zeros((2, 2), dtype=np.int64)
        points = evidence.points[:, None]
        for shape in evidence.shapes:
            _, elbow, _, tip = shape.nodes(arm_of_pose(frames, shape.side))[0]
            for part, (start, end) in enumerate(((shape.shoulder, elbow), (elbow, tip))):
                away = segment_distance(points, points, start, end)[:, 0]
                away = np.abs(away - shape.radii[part].mean())
                on = (away < _ON_LIMB) & (away < evidence.body_distance)
                found[part, shape.side] = np.count_nonzero(on)
        return found.ravel()

    def arm_terms(
        self, evidence: Evidence, side: int, arms: Arms, expected: Arms, other: FloatArray
    ) -> dict[str, FloatArray]:
        """Costs (K,) of places of one arm by name; the other one is so far (N,) from the data."""
        shape = evidence.shapes[side]
        distances = self._distances(evidence, shape, arms)
        explained = pair_sums(evidence.body_distance, distances, other[None], _SQUARED_SCALE)
        return {"data": explained[:, 0], **self._own_terms(evidence, shape, arms, expected)}

    def _unlike(
        self, evidence: Evidence, frames: PartFrames, left: PartFrames, right: PartFrames
    ) -> FloatArray:
        """Cost (K, L) of what views should see of K left and L right arms and do not."""
        rest = outline_cones(self._trunk, frames)
        arms = [
            outline_cones(arm, posed).reshape(-1, len(arm.cones))
            for arm, posed in zip(self._arms, (left, right), strict=True)
        ]
        total: FloatArray = np.zeros((len(arms[LEFT]), len(arms[RIGHT])))
        for seen in evidence.pictures:
            pixels = seen.unlike(rest, arms[LEFT], arms[RIGHT], _UNLIKE)
            total += seen.area(frames.origins[TORSO]) * pixels
        return self.parameters.picture_cost * total

    def _best_of(
        self, evidence: Evidence, shape: ArmShape, arms: Arms, expected: Arms, other: FloatArray
    ) -> tuple[Arms, FloatArray, FloatArray]:
        """Best arms with their distances and own costs, with and without the other arm there."""
        if self._free:
            rng = np.random.default_rng((shape.side, len(arms)))
            arms = joined(arms, arms_around(arms[:1], len(arms), _ANYWHERE, _ANYWHERE, rng))
        distances = self._distances(evidence, shape, arms)
        own = sum(self._own_terms(evidence, shape, arms, expected).values(), np.zeros(len(arms)))
        chosen: dict[int, None] = {0: None}
        others = np.stack([np.full_like(other, np.inf), other])  # without and with the other arm
        explained = pair_sums(evidence.body_distance, distances, others, _SQUARED_SCALE)
        for cost in explained.T:
            order = np.argsort(own + cost, kind="stable")
            best = _apart(arms, order) if self._free else order[:_KEPT].tolist()
            chosen |= dict.fromkeys(best)
        index = list(chosen)
        return arms[index], distances[index], own[index]

    def _pairs(
        self, evidence: Evidence, kept: list[tuple[Arms, FloatArray, FloatArray]], pose: Pose
    ) -> list[Pose]:
        (left, left_distance, left_own), (right, right_distance, right_own) = kept
        apart = left_distance, right_distance
        cost: FloatArray = pair_sums(evidence.body_distance, *apart, _SQUARED_SCALE)
        cost += left_own[:, None] + right_own
        cost += self._crossing(evidence, left, right)
        if evidence.pictures:
            arms = ((LEFT, left), (RIGHT, right))
            poses = [with_arm(pose, side, arm.upper, arm.fore) for side, arm in arms]
            cost += self._unlike(evidence, *map(self.body.frames, (pose, *poses)))
        count = _FREE_PAIRS if self._free else self.parameters.search_refined
        best = np.argsort(cost, axis=None, kind="stable")[:count]
        k, m = np.unravel_index(best, cost.shape)
        moved = with_arm(pose, LEFT, left.upper[k], left.fore[k])
        moved = with_arm(moved, RIGHT, right.upper[m], right.fore[m])
        return [Pose(pose.position, rotations) for rotations in moved.rotations]

    def placed_shapes(self, frames: PartFrames) -> tuple[ArmShape, ArmShape]:
        """Shapes of both arms, from where the shoulders are in one pose."""
        away = frames.origins[list(UPPER_ARMS)] - frames.origins[TORSO]
        shoulders = away @ frames.rotations[TORSO]
        left, right = self._shapes
        return replace(left, shoulder=shoulders[LEFT]), replace(right, shoulder=shoulders[RIGHT])

    def _crossing(self, evidence: Evidence, left: Arms, right: Arms) -> FloatArray:
        nodes = evidence.shapes[LEFT].nodes(left), evidence.shapes[RIGHT].nodes(right)
        cost: FloatArray = crossing_cost(*nodes, self.parameters.arms_apart)
        return cost

    def _own_terms(
        self, evidence: Evidence, shape: ArmShape, arms: Arms, expected: Arms
    ) -> dict[str, FloatArray]:
        seen = np.zeros(len(arms))
        if evidence.keypoints is not None:
            seen = self.parameters.keypoint_cost * evidence.keypoints[shape.side].cost(shape, arms)
        natural = anatomy_cost(self.body, shape, arms)
        if self._free:
            return {"keypoints": seen, "anatomy": _NATURAL * natural}
        change = change_cost(expected.upper, expected.fore, arms.upper, arms.fore)
        return {"keypoints": seen, "anatomy": natural, "change": change}

    def _distances(self, evidence: Evidence, shape: ArmShape, arms: Arms) -> FloatArray:
        nodes = shape.nodes(arms)
        distances: FloatArray = arm_distances(evidence.side_by_side, nodes, shape.radii)
        return distances


def _apart(arms: Arms, order: IntArray) -> list[int]:
    """The first of the arms, in this order, that differ from each other."""
    chosen: list[int] = []
    free = np.ones(len(arms), dtype=np.bool_)
    for k in order:
        if free[k] and len(chosen) < _FREE_KEPT:
            chosen.append(int(k))
            upper = angle_between(arms.upper, arms.upper[k])
            fore = angle_between(arms.fore, arms.fore[k])
            free &= np.maximum(upper, fore) > _APART
    return chosen
