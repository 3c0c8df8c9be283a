"""Find the body without help, say when it is not there, and find it again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.rotation import angle_between, vector_from_rotation
from stereotrack_core.tracking.confidence import surface_distances, unexplained_fraction
from stereotrack_core.tracking.estimate import Estimate, Memory
from stereotrack_core.tracking.manifold_tracker import ManifoldTracker
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.search.arms import arm_of_pose
from stereotrack_core.tracking.search.score import Scene, anatomy_cost
from stereotrack_core.tracking.search.search import Evidence
from stereotrack_core.tracking.seeking.arms import FreeArmSearch
from stereotrack_core.tracking.seeking.facing import facing_cost, turned_round
from stereotrack_core.tracking.seeking.people import own_points, people_in
from stereotrack_core.tracking.seeking.seeds import seeds_in
from stereotrack_core.tracking.seeking.support import share_at_sides, trunk_support
from stereotrack_core.tracking.seeking.trunk import trunk_sight_cost, unexplained_by_trunk

_ALL_DATA = 450.0
"""Weight of all data against the search's cost, which counts those near the shoulders."""

_COARSE_DATA, _FINE_DATA = 300, 600
"""Data that seeds are judged by, and that the best of them are followed with."""

_TRIED, _SEARCHED, _REPEATED = 10, 5, 2
"""Seeds that are followed, those of them whose arms are looked for, and those whose arms are
looked for again."""

_PAIRS = 4
"""Pairs of arms that differ and are refined."""

_FAR = np.radians(40.0)
"""Angle from which two limbs are taken to be in different places."""

_RIVALS = 3
"""Poses besides the best that are kept on trial."""

_RIVAL = "rival"
"""Begins the names of a rival's numbers in the memory."""

_SETTLED = 12
"""Frames after which a pose that no rival has replaced is settled on."""

_LOOK_AGAIN = (2, 4, 7, 11)
"""Frames after the first in which better poses are looked for."""

_MEMORY = 0.8
"""Share of the sum of earlier costs that still counts."""

_HOPELESS, _BETTER = 40.0, 6.0
"""Costs by which a pose on trial must be worse to be given up, and better to be taken."""

_NATURAL_ARMS = 3.0
"""Factor on what speaks against the anatomy of arms, as in the search for them."""

_TURN_GAIN = 3.0
"""Cost by which a pose must be more natural the other way round to be turned."""

_ENOUGH_DOUBT, _MOST_TRUST = 60.0, 200.0
"""Sum of such costs over frames from which a settled pose is turned round, and the most that
earlier frames can weigh against it."""

_LEAST_SUPPORT, _WHOLE = 0.55, 0.9
"""Shares of the trunk's patches without which too little of the body is there, and with which it
is there as a whole."""

_CUT, _HALF_CUT = 0.035, 0.15
"""Shares of the points at the sides of the volume from which a body is cut by them that is not
seen as a whole, and any body."""

_DOUBT = 0.2
"""Factor on these shares while a pose is on trial."""


@dataclass(eq=False)
class _Candidate:
    """A pose on trial: who follows it, and the sum of what speaks against it."""

    tracker: ManifoldTracker
    cost: float


