"""Records one step of a tracker while it is done; what is recorded changes nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, state_names
from stereotrack_core.body.manifold import (
    DETECTION,
    ELBOW,
    KINDS,
    PIXEL,
    REST_ROW,
    difference,
    displaced,
    error_names,
    jacobian,
)
from stereotrack_core.body.manifold import Rows as LinearRows
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.sampling import SurfacePoints
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    arm_of_pose,
    directions,
    with_arm,
)
from stereotrack_core.tracking.arm_search.search import ArmSearch, Evidence
from stereotrack_core.tracking.estimate import Correspondences, Estimate, Projection
from stereotrack_core.tracking.residuals.surface import SurfaceResidual
from stereotrack_core.tracking.state import Belief, Setup
from stereotrack_core.tracking.thesis_collisions import Jump
from stereotrack_core.tracking.trace import (
    HIDDEN,
    INSIDE,
    ON_PARTNER,
    SURPLUS,
    TOO_FAR,
    Correction,
    Pair,
    Proposals,
    Rows,
    Search,
    SigmaPoints,
    StepTrace,
    TrueArms,
    Unused,
    movement,
)

_REINITIALISED = (
    "The previous frame was not tracked, so the pose was re-initialised. The steps start from the "
    "pose found."
)
_OTHER_POSE = (
    "An alternative pose became the best one in this frame because it explains the last frames "
    "better. The steps start from it."
)
_INFLATED = (
    "The data moved the body farther than expected, so the frame was tracked a second time with "
    "prior inflation."
)

_UNITS = {REST_ROW: "rad", ELBOW: "rad", PIXEL: "px"}  # of the kinds of rows not in metres


class StepRecorder:
    """Is told by a tracker, from its `start`, what its step does; nothing given may be changed.

    True landmarks (9, 3), if they are known, are only recorded; the tracker never sees them.
    """

    def __init__(self, setup: Setup, start: Belief, truth: FloatArray | None = None) -> None:
        self._setup, self._truth = setup, truth
        self._before = self._predicted = start
        self._notes: list[str] = []
        self._seconds: dict[str, float] = {}
        self._predictions = 0
        self._thesis = setup.joints == THESIS_JOINTS
        self._begin()
        self._mark = perf_counter()

    def _begin(self) -> None:
        self._corrections: list[Correction] = []
        self._measured: list[Correspondences] = []
        self._proposals: list[Proposals] = []
        self._searching: tuple[ArmSearch, Evidence, Pose, Callable[[Pose], Pose]] | None = None
        self._search: Search | None = None
        self._jump: Jump | None = None
        self._data = np.empty((0, 3))
        self._drawn: list[tuple[SurfacePoints, BoolArray, BoolArray]] = []

    def trace(self, frame: int, estimate: Estimate) -> StepTrace:
        """What the step did, whose result was the estimate."""
        self._lap("judge")
        method = self._setup.parameters.estimator
        method = "manifold" if method == "iterated" else method
        joints = self._setup.joints
        return StepTrace(
            frame=frame,
            method="thesis" if self._thesis else method,
            body=self._setup.body,
            state_names=state_names(joints) if self._thesis else error_names(joints),
            before=self._before,
            predicted=self._predicted,
            after=Belief(estimate.pose, estimate.P),
            corrections=tuple(self._corrections),
            estimate=estimate,
            measured=tuple(self._measured) if not self._corrections else (),
            search=self._search,
            jump=self._jump,
            notes=tuple(self._notes),
            seconds=self._seconds,
        )

    def reinitialised(self) -> None:
        """Somebody was looked for without help, and found."""
        self._notes.append(_REINITIALISED)
        self._lap("initialise pose")

    def predicted(self, before: Belief, predicted: Belief) -> None:
        """The frame's prediction stands; where it is not the first, another pose leads now."""
        self._predictions += 1
        if self._predictions > 1:
            self._begin()
            self._notes.append(_OTHER_POSE)
        self._before, self._predicted = before, predicted
        self._lap("predict")

    def corresponded(self, data: FloatArray, surface: SurfaceResidual) -> None:
        """Data (N, 3 or more) have found their closest points on the model, where near."""
        self._data = data
        self._measured = [*self._measured[:1], surface.pairs()]
        self._lap("arm search" if self._searching else "find correspondences")

    def corrected(
        self,
        prior: Belief,
        at: Belief,
        after: Belief,
        dx: FloatArray,
        surface: SurfaceResidual,
        sources: Sequence[LinearRows],
    ) -> None:
        """A prior was corrected by (n,); the first of the rows are the surface's."""
        if self._searching is not None:
            self._lap("arm search")
            return
        stage = "follow" if prior is self._predicted else "again"
        if stage == "again" and _INFLATED not in self._notes:
            self._notes.append(_INFLATED)
        places = np.ascontiguousarray(self._data[:, :3])
        far = places[~_is_among(places, surface.data)]
        nowhere = np.full((2, len(far)), [[-1], [TOO_FAR]])
        setup, own, beside = self._setup, sources[0], np.concatenate(sources[1:])
        frames, R = setup.body.frames(at.pose), own["variance"]
        H, H_beside = (jacobian(rows, frames, setup.columns) for rows in (own, beside))
        P_xz = at.P @ H.T
        dX = sigma_deviations(at.P, setup.weights)
        from_prior = difference(prior.pose, at.pose, setup.joints)
        self._add(
            Correction(
                stage=stage,
                iteration=1,
                prior=prior,
                before=at,
                sigma_points=SigmaPoints(dX, displaced(at.pose, dX, setup.joints)),
                points=replace(surface.pairs(), residual=own["innovation"], sigma=np.sqrt(R)),
                unused=Unused(far, *nowhere),
                rows=_rows(beside, H_beside, after.P),
                P_xz=P_xz,
                P_zz=np.einsum("mn,nm->m", H, P_xz),
                gain=after.P @ (H.T / R),
                dx=dx,
                from_prior=after.P @ np.linalg.solve(prior.P, from_prior),
                after=after,
            )
        )
        self._lap("correct")

    def searching(
        self, search: ArmSearch, evidence: Evidence, expected: Pose, refine: Callable[[Pose], Pose]
    ) -> None:
        """Other places for the arms are about to be looked for; `refine` corrects a place."""
        self._searching = search, evidence, expected, refine
        self._lap("arm search")

    def proposed(
        self, side: int, arms: Arms, kept: Arms, expected: Arms, other: FloatArray
    ) -> None:
        """Places for one arm were scored, the other one being so far (N,) from the data."""
        self._lap("arm search")
        if self._searching is not None:
            search, evidence = self._searching[:2]
            terms = search.arm_terms(evidence, side, arms, expected, other)
            chosen = _is_among(*(np.hstack([each.upper, each.fore]) for each in (arms, kept)))
            self._proposals.append(Proposals(side, arms.upper, arms.fore, terms, chosen))
            self._mark = perf_counter()

    def searched(self, followed: Pose, tried: Sequence[tuple[Pose, Pose]], best: Pose) -> None:
        """The search has decided among pairs of places before and after they were refined."""
        self._lap("arm search")
        if self._searching is None:
            return
        search, evidence, expected, refine = self._searching

        def pair(before: Pose, pose: Pose) -> Pair:
            terms = search.terms(evidence, expected, pose)
            return Pair(before, pose, terms, sum(terms.values()), pose is best)

        truth, true = None, _with_true_arms(self._setup.body, followed, self._truth)
        if true is not None:
            frames = self._setup.body.frames(true)
            left, right = (arm_of_pose(frames, side) for side in (LEFT, RIGHT))
            truth = TrueArms(
                given=pair(true, true),
                refined=pair(true, refine(true)),
                upper=np.concatenate([left.upper, right.upper]),
                fore=np.concatenate([left.fore, right.fore]),
                off=movement(self._setup.body, true, best).limbs[2:],
                points=search.points_on(evidence, true),
                measured=len(evidence.points),
            )
        self._search = Search(
            followed=pair(followed, followed),
            pairs=tuple(pair(*poses) for poses in tried),
            proposals=tuple(self._proposals),
            gain=evidence.gain,
            seconds=self._seconds["arm search"],
            truth=truth,
        )
        self._searching, self._mark = None, perf_counter()

    def sampled(self, points: SurfacePoints, inside: BoolArray, seen: BoolArray) -> None:
        """Points (N,) were drawn from the cones; those that are seen and not inside one stay."""
        if self._setup.parameters.sampling == "regular":
            self._drawn.clear()  # the pattern is drawn anew until it is dense enough
        self._drawn.append((points, inside, seen))

    def paired(self) -> None:
        """Sampled model points have found their nearest measured points."""
        self._lap("sample and pair")

    def unscented(
        self,
        before: Belief,
        after: Belief,
        dx: FloatArray,
        pairs: Projection,
        sigma_points: SigmaPoints,
        Y: FloatArray,
    ) -> None:
        """A state was corrected by (n,), by sigma points whose images are Y (2n + 1, m)."""
        self._lap("correct")
        order, weights = np.argsort(pairs.sampled.part, kind="stable"), self._setup.weights
        z_hat, dX, Wc = weights.mean @ Y, sigma_points.deviations, weights.covariance
        dY, nu = (Y - z_hat)[:, order], (pairs.z - z_hat)[order]
        R = np.full(len(nu), self._setup.parameters.sigma_measurement**2)
        frames = self._setup.body.frames(before.pose)
        self._add(
            Correction(
                stage="follow",
                iteration=1,
                prior=before,
                before=before,
                sigma_points=sigma_points,
                points=Correspondences(
                    pairs.sampled.part[order],
                    pairs.measured[order],
                    pairs.predicted[order],
                    pairs.e[order],
                    nu,
                    np.sqrt(R),
                    np.ones(len(order)),
                ),
                unused=_unused(self._drawn, pairs, frames),
                rows=(),
                P_xz=(dX.T * Wc) @ dY,
                P_zz=Wc @ dY**2,
                gain=_gain(dX, dY, Wc, R),
                dx=dx,
                from_prior=np.zeros(len(dx)),
                after=after,
            )
        )
        self._drawn = []
        self._mark = perf_counter()

    def avoided(self, jump: Jump) -> None:
        """Collisions were avoided."""
        self._lap("collisions")
        self._jump = jump

    def _lap(self, step: str) -> None:
        """Count the time since the last one for a step."""
        now = perf_counter()
        self._seconds[step] = self._seconds.get(step, 0.0) + now - self._mark
        self._mark = now

    def _add(self, correction: Correction) -> None:
        count = 1 + sum(each.stage == correction.stage for each in self._corrections)
        self._corrections.append(replace(correction, iteration=count))


