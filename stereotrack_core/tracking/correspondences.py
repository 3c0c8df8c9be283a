"""Which measured points belong to which part: nearest in space, and in colour where known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import HEAD, LIMB_OF_PART, TORSO
from stereotrack_core.body.surface import cone_table, nearest_on_surface
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Memory
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.state import Setup

_TRUSTED = 0.25
"""Unexplained fraction of the cloud above which a pose teaches nothing about colours."""

_OFFSET = 10.0
"""Levels added to every channel, so that noise in the dark counts little."""

FLOOR = np.array([0.20, 0.06, 0.06])
"""Standard deviations that shading and noise give to brightness and to both colour ratios of a
single stuff."""


def colour_features(colours: FloatArray) -> FloatArray:
    """Logarithms (N, 3) of brightness, of red to green, and of blue to green.

    Parameters
    ----------
    colours : (N, 3) float64
        BGR from 0 to 255; NaN stays NaN.
    """
    blue, green, red = np.log(np.maximum(colours, 0.0) + _OFFSET).T
    return np.stack([(blue + green + red) / 3.0, red - green, blue - green], axis=1)


_HEIGHTS, _ANGLES = 6, 8
"""Patches along and around a cone; limbs turn unseen about their axes and have one around."""

_NEAR, _APART = 0.03, 0.07
"""Metres: a datum this near to a part and this far from all others surely belongs to it."""

_FAR = 0.25
"""Metres from a cone's surface beyond which its colour is not asked for."""

_TAUGHT = 2
"""Every so many data teach colours; more cost time and add little."""

_MEMORY = 0.98
"""Share of the learned colours that is kept from frame to frame: light and view change slowly."""

_LEAST = 8.0
"""Data without which a patch's colour is not known."""

_MOST = 3.0
"""Standard deviations at which a colour is as foreign as it can be."""

_UNKNOWN = 1.0
"""Standard deviations that a patch of unknown colour is taken to differ by: as much as its own
data would on average."""


class PartColours:
    """Mean and variance of the colours of every cone's patches."""

    def __init__(self, body: BodyModel) -> None:
        self.body = body
        shape = len(body.cones), _HEIGHTS, _ANGLES
        self.count = np.zeros(shape)
        self.mean = np.zeros((*shape, 3))
        self.square = np.zeros((*shape, 3))
        self._turns = np.isin(LIMB_OF_PART[body.cones.part], [TORSO, HEAD])

    def penalty(self, data: FloatArray, features: FloatArray, frames: PartFrames) -> FloatArray:
        """Standard deviations (N, C), root mean square over the three features, capped.

        Parameters
        ----------
        data : (N, 3) float64, world
        features : (N, 3) float64
            See :func:`colour_features`; NaN counts as unknown.
        frames : PartFrames
            Of one pose.
        """
        variance = np.maximum(self.square - self.mean**2, 0.0) + FLOOR**2
        known = self.count >= _LEAST
        result = np.empty((len(data), len(self.body.cones)))
        table = cone_table(placed_cones(self.body, frames))
        data, features = np.ascontiguousarray(data), np.ascontiguousarray(features)
        _differences(data, features, table, self._turns, self.mean, 1.0 / variance, known, result)
        return result

    def learn(self, data: FloatArray, features: FloatArray, frames: PartFrames) -> None:
        """Take in the data that surely belong to a part; arguments are those of `penalty`."""
        data, features = data[::_TAUGHT], features[::_TAUGHT]
        seen = np.isfinite(features).all(axis=1)
        data, features = data[seen], features[seen]
        cone = self._sure(data, frames)
        sure = cone >= 0
        height, angle = self._patch(data[sure], cone[sure], frames)
        flat = np.ravel_multi_index((cone[sure], height, angle), self.count.shape)
        size = self.count.size
        new = np.bincount(flat, minlength=size).reshape(self.count.shape)
        total = _MEMORY * self.count + new
        share = np.divide(new, total, out=np.zeros_like(total), where=total > 0)[..., None]
        # New arrays: those that a saved state holds must not change.
        self.mean, self.square = self.mean.copy(), self.square.copy()
        for k in range(3):
            values = features[sure, k]
            for known, sums in ((self.mean, values), (self.square, values**2)):
                fresh = np.bincount(flat, sums, size).reshape(self.count.shape)
                fresh = np.divide(fresh, new, out=np.zeros(new.shape), where=new > 0)
                known[..., k] += share[..., 0] * (fresh - known[..., k])
        self.count = total

    def _sure(self, data: FloatArray, frames: PartFrames) -> IntArray:
        """Cone (N,) of the data that surely belong to a part; else -1."""
        placed, limb = placed_cones(self.body, frames), LIMB_OF_PART[self.body.cones.part]
        nearest = nearest_on_surface(data, placed, _NEAR)
        result = nearest.cone.copy()
        for other in np.unique(limb):
            of_others: BoolArray = limb[result] != other
            distance = nearest_on_surface(data, placed[limb == other], np.inf).distance
            result[(result >= 0) & of_others & (np.abs(distance) < _APART)] = -1
        return result

    def _patch(
        self, data: FloatArray, cone: IntArray, frames: PartFrames
    ) -> tuple[IntArray, IntArray]:
        placed = placed_cones(self.body, frames)
        local = np.einsum("nij,ni->nj", placed.rotations[cone], data - placed.origins[cone])
        share = local[:, 2] / self.body.cones.height[cone]
        height = np.clip((share * _HEIGHTS).astype(np.int64), 0, _HEIGHTS - 1)
        turn = (np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi)) % 1.0
        angle = np.minimum((turn * _ANGLES).astype(np.int64), _ANGLES - 1)
        return height, np.where(self._turns[cone], angle, 0)