class SeekingTracker(ManifoldTracker):
    """Follow the body, and look for it wherever it was not there a frame before.

    What is found may be mistaken, above all front for back. So other poses that explain the
    first cloud nearly as well are followed beside the best one for some frames, until the sum of
    their costs tells which is right.

    Parameters are those of :class:`ManifoldTracker`.

    Attributes
    ----------
    volume : Volume or None
        Working volume, where it is known: who is cut by its sides is not tracked.
    """

    def __init__(
        self,
        body: BodyModel,
        parameters: TrackingParameters,
        cameras: FloatArray,
        fps: float,
        seed: int,
    ) -> None:
        self._made_from = (body, parameters, cameras, fps, seed)
        self.volume: Volume | None = None
        self._arms = FreeArmSearch(body, parameters.search, parameters.arms_apart)
        super().__init__(body, parameters, cameras, fps, seed)

    def start(self, pose: Pose, time: float | None = None) -> None:
        """Begin from a pose that is roughly right; see :class:`ManifoldTracker`."""
        super().start(pose, time)
        self._present = True
        self._age, self._unchanged = 0, _SETTLED
        self._cost = self._doubt = 0.0
        self._rivals: list[_Candidate] = []

    def with_body(self, body: BodyModel) -> SeekingTracker:
        """The same tracker for another body, before its first cloud."""
        other = SeekingTracker(body, *self._made_from[1:])
        other.volume = self.volume
        return other

    def seek(self) -> None:
        """Know nothing: the next cloud that shows somebody is searched."""
        self.start(self.pose)
        self._present = False

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud; look for the body first where it was lost."""
        before = self.state
        if len(cloud.points) >= self.parameters.least_points:
            if not self._present:
                self._begin(cloud)
            cloud = cloud.part(own_points(cloud.points, self.body, self.pose))
        estimate = super().step(cloud)
        if estimate.tracked and self._unchanged < _SETTLED:
            estimate = self._on_trial(cloud, estimate)
        elif estimate.tracked:
            estimate = self._watched(cloud, estimate)
        if estimate.tracked:
            reason = self._why_partial(cloud)
            if reason:
                estimate = self.lost(before, cloud, reason)
        if not estimate.tracked:
            self.seek()
        return estimate

    def memory(self) -> Memory:
        """All that the next step depends on, the rivals on trial too."""
        kept = {**super().memory(), "trial": self._trial()}
        for k, rival in enumerate(self._rivals):
            own = {**rival.tracker.memory(), "cost": np.array(rival.cost)}
            kept |= {f"{_RIVAL}{k}.{name}": array for name, array in own.items()}
        return kept

    def _trial(self) -> FloatArray:
        """The numbers (5,) of what is on trial."""
        return np.array([self._present, self._age, self._unchanged, self._cost, self._doubt], float)

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        super().recall(memory)
        present, age, unchanged, self._cost, self._doubt = memory["trial"].tolist()
        self._present, self._age, self._unchanged = bool(present), int(age), int(unchanged)
        for k in range(sum(name.endswith(".cost") for name in memory)):
            first = f"{_RIVAL}{k}."
            own = {n.removeprefix(first): a for n, a in memory.items() if n.startswith(first)}
            twin = self.twin(self.pose)
            twin.recall(own)
            self._rivals.append(_Candidate(twin, float(own["cost"])))

    def _why_partial(self, cloud: Cloud) -> str:
        """Say why too little of the body is there to tell its pose; empty where there is enough."""
        support = trunk_support(self.body, self.pose, cloud.points, self.cameras)
        if support < _LEAST_SUPPORT:
            return "too little of the body is in the cloud"
        cut = 0.0 if self.volume is None else share_at_sides(cloud.points, self.volume)
        doubt = _DOUBT if self._unchanged < _SETTLED else 1.0
        if cut > doubt * _HALF_CUT or (support < _WHOLE and cut > doubt * _CUT):
            return "the body is partly outside of the working volume"
        return ""

    def _begin(self, cloud: Cloud) -> None:
        """Start from the pose that explains somebody in the cloud best; keep its rivals."""
        found = [
            candidate
            for members in people_in(cloud.points, self.parameters.least_points)
            for candidate in self._poses_of(cloud.part(members), self.pose)
        ]
        if found:
            best, *others = _distinct(sorted(found, key=_by_cost))
            self.start(best.tracker.pose, cloud.frame)
            self.observer.sought(self.pose)
            self._cost, self._unchanged = best.cost, 0
            self._rivals = others[:_RIVALS]

    def _on_trial(self, cloud: Cloud, estimate: Estimate) -> Estimate:
        """Follow the rivals as well, and now and then look for better ones.

        Whoever appears at the edge of the volume is found while there is little of the body, so
        that what was found first may be wrong in a way that following does not mend.
        """
        self._age += 1
        self._cost = _MEMORY * self._cost + self.cost(self.pose, cloud)
        kept = []
        for rival in self._rivals:
            if rival.tracker.step(cloud).tracked:
                self._turn_if_natural(rival.tracker, cloud)
                rival.cost = _MEMORY * rival.cost + self.cost(rival.tracker.pose, cloud)
                kept.append(rival)
        if self._age in _LOOK_AGAIN:
            memory = sum(_MEMORY**k for k in range(self._age + 1))
            for candidate in self._poses_of(cloud, self.pose):
                candidate.cost *= memory
                kept.append(candidate)
        best = min(kept, key=_by_cost, default=None)
        self._unchanged += 1
        if best is not None and best.cost < self._cost - _BETTER:
            kept.remove(best)
            kept.append(self._exchanged(best))
            self._unchanged = 0
            estimate = self._estimate_anew(cloud)
        hopeful = [rival for rival in kept if rival.cost < self._cost + _HOPELESS]
        hopeful = [rival for rival in hopeful if _differ(rival.tracker.pose, self.pose)]
        self._rivals = _distinct(sorted(hopeful, key=_by_cost))[:_RIVALS]
        return estimate

    def _watched(self, cloud: Cloud, estimate: Estimate) -> Estimate:
        """Turn round where frame after frame has said that the body faces the other way.

        The evidence is added up as in Page's test (doi:10.1093/biomet/41.1-2.100), but what has
        spoken for the pose before is remembered up to a limit.
        """
        gain = self.gain_of_turning(self.pose, cloud)
        self._doubt = max(-_MOST_TRUST, self._doubt + gain - _TURN_GAIN)
        if self._doubt > _ENOUGH_DOUBT:
            self.start(turned_round(self.pose), cloud.frame)
            estimate = self._estimate_anew(cloud)
        return estimate

    def _exchanged(self, rival: _Candidate) -> _Candidate:
        """Let a rival lead, from where it was before this frame; who led becomes the rival."""
        twin, cost = self.twin(self.pose), self._cost
        twin.resume(self.state)
        self.resume(rival.tracker.origin)
        self._cost = rival.cost
        return _Candidate(twin, cost)

    def _estimate_anew(self, cloud: Cloud) -> Estimate:
        """Estimate of the frame by the pose that leads now; no backward pass goes beyond it."""
        self._anew = True
        return super().step(cloud)

    def _poses_of(self, cloud: Cloud, last: Pose) -> list[_Candidate]:
        """Find poses of the one person in a cloud, from coarse to fine."""
        coarse = _thinned(cloud.points, _COARSE_DATA)
        fine = _thinned(cloud.points, _FINE_DATA)
        seeds = [last, *seeds_in(self.body, cloud.points)]
        order = np.argsort(self._coarse_cost(cloud, coarse, seeds), kind="stable")
        tried = _spread([seeds[k] for k in order], _TRIED, _trunks_differ)
        followed = [self._followed(pose, fine) for pose in tried]
        order = np.argsort(self._coarse_cost(cloud, coarse, followed), kind="stable")
        distinct = _spread([followed[k] for k in order], _SEARCHED, _trunks_differ)
        found = sorted((self._with_arms(pose, cloud, fine) for pose in distinct), key=_by_cost)
        best = found[:_REPEATED]
        return found + [self._with_arms(each.tracker.pose, cloud, fine) for each in best]

    def _coarse_cost(self, cloud: Cloud, data: FloatArray, poses: Sequence[Pose]) -> FloatArray:
        unexplained = unexplained_by_trunk(data, self.body, poses)
        facing = [facing_cost(self.body, pose, cloud.points, self.cameras) for pose in poses]
        return _ALL_DATA * unexplained + trunk_sight_cost(cloud, self.body, poses) + facing

    def _followed(self, pose: Pose, data: FloatArray) -> Pose:
        twin = self.twin(pose)
        twin.follow(data, twin.pose, twin.P)
        return twin.pose

    def _with_arms(self, pose: Pose, cloud: Cloud, data: FloatArray) -> _Candidate:
        """Look for the arms of a body whose trunk is where a pose has it."""
        twin = self.twin(pose)
        rng = np.random.default_rng((self._seed, cloud.frame, 1))
        evidence = self._arms.evidence(cloud, pose, rng)
        best, least = pose, self._cost_at(pose, cloud, evidence)
        pairs = [proposed for _, proposed in self._arms.best_pairs(evidence, pose, pose, rng)]
        for proposed in _spread(pairs, _PAIRS, _arms_differ):
            twin.refine(data, proposed, twin.P)
            cost = self._cost_at(twin.pose, cloud, evidence)
            if cost < least:
                best, least = twin.pose, cost
            twin.start(pose)
        twin.start(self._followed(best, data), cloud.frame)
        self._turn_if_natural(twin, cloud)
        return _Candidate(twin, self.cost(twin.pose, cloud))

    def _turn_if_natural(self, tracker: ManifoldTracker, cloud: Cloud) -> None:
        """Let a tracker go on from the other side's pose where that is clearly more natural."""
        if self.gain_of_turning(tracker.pose, cloud) > _TURN_GAIN:
            tracker.start(turned_round(tracker.pose), cloud.frame)

    def gain_of_turning(self, pose: Pose, cloud: Cloud) -> float:
        """How much more natural a pose is the other way round; negative where it is less."""
        return self._unnatural(pose, cloud) - self._unnatural(turned_round(pose), cloud)

    def _unnatural(self, pose: Pose, cloud: Cloud) -> float:
        frames = self.body.frames(pose)
        scene = Scene.of(cloud, self.body, frames)
        shapes = self._arms.placed_shapes(frames)
        arms = [anatomy_cost(scene, s, arm_of_pose(frames, s.side))[0] for s in shapes]
        return _NATURAL_ARMS * float(np.sum(arms)) + facing_cost(
            self.body, pose, cloud.points, self.cameras
        )

    def twin(self, pose: Pose) -> ManifoldTracker:
        """A tracker of the same body that only follows."""
        twin = ManifoldTracker(*self._made_from)
        twin.start(pose)
        return twin

    def cost(self, pose: Pose, cloud: Cloud) -> float:
        """What speaks against a pose in a cloud."""
        rng = np.random.default_rng((self._seed, cloud.frame, 2))
        return self._cost_at(pose, cloud, self._arms.evidence(cloud, pose, rng))

    def _cost_at(self, pose: Pose, cloud: Cloud, evidence: Evidence) -> float:
        data = _thinned(cloud.points, self.parameters.data_points)
        return float(
            self._arms.cost(evidence, pose, pose)
            + _ALL_DATA * unexplained_fraction(surface_distances(data, self.body, pose))
            + trunk_sight_cost(cloud, self.body, [pose])[0]
            + facing_cost(self.body, pose, cloud.points, self.cameras)
        )


