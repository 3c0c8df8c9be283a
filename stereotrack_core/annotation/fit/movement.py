"""How a body is expected to move: speeds that fade, sudden changes now and then."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import HEAD
from stereotrack_core.filtering.smoothing import Walk

_UNEVEN = 0.3
"""Part of the usual speed by which a step differs from what the speed says."""

_SLOWEST = 0.02
"""Least factor on the movement's variances."""


class Movement:
    """The state with its speeds from frame to frame.

    The numbers are those of the error state, then the speeds of the pose's numbers per frame:
    x_k+1 = x_k + v_k, v_k+1 = rho v_k, and shifts and slips fade towards nothing.

    Parameters
    ----------
    freedom : Freedom
    settings : FitSettings
    fps : float
    """

    def __init__(self, freedom: Freedom, settings: FitSettings, fps: float) -> None:
        self.freedom = freedom
        n, of_pose = freedom.columns.n, freedom.of_pose
        self.size = n + of_pose
        kept = np.ones(self.size)
        kept[freedom.of_offsets] = _kept(fps, settings.shift_time)
        kept[freedom.of_slips] = _kept(fps, settings.surface_time)
        kept[freedom.of_slips][:6] = _kept(fps, settings.trunk_time)
        kept[n:] = _kept(fps, settings.speed_time)
        self.F = np.diag(kept)
        self.F[np.arange(of_pose), n + np.arange(of_pose)] = 1.0
        speed = pose_sigmas(
            freedom, settings.speed_position, settings.speed_rotation, settings.speed_joint
        )
        self.sigma = np.concatenate(
            [np.full(of_pose, np.nan), shift_sigmas(freedom, settings), speed / fps]
        )
        self.noise = self.sigma**2 * (1.0 - kept**2)
        self.noise[:of_pose] = (_UNEVEN * speed / fps) ** 2
        self._tail = settings.speed_tail

    def walk(
        self,
        states: Sequence[FitState],
        speeds: FloatArray,
        factors: FloatArray,
        usual: Pose,
        pose_sigma: FloatArray,
    ) -> Walk:
        """The walk in error states around a trajectory.

        Parameters
        ----------
        states : sequence of FitState
            Points of linearisation, one for each of K frames.
        speeds : (K, of_pose) float64
            Per frame.
        factors : (K - 1, of_pose) float64
            On the variances of the movement.
        usual : Pose
            What is expected of the first frame.
        pose_sigma : (of_pose,) float64
            How firmly.
        """
        f = self.freedom
        at = np.array([self._numbers(s, v) for s, v in zip(states, speeds, strict=True)])
        kept = np.diagonal(self.F)
        c = at[:-1] * kept - at[1:]
        for k, (one, other) in enumerate(pairwise(states)):
            c[k, : f.of_pose] = f.pose_difference(one.pose, other.pose) + speeds[k]
        Q = np.tile(self.noise, (len(c), 1))
        Q[:, : f.of_pose] *= factors
        Q[:, f.columns.n :] *= factors
        mean = -at[0]
        mean[: f.of_pose] = f.pose_difference(usual, states[0].pose)
        sigma = self.sigma.copy()
        sigma[: f.of_pose] = pose_sigma
        return Walk(self.F, c, Q, mean, np.diag(sigma**2))

    def _numbers(self, state: FitState, speed: FloatArray) -> FloatArray:
        nothing = np.zeros(self.freedom.of_pose)
        return np.concatenate([nothing, state.offsets.ravel(), state.slips.ravel(), speed])

    def factors(self, noise: FloatArray) -> FloatArray:
        """Factors (K - 1, of_pose) on the variances that make the movements usual ones.

        Expected variance of a normal distribution whose own variance is unknown, which makes
        the movement one of Student's distribution; position, rotation and each joint alone.

        Parameters
        ----------
        noise : (K - 1, N) float64
            Expected squares of what was left of the movement.
        """
        n, of_pose = self.freedom.columns.n, self.freedom.of_pose
        relative = noise / self.noise
        squared = 0.5 * (relative[:, :of_pose] + relative[:, n:])
        factors = np.empty_like(squared)
        starts = [0, 3, *range(6, of_pose, 2)]
        for first, end in zip(starts, [*starts[1:], of_pose], strict=True):
            own = 2 * (end - first)
            total = squared[:, first:end].sum(axis=1) * 2
            factors[:, first:end] = ((self._tail + total) / (self._tail + own))[:, None]
        return np.maximum(factors, _SLOWEST)


def pose_sigmas(
    freedom: Freedom, position: float, rotation_deg: float, joint_deg: float
) -> FloatArray:
    """One number (of_pose,) for each of the pose's: metres, and degrees turned to radians."""
    sigma = np.full(freedom.of_pose, np.radians(joint_deg))
    sigma[:3], sigma[3:6] = position, np.radians(rotation_deg)
    return sigma


def shift_sigmas(freedom: Freedom, settings: FitSettings) -> FloatArray:
    """Usual sizes of landmarks' shifts and of slips."""
    shifts = np.where(
        freedom.shifts_joint, settings.sigma_joint_shift, settings.sigma_landmark_shift
    )
    shifts[freedom.parts == HEAD] = settings.sigma_head_shift
    slips = np.tile(
        np.repeat([settings.sigma_surface_shift, np.radians(settings.sigma_surface_turn)], 3),
        len(LIMBS) if freedom.with_depth else 0,
    )
    slips[:3] = settings.sigma_trunk_shift
    return np.concatenate([np.repeat(shifts, 3), slips])


def _kept(fps: float, seconds: float) -> float:
    return float(np.exp(-1.0 / (fps * seconds)))
