"""Corrections of the thesis's tracker and its collision avoidance, taken apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.sampling import SurfacePoints
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.collisions import Clearance, pushed_out
from stereotrack_core.tracking.inside.corrections import Place, is_among
from stereotrack_core.tracking.inside.events import CorrectedState, Paired, Sampled
from stereotrack_core.tracking.inside.trace import (
    HIDDEN,
    INSIDE,
    ON_PARTNER,
    SURPLUS,
    ArmJump,
    Correction,
    Jump,
    Points,
    SigmaPoints,
    Unused,
)
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.ukf import ThesisTracker


def belief_of(x: FloatArray, P: FloatArray) -> Belief:
    """The thesis's state as a belief."""
    return Belief(pose_of_state(x, THESIS_JOINTS), P)


def thesis_correction(
    tracker: ThesisTracker,
    before: tuple[FloatArray, FloatArray],
    drawn: Sequence[Sampled],
    told: Paired,
    done: CorrectedState,
    place: Place,
) -> Correction:
    """Take one correction apart.

    Parameters
    ----------
    tracker : ThesisTracker
    before : (n,) and (n, n) float64
        State and covariance.
    drawn : sequence of Sampled
        What was drawn from the cones for it.
    told, done
        What the tracker has said before and after.
    place : Place
    """
    (x, P), p, pairs = before, tracker.setup.parameters, told.pairs
    weights = scaled_weights(len(x), p.ut_alpha, p.ut_beta, p.ut_kappa)
    dX = sigma_deviations(P, weights)
    poses = pose_of_state(x + dX, THESIS_JOINTS)
    Y = pairs.z_hat(tracker.setup.body.frames(poses))
    z_hat = weights.mean @ Y
    order = np.argsort(pairs.sampled.part, kind="stable")
    dY = (Y - z_hat)[:, order]
    Wc, R = weights.covariance, np.full(len(order), p.sigma_measurement**2)
    belief = belief_of(x, P)
    return Correction(
        stage=place.stage,
        iteration=place.iteration,
        prior=belief,
        before=belief,
        sigma_points=SigmaPoints(dX, poses, True),
        points=Points(
            pairs.sampled.part[order],
            pairs.measured[order],
            pairs.predicted[order],
            pairs.e[order],
            (pairs.z - z_hat)[order],
            np.sqrt(R),
            np.ones(len(order)),
        ),
        unused=_unused(drawn, told, tracker.setup.body.frames(belief.pose)),
        rows=(),
        P_xz=(dX.T * Wc) @ dY,
        P_zz=Wc @ dY**2,
        gain=_gain(dX, dY, Wc, R),
        dx=done.x - x,
        from_prior=np.zeros(len(x)),
        after=belief_of(done.x, done.P),
        correspond_seconds=place.correspond_seconds,
        correct_seconds=place.correct_seconds,
    )


def _gain(dX: FloatArray, dY: FloatArray, Wc: FloatArray, R: FloatArray) -> FloatArray:
    """Kalman gain (n, m), equal to P_xz (P_zz + R)^-1; see :func:`filtering.correction.correct`."""
    V = dY / R
    M = np.eye(len(Wc)) + (V @ dY.T) * Wc
    result: FloatArray = (dX.T * Wc) @ np.linalg.solve(M, V)
    return result


def _unused(drawn: Sequence[Sampled], told: Paired, frames: PartFrames) -> Unused:
    """Candidates that were not used, and why; the same one may have been drawn more than once."""
    if not drawn:
        return Unused(np.empty((0, 3)), *(np.empty(0, dtype=np.int64) for _ in range(2)))
    points, why = [], []
    for one in drawn:
        reason = np.where(one.inside, INSIDE, np.where(one.seen, SURPLUS, HIDDEN))
        reason[is_among(_keys(one.points), _keys(told.sampled))] = ON_PARTNER
        reason[is_among(_keys(one.points), _keys(told.pairs.sampled))] = -1
        left = reason >= 0
        points.append(one.points[left])
        why.append(reason[left].astype(np.int64))
    places = np.concatenate([frames.apply(each.part, each.points) for each in points])
    part: IntArray = np.concatenate([each.part for each in points])
    return Unused(places, part, np.concatenate(why))


def _keys(points: SurfacePoints) -> FloatArray:
    return np.column_stack([points.cone.astype(np.float64), points.points])


def jump_of(body: BodyModel, before: Pose, after: Pose, clearance: Clearance) -> Jump:
    """Say what collision avoidance found and did."""
    arms = tuple(_arm_jump(body, before, after, side, clearance) for side in (0, 1))
    return Jump(before, after, arms, clearance.distance, clearance.elbow_angle)


def _arm_jump(
    body: BodyModel, before: Pose, after: Pose, side: int, clearance: Clearance
) -> ArmJump:
    upper, fore = UPPER_ARMS[side], FOREARMS[side]
    frames, moved = body.frames(before), body.frames(after)
    hand = frames.origins[fore] + body.skeleton.lengths[fore] * frames.rotations[fore, :, 2]
    along = before.rotations[fore, :, 2]
    bend = float(np.arccos(np.clip(along[2], -1.0, 1.0)))
    turned = angle_between(frames.rotations[..., 2], moved.rotations[..., 2])
    return ArmJump(
        side=side,
        elbow_missing=_missing(body, frames, frames.origins[fore], clearance.distance),
        hand_missing=_missing(body, frames, hand, clearance.distance),
        bend_missing=max(0.0, bend - (np.pi - clearance.elbow_angle)),
        upper_turn=float(turned[upper]),
        fore_turn=float(turned[fore]),
    )


def _missing(body: BodyModel, frames: PartFrames, point: FloatArray, least: float) -> float:
    local = (point - frames.origins[TORSO]) @ frames.rotations[TORSO]
    return float(np.linalg.norm(pushed_out(body, local, least) - local))