def _with_true_arms(body: BodyModel, pose: Pose, truth: FloatArray | None) -> Pose | None:
    """A pose with its arms as true landmarks (9, 3) have them; None if they know neither arm."""
    if truth is None:
        return None
    true, torso = pose, body.frames(pose).rotations[TORSO]
    for side, name in ((LEFT, "left"), (RIGHT, "right")):
        places = truth[[LANDMARKS.index(f"{name}_{at}") for at in ("shoulder", "elbow", "hand")]]
        upper, fore = directions(np.diff(places, axis=0)) @ torso
        if np.isfinite(places).all():
            true = with_arm(true, side, upper, fore)
    return None if true is pose else true


def _is_among(rows: FloatArray, others: FloatArray) -> BoolArray:
    """Which rows (N, k) are, to the last bit, among others (M, k)."""
    kind = np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))
    a, b = (np.ascontiguousarray(each).view(kind).ravel() for each in (rows, others))
    return np.isin(a, b)


def _gain(dX: FloatArray, dY: FloatArray, Wc: FloatArray, R: FloatArray) -> FloatArray:
    """Kalman gain (n, m), equal to P_xz (P_zz + R)^-1; see :func:`filtering.correction.correct`."""
    V = dY / R
    M = np.eye(len(Wc)) + (V @ dY.T) * Wc
    return (dX.T * Wc) @ np.linalg.solve(M, V)