def _distinct(candidates: Sequence[_Candidate]) -> list[_Candidate]:
    """The first of all candidates whose poses are nearly the same."""
    result: list[_Candidate] = []
    for candidate in candidates:
        if all(_differ(candidate.tracker.pose, other.tracker.pose) for other in result):
            result.append(candidate)
    return result


def _by_cost(candidate: _Candidate) -> float:
    return candidate.cost


def _thinned(points: FloatArray, count: int) -> FloatArray:
    return points[:: max(1, len(points) // count)]


def _spread(poses: Sequence[Pose], count: int, differ: Callable[[Pose, Pose], bool]) -> list[Pose]:
    """The first poses that differ from each other."""
    result: list[Pose] = []
    for pose in poses:
        if all(differ(pose, other) for other in result):
            result.append(pose)
        if len(result) == count:
            break
    return result


def _trunks_differ(a: Pose, b: Pose) -> bool:
    turn = float(np.linalg.norm(vector_from_rotation(a.torso @ b.torso.T)))
    return turn > np.radians(20.0) or float(np.linalg.norm(a.position - b.position)) > 0.15


def _arms_differ(a: Pose, b: Pose) -> bool:
    arms = [*UPPER_ARMS, *FOREARMS]
    return bool(np.max(angle_between(a.rotations[arms, :, 2], b.rotations[arms, :, 2])) > _FAR)


def _differ(a: Pose, b: Pose) -> bool:
    """Whether two poses differ by more than following would make up for."""
    return _trunks_differ(a, b) or _arms_differ(a, b)
