"""Colours of the body's parts, learned from the points that surely belong to them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import HEAD, LIMB_OF_PART, TORSO
from stereotrack_core.body.surface import in_cone, nearest_on_surface
from stereotrack_core.compiled import compiled

_OFFSET = 10.0  # levels added to every channel, so that noise in the dark counts little
FLOOR = np.array([0.20, 0.06, 0.06])  # of brightness and both colour ratios of a single stuff


def colour_features(colours: FloatArray) -> FloatArray:
    """Logarithms (N, 3) of brightness, red to green, blue to green, of BGR (N, 3), 0 to 255."""
    blue, green, red = np.log(np.maximum(colours, 0.0) + _OFFSET).T
    return np.stack([(blue + green + red) / 3.0, red - green, blue - green], axis=1)


_HEIGHTS, _ANGLES = 6, 8  # patches along and around a cone; limbs turn unseen and have one around
_NEAR, _APART = 0.03, 0.07  # metres of a datum that surely belongs: to a part, and to all others
_FAR = 0.25  # metres from a cone's surface beyond which its colour is not asked for
_TAUGHT = 2  # every so many data teach colours; more cost time and add little
_MEMORY = 0.98  # share that is kept from frame to frame: light and view change slowly
_LEAST = 8.0  # data without which a patch's colour is not known
_MOST = 3.0  # standard deviations at which a colour is as foreign as it can be
_UNKNOWN = 1.0  # sigmas of a patch of unknown colour: as much as its own data on average


@dataclass(frozen=True, eq=False)
class PartColours:
    """Mean and variance of the colours of every cone's patches: C cones, H heights, A angles."""

    count: FloatArray  # (C, H, A). Data that have taught each patch, with older ones counting less.
    mean: FloatArray  # (C, H, A, 3). Of :func:`colour_features`.
    square: FloatArray  # (C, H, A, 3). Mean of their squares.

    @classmethod
    def unknown(cls, body: BodyModel) -> PartColours:
        """Colours of a body that nobody has seen yet."""
        shape = len(body.cones), _HEIGHTS, _ANGLES
        return cls(np.zeros(shape), np.zeros((*shape, 3)), np.zeros((*shape, 3)))

    def penalty(
        self, body: BodyModel, data: FloatArray, features: FloatArray, frames: PartFrames
    ) -> FloatArray:
        """Standard deviations (N, C), root mean square over the three features, capped.

        `data` (N, 3), world, have `features` (N, 3) of :func:`colour_features`; NaN counts as
        unknown.
        """
        variance = np.maximum(self.square - self.mean**2, 0.0) + FLOOR**2
        known = self.count >= _LEAST
        result = np.empty((len(data), len(body.cones)))
        placed, turns = placed_cones(body, frames), _turning(body)
        data, features = np.ascontiguousarray(data), np.ascontiguousarray(features)
        learned = self.mean, 1.0 / variance, known
        _differences(data, features, placed, turns, learned, result)
        return result

    def updated(
        self, body: BodyModel, data: FloatArray, features: FloatArray, frames: PartFrames
    ) -> PartColours:
        """Colours after the data that surely belong to a part; arguments as for `penalty`."""
        data, features = data[::_TAUGHT], features[::_TAUGHT]
        seen = np.isfinite(features).all(axis=1)
        data, features = data[seen], features[seen]
        cone = _sure_cones(body, data, frames)
        sure = cone >= 0
        height, angle = _patches(body, data[sure], cone[sure], frames)
        flat = np.ravel_multi_index((cone[sure], height, angle), self.count.shape)
        size = self.count.size
        new = np.bincount(flat, minlength=size).reshape(self.count.shape)
        total = _MEMORY * self.count + new
        share = np.divide(new, total, out=np.zeros_like(total), where=total > 0)[..., None]
        mean, square = self.mean.copy(), self.square.copy()
        for k in range(3):
            values = features[sure, k]
            for known, sums in ((mean, values), (square, values**2)):
                fresh = np.bincount(flat, sums, size).reshape(self.count.shape)
                fresh = np.divide(fresh, new, out=np.zeros(new.shape), where=new > 0)
                known[..., k] += share[..., 0] * (fresh - known[..., k])
        return PartColours(total, mean, square)


def _turning(body: BodyModel) -> BoolArray:
    """Cones (C,) of torso and head, whose turn about their own axis is seen."""
    return np.isin(LIMB_OF_PART[body.cones["part"]], [TORSO, HEAD])


def _sure_cones(body: BodyModel, data: FloatArray, frames: PartFrames) -> IntArray:
    """Cone (N,) of the data that surely belong to a part; else -1."""
    placed, limb = placed_cones(body, frames), LIMB_OF_PART[body.cones["part"]]
    nearest = nearest_on_surface(data, placed, _NEAR)
    result = nearest.cone.copy()
    for other in np.unique(limb):
        of_others: BoolArray = limb[result] != other
        distance = nearest_on_surface(data, placed[limb == other], np.inf).distance
        result[(result >= 0) & of_others & (np.abs(distance) < _APART)] = -1
    return result


def _patches(
    body: BodyModel, data: FloatArray, cone: IntArray, frames: PartFrames
) -> tuple[IntArray, IntArray]:
    """Height and angle (N,) of the patches of cones that data belong to."""
    placed = placed_cones(body, frames)
    local = np.einsum("nij,ni->nj", placed["rotation"][cone], data - placed["origin"][cone])
    share = local[:, 2] / body.cones["height"][cone]
    height = np.clip((share * _HEIGHTS).astype(np.int64), 0, _HEIGHTS - 1)
    turn = (np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi)) % 1.0
    angle = np.minimum((turn * _ANGLES).astype(np.int64), _ANGLES - 1)
    return height, np.where(_turning(body)[cone], angle, 0)


@compiled()
def _differences(
    points: Any, features: Any, placed: Any, turns: Any, learned: Any, out_penalty: Any
) -> None:
    mean, precision, known = learned
    heights, angles = known.shape[1], known.shape[2]
    for i in range(points.shape[0]):
        for c in range(placed.shape[0]):
            cone = placed[c]
            px, py, along = in_cone(cone, points[i, 0], points[i, 1], points[i, 2])
            radius = max(cone.r1, cone.r2)
            beyond = max(-along, along - cone.height)
            if px * px + py * py > (radius + _FAR) ** 2 or beyond > radius + _FAR:
                out_penalty[i, c] = _UNKNOWN
                continue
            h = min(heights - 1, max(0, int(along / cone.height * heights)))
            a = 0
            if turns[c]:
                a = int((math.atan2(py, px) / (2.0 * math.pi)) % 1.0 * angles)
                a = min(angles - 1, a)
            total = 0.0
            for k in range(3):
                off = features[i, k] - mean[c, h, a, k]
                total += off * off * precision[c, h, a, k]
            total = math.sqrt(total / 3.0)
            if not known[c, h, a] or not total < math.inf:
                out_penalty[i, c] = _UNKNOWN
            else:
                out_penalty[i, c] = min(total, _MOST)