@compiled()
def _differences(
    points: Any,
    features: Any,
    table: Any,
    turns: Any,
    mean: Any,
    precision: Any,
    known: Any,
    result: Any,
) -> None:
    heights, angles = known.shape[1], known.shape[2]
    for i in range(points.shape[0]):
        for c in range(table.shape[0]):
            row = table[c]
            x, y, z = points[i, 0] - row[9], points[i, 1] - row[10], points[i, 2] - row[11]
            along = row[2] * x + row[5] * y + row[8] * z
            aside = x * x + y * y + z * z - along * along
            radius = max(row[12], row[13])
            beyond = max(-along, along - row[14])
            if aside > (radius + _FAR) ** 2 or beyond > radius + _FAR:
                result[i, c] = _UNKNOWN
                continue
            h = min(heights - 1, max(0, int(along / row[14] * heights)))
            a = 0
            if turns[c]:
                px = row[0] * x + row[3] * y + row[6] * z
                py = row[1] * x + row[4] * y + row[7] * z
                a = int((math.atan2(py, px) / (2.0 * math.pi)) % 1.0 * angles)
                a = min(angles - 1, a)
            total = 0.0
            for k in range(3):
                off = features[i, k] - mean[c, h, a, k]
                total += off * off * precision[c, h, a, k]
            total = math.sqrt(total / 3.0)
            if not known[c, h, a] or not total < math.inf:
                result[i, c] = _UNKNOWN
            else:
                result[i, c] = min(total, _MOST)


class DataToModel:
    """Gives measured points to the cones that are nearest.

    With colours they are nearest in six dimensions: three of space, three of colour. Data are then
    (N, 6): places and colour features side by side. Where a recording has no colours, or they
    have no weight, nothing differs.

    Parameters
    ----------
    coloured : bool
        Whether colours are learned and used, where the parameters want it.
    """

    def __init__(self, setup: Setup, *, coloured: bool = False) -> None:
        self.setup = setup
        coloured = coloured and setup.parameters.colour_weight > 0.0
        self._known = PartColours(setup.body) if coloured else None
        self._chosen: FloatArray | None = None

    def choose(self, cloud: Cloud) -> FloatArray:
        """Draw the data (N, 3), or (N, 6), evenly from the cloud; the same for the same frame."""
        points, colours = cloud.points, cloud.colours
        usable = self._known is not None and colours is not None and len(colours) == len(points)
        if usable and colours is not None:
            points = np.hstack([points, colour_features(colours)])
        wanted, there = self.setup.parameters.data_points, len(points)
        if there > wanted:
            rng = np.random.default_rng((self.setup.seed, cloud.frame))
            points = points[np.sort(rng.choice(there, wanted, replace=False))]
        self._chosen = points if usable else None
        return points

    def surface(self, data: FloatArray, pose: Pose, *, wide: bool) -> SurfaceResidual:
        """Give the data to the cones that are nearest at a pose.

        Parameters
        ----------
        data : (N, 3) or (N, 6) float64
            See :meth:`choose`.
        wide : bool
            Whether a datum's weight falls off slowly with its distance.
        """
        p, body = self.setup.parameters, self.setup.body
        frames = body.frames(pose)
        trust = Trust.of(p, wide=wide)
        if self._known is None or data.shape[1] == 3:
            return surface_residual(data, body, frames, trust)
        places = np.ascontiguousarray(data[:, :3])
        penalty = p.colour_weight * self._known.penalty(places, data[:, 3:], frames)
        return surface_residual(places, body, frames, trust, penalty)

    def learn(self, pose: Pose, unexplained_fraction: float) -> None:
        """Learn the parts' colours from the data of a frame, where its pose explains the cloud."""
        data = self._chosen
        if self._known is None or data is None or not unexplained_fraction < _TRUSTED:
            return
        self._known.learn(data[:, :3], data[:, 3:], self.setup.body.frames(pose))

    def memory(self) -> Memory:
        """All that the next frame's correspondences depend on."""
        known = self._known
        if known is None:
            return {}
        return {
            "colour_count": known.count,
            "colour_mean": known.mean,
            "colour_square": known.square,
        }

    def recall(self, memory: Memory) -> None:
        """Go on as those would whose memory this is."""
        known = self._known
        if known is not None and "colour_count" in memory:
            known.count, known.mean = memory["colour_count"], memory["colour_mean"]
            known.square = memory["colour_square"]