def _unused(
    drawn: Sequence[tuple[SurfacePoints, BoolArray, BoolArray]],
    pairs: Projection,
    frames: PartFrames,
) -> Unused:
    """Candidates that were not used, and why; the same one may have been drawn more than once."""
    if not drawn:
        return Unused(np.empty((0, 3)), *(np.empty(0, dtype=np.int64) for _ in range(2)))
    points, why = [], []
    for candidates, inside, seen in drawn:
        reason = np.where(inside, INSIDE, np.where(seen, SURPLUS, HIDDEN))
        reason[_is_among(_keys(candidates), _keys(pairs.drawn))] = ON_PARTNER
        reason[_is_among(_keys(candidates), _keys(pairs.sampled))] = -1
        left = reason >= 0
        points.append(candidates[left])
        why.append(reason[left].astype(np.int64))
    places = np.concatenate([frames.apply(each.part, each.points) for each in points])
    part: IntArray = np.concatenate([each.part for each in points])
    return Unused(places, part, np.concatenate(why))


def _keys(points: SurfacePoints) -> FloatArray:
    return np.column_stack([points.cone.astype(np.float64), points.points])


def _rows(rows: LinearRows, H: FloatArray, P: FloatArray) -> tuple[Rows, ...]:
    """Rows by kind; `P` is the covariance after the correction."""
    found = []
    for kind in dict.fromkeys(rows["kind"].tolist()):
        own = rows["kind"] == kind
        nu, R = rows["innovation"][own], rows["variance"][own]
        dx = P @ (H[own].T @ (nu / R))
        name = KINDS[DETECTION if kind == PIXEL else kind]
        found.append(Rows(name, rows["part"][own], nu, np.sqrt(R), _UNITS.get(kind, "m"), dx))
    return tuple(found)
