"""Shadows that people cast, and a shade that wanders through the room.

Both are computed on the surfaces of the room and of the people, so that all cameras see the same.
The shadow is a perspective shadow map (Williams, "Casting curved shadows on curved surfaces", 1978)
whose edge widens with the distance from what casts it (Fernando, "Percentage-closer soft shadows",
2005).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled
from stereotrack_core.simulation.disturbances import Disturber
from stereotrack_core.simulation.raster import Raster
from stereotrack_core.simulation.rig import looking_at
from stereotrack_core.simulation.shading import along

_LAMP_DISTANCE, _LAMP_HEIGHTS, _LAMP_RADIUS = 4.2, (1.9, 2.5), 0.05
"""Metres from the middle of the room, above the floor, and of the lamp itself."""

_MAP_SIZE, _MAP_FOCAL = 768, 307.0
"""Pixels of the shadow map; 1 cm at the person."""

_LOOK_AT_HEIGHT, _NEAREST = 0.9, 0.3
"""Metres: the height at which the lamp is aimed, and the least distance of what casts a shadow."""

_BIAS = 0.05
"""Metres by which what casts a shadow must be nearer to the lamp, so that nothing shades itself."""

_REACH = 21
"""Pixels (odd) of the map in which things may cast a soft edge on a point."""

_SHADE_SECONDS, _SHADE_WAY, _SHADE_EDGE = 12.0, 1.5, 0.8
"""Period, amplitude (m) and width (m) of the edge of the shade that wanders."""


@dataclass(frozen=True, eq=False)
class Shadows:
    """The light of a frame that people and shade take away from surfaces."""

    shadow: float
    shade: float
    lamp: FloatArray
    """(4, 3): rotation from world to lamp, whose z is its axis; place of the lamp."""
    nearness: Float32Array
    """(S, S): 1 / z of the nearest person seen by the lamp, 0 where nobody is."""
    reached: Float32Array
    """(S, S): greatest `nearness` around each pixel."""
    edge: FloatArray
    """(4,): direction into the shade, and the distance along it at which it begins."""

    @staticmethod
    def of(
        disturber: Disturber, people: Iterable[tuple[IntArray, FloatArray]], frame: int
    ) -> Shadows | None:
        """Shadows that people cast in a frame; None if neither shadow nor shade is chosen.

        Parameters
        ----------
        disturber : Disturber
        people : triangles (T, 3) and vertices (V, 3), world, of each
        frame : int
        """
        shadow, shade = (disturber.strengths.get(kind, 0.0) for kind in ("shadow", "shade"))
        if not shadow and not shade:
            return None
        lamp, nearness = _lamp(disturber), np.zeros((_MAP_SIZE, _MAP_SIZE), np.float32)
        if shadow > 0:
            for triangles, vertices in people:
                _cast(lamp, triangles, vertices, nearness)
        reached = np.asarray(cv2.dilate(nearness, np.ones((_REACH, _REACH), np.uint8)), np.float32)
        return Shadows(shadow, shade, lamp, nearness, reached, _edge(disturber, frame))

    def left_light(self, points: FloatArray, normals: FloatArray, is_person: bool) -> FloatArray:
        """Share of the light (N,) that is left at points with normals (N, 3), world."""
        depth = (along(points, self.edge[:3]) - self.edge[3]) / _SHADE_EDGE + 0.5
        depth = np.clip(depth, 0.0, 1.0)
        factor: FloatArray = 1.0 - self.shade * depth * depth * (3.0 - 2.0 * depth)
        if self.shadow > 0.0:
            away = points - self.lamp[3]
            distance = np.sqrt(along(away**2, np.ones(3)))
            facing = np.clip(-5.0 * along(normals, away.T) / distance, 0.0, 1.0)
            hidden = self._hidden(away, facing > 0.0)
            # The lamp shines in the empty scene as well, so that the room's sides that are turned
            # away from it lose nothing; those of a person have no light of the lamp.
            lost = 1.0 - facing * (1.0 - hidden) if is_person else facing * hidden
            factor *= 1.0 - self.shadow * lost
        return factor

    def _hidden(self, away: FloatArray, lit: BoolArray) -> FloatArray:
        """Share of the lamp (N,) that people hide from places (N, 3) away from it, if lit."""
        hidden = np.zeros(len(away))
        x, y, z = (along(away, axis) for axis in self.lamp[:3])
        safe = np.maximum(z, _NEAREST)
        middle = (_MAP_SIZE - 1) / 2
        places = np.stack([x / safe * _MAP_FOCAL + middle, y / safe * _MAP_FOCAL + middle, z])
        inside = (places[:2] >= 0.0).all(axis=0) & (places[:2] <= _MAP_SIZE - 1).all(axis=0)
        chosen = np.flatnonzero(lit & inside & (z >= _NEAREST))
        hidden[chosen] = _hidden_shares(places[:, chosen], self.nearness, self.reached)
        return hidden


def _lamp(disturber: Disturber) -> FloatArray:
    rng = disturber.rng("shadow")
    angle, height = rng.uniform(0, 2 * np.pi), rng.uniform(*_LAMP_HEIGHTS)
    place = np.array([*(_LAMP_DISTANCE * np.array([np.cos(angle), np.sin(angle)])), height])
    return np.vstack([looking_at(place, np.array([0.0, 0.0, _LOOK_AT_HEIGHT])), place])


def _cast(
    lamp: FloatArray, triangles: IntArray, vertices: FloatArray, out_nearness: Float32Array
) -> None:
    """Draw a person as the lamp sees it."""
    x, y, z = (lamp[:3] @ (vertices - lamp[3]).T).astype(np.float64)
    safe = np.maximum(z, _NEAREST)
    samples = np.column_stack([x, y]) / safe[:, None] * _MAP_FOCAL + (_MAP_SIZE - 1) / 2
    samples[z < _NEAREST] = np.nan
    Raster.over(out_nearness).draw(samples, 1.0 / safe, triangles)


def _edge(disturber: Disturber, frame: int) -> FloatArray:
    """Where the shade begins in a frame."""
    angle, phase = disturber.rng("shade").uniform(0, 2 * np.pi, 2)
    direction = np.array([np.cos(angle), np.sin(angle), 0.5]) / np.sqrt(1.25)
    turn = 2 * np.pi * frame / disturber.fps / _SHADE_SECONDS + phase
    return np.array([*direction, _SHADE_WAY * np.sin(turn) + 0.4])


@compiled()
def _hidden_shares(places: Any, nearness: Any, reached: Any) -> Any:
    """Hidden shares (N,) of the lamp at pixels and depths (3, N) of its map."""
    size = nearness.shape[0]
    shares = np.zeros(places.shape[1])
    for n in range(places.shape[1]):
        u, v, z = places[0, n], places[1, n], places[2, n]
        limit = 1.0 / (z - _BIAS)
        nearest = reached[int(v + 0.5), int(u + 0.5)]
        if nearest <= limit:
            continue
        spread = max(0.7, _MAP_FOCAL * _LAMP_RADIUS * (nearest - 1.0 / z)) / 3
        count = 0
        for row in range(-3, 4):
            for column in range(-3, 4):
                r = min(size - 1, max(0, int(v + spread * row + 0.5)))
                c = min(size - 1, max(0, int(u + spread * column + 0.5)))
                count += nearness[r, c] > limit
        shares[n] = count / 49.0
    return shares
