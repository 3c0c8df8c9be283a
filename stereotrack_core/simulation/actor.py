"""A person ready to be drawn: surface, weights, clothes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.simulation.girdle_skin import (
    girdle_weights,
    with_own_girdle,
    without_own_girdle,
)
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.skeleton import PosedBones, rest_joints
from stereotrack_core.simulation.skin import (
    dual_quaternions,
    skin_weights,
    skinned,
)
from stereotrack_core.simulation.surface import rest_surface
from stereotrack_core.simulation.textures import material_table
from stereotrack_core.simulation.wardrobe import borders, worn


@dataclass(frozen=True, eq=False)
class Actor:
    """A dressed person whose surface can be posed.

    Attributes
    ----------
    person : Person
    vertices, normals : (V, 3) float64
        At rest; the textures live in these coordinates.
    triangles : (T, 3) int64
    weights : (V, B) float64
    materials : (6, 9) float64
    marks : (8,) float64
    """

    person: Person
    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    weights: FloatArray
    materials: FloatArray
    marks: FloatArray

    @cached_property
    def stuff(self) -> IntArray:
        """Material per triangle: all are asked of the marks."""
        return np.full(len(self.triangles), -1, dtype=np.int64)

    @cached_property
    def girdle_shares(self) -> FloatArray:
        """How vertices follow shoulders that move on their own, (V, 5)."""
        return girdle_weights(self.person, self.vertices, self.weights)

    def posed(self, bones: PosedBones) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals (V, 3), world."""
        following = without_own_girdle(bones)
        quaternions = dual_quaternions(rest_joints(self.person), following)
        posed = skinned(self.vertices, self.normals, self.weights, quaternions)
        return posed if following is bones else with_own_girdle(*posed, self.girdle_shares, bones)


def actor(person: Person, clothes: str) -> Actor:
    """Contour, weight and dress a person."""
    surface = rest_surface(person)
    return Actor(
        person,
        surface.vertices,
        surface.normals,
        surface.triangles,
        skin_weights(person, surface.vertices),
        material_table(worn(person, clothes)),
        borders(person),
    )
