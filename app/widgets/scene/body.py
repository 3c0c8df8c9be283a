"""The measured points, the body model and what is known about its limbs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pyvista as pv

from stereotrack_core.arrays import FloatArray

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import Theme
from .content import Ellipsoid, LimbMesh, SceneContent
from .geometry import Shape

_POINT_METRES = 0.007
_POINT_SIZES = np.array([1.0, 4.0])
_SIGMAS = 2.0
_RIM = 0.012
_FAR = 100.0


class CloudLayer:
    """Measured points as dots."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._shape = Shape(renderer)
        self._shown: tuple[object, object] = (None, None)

    def set_dots_to(self, pixels_per_metre: float, scale: float) -> None:
        """Let dots be as large as what they stand for, within what can be told apart."""
        size = float(np.clip(_POINT_METRES * pixels_per_metre, *(scale * _POINT_SIZES)))
        self._shape.prop.point_size = size

    def show(self, content: SceneContent, visible: bool) -> None:
        """Take over the points where they are not the ones shown already."""
        shown = visible and len(content.cloud_points) > 0
        self._shape.actor.visibility = shown
        arrays = (content.cloud_points, content.cloud_colours)
        if shown and (arrays[0] is not self._shown[0] or arrays[1] is not self._shown[1]):
            self._shape.set_dots(content.cloud_points)
            self._shape.set_point_colours(content.cloud_colours)
            self._shown = arrays


class ModelLayer:
    """One surface for each part of the body, in its limb's colour.

    The limb that is selected keeps its colour and gets a rim: the inner side of a surface that
    stands a little away from it.
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._surfaces: list[Shape] = []
        self._rims: list[Shape] = []

    def show(self, content: SceneContent, visible: bool, theme: Theme) -> None:
        """Move the surfaces to where the body is now."""
        meshes = content.meshes if visible else ()
        chosen = [mesh for mesh in meshes if mesh.limb == content.highlighted]
        _fill(self._surfaces, len(meshes), self._new_surface)
        _fill(self._rims, len(chosen), self._new_rim)
        for shape, mesh in zip(self._surfaces, meshes, strict=False):
            shape.set_triangles(mesh.vertices, mesh.triangles)
            shape.set_colour(LIMB_COLOURS.get(mesh.limb, theme.disabled))
        for shape, mesh in zip(self._rims, chosen, strict=False):
            away = _RIM * np.asarray(_surface(mesh).point_normals)
            shape.set_triangles(mesh.vertices + away, mesh.triangles)
            shape.set_colour(theme.accent)

    def _new_surface(self) -> Shape:
        shape = Shape(self._renderer, lit=True)
        shape.prop.interpolation = "flat"
        shape.prop.ambient = 0.3
        shape.prop.diffuse = 0.7
        shape.prop.specular = 0.15
        shape.prop.specular_power = 20.0
        return shape

    def _new_rim(self) -> Shape:
        shape = Shape(self._renderer)
        shape.prop.culling = "front"
        return shape


def _fill(shapes: list[Shape], count: int, make: Callable[[], Shape]) -> None:
    """Make shapes until there are `count`, and draw so many of them."""
    while len(shapes) < count:
        shapes.append(make())
    for index, shape in enumerate(shapes):
        shape.actor.visibility = index < count


class GhostLayer:
    """Models of other runs, which one sees through: as lines, as dots, or as both."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._surfaces: list[Shape] = []

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Move the models to where they are now."""
        parts = [(ghost.style, mesh) for ghost in content.ghosts for mesh in ghost.meshes]
        _fill(self._surfaces, len(parts) if visible else 0, lambda: Shape(self._renderer))
        for shape, (style, mesh) in zip(self._surfaces, parts if visible else (), strict=False):
            shape.set_triangles(mesh.vertices, mesh.triangles)
            shape.set_colour(LIMB_COLOURS.get(mesh.limb, theme.disabled))
            shape.prop.style = "points" if style == "dot" else "wireframe"
            shape.prop.vertex_visibility = style == "dashdot"
            shape.prop.point_size = 3.0 * scale
            shape.prop.line_width = scale


class EllipsoidLayer:
    """Two standard deviations around what the tracker found."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        sphere = pv.SphereSource(radius=1.0, theta_resolution=12, phi_resolution=7)
        sphere.LatLongTessellationOn()
        self._sphere = sphere.output
        self._shapes: list[Shape] = []

    def show(self, content: SceneContent, visible: bool, theme: Theme) -> None:
        """Place one ellipsoid for each that can be drawn."""
        drawn = [
            (ellipsoid, matrix)
            for ellipsoid in content.ellipsoids
            if visible and (matrix := _world_from_sphere(ellipsoid)) is not None
        ]
        _fill(self._shapes, len(drawn), self._new_wire)
        for shape, (ellipsoid, matrix) in zip(self._shapes, drawn, strict=False):
            shape.set_colour(_apart(LIMB_COLOURS[ellipsoid.limb], theme))
            shape.actor.user_matrix = matrix

    def _new_wire(self) -> Shape:
        shape = Shape(self._renderer, self._sphere)
        # a wire is seen through without the cost of a translucent pass
        shape.prop.style = "wireframe"
        return shape


def _apart(colour: str, theme: Theme) -> str:
    """A limb's colour, moved toward the reference's so that it is seen before the limb."""
    mixed = 0.5 * (np.array(pv.Color(colour).float_rgb) + pv.Color(theme.reference).float_rgb)
    return str(pv.Color(mixed).hex_rgb)


def _world_from_sphere(ellipsoid: Ellipsoid) -> FloatArray | None:
    covariance = ellipsoid.covariance
    if not (np.isfinite(covariance).all() and np.isfinite(ellipsoid.centre).all()):
        return None
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    matrix = np.eye(4)
    matrix[:3, :3] = axes * (_SIGMAS * np.sqrt(np.maximum(variances, 1e-8)))
    matrix[:3, 3] = ellipsoid.centre
    return matrix


def limb_at(meshes: tuple[LimbMesh, ...], eye: FloatArray, direction: FloatArray) -> str:
    """Name the limb whose surface a ray meets first; empty where it meets none, or a leg.

    Parameters
    ----------
    meshes : tuple of LimbMesh
    eye, direction : (3,) float64, world
        The ray; its direction need not be normalised.
    """
    end = eye + _FAR * direction / np.linalg.norm(direction)
    best, found = np.inf, ""
    for mesh in meshes:
        hit, _ = _surface(mesh).ray_trace(eye, end, first_point=True)
        distance = float(np.linalg.norm(hit - eye)) if len(hit) else np.inf
        if distance < best:
            best, found = distance, mesh.limb
    return found if found in LIMB_COLOURS else ""


def _surface(mesh: LimbMesh) -> pv.PolyData:
    return pv.PolyData.from_regular_faces(mesh.vertices, mesh.triangles)
