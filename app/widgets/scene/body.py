"""The measured points, the body model and what is known about its limbs."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.mesh import PartMesh

from ..camera.inside_overlay import Ghosts, InsideScene
from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import Theme
from .content import Ellipsoid, SceneContent
from .geometry import Shape, Shapes

_POINT_METRES = 0.007
_POINT_SIZES = np.array([1.0, 4.0])
_SIGMAS = 2.0
_SKIN = {
    "interpolation": "flat",
    "ambient": 0.3,
    "diffuse": 0.7,
    "specular": 0.15,
    "specular_power": 20.0,
}
_DOT = 4.0
_RING = 8
"""Vertices of a cone's ring, as ghosts are made."""
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
        self._surfaces = Shapes(renderer, lit=True, **_SKIN)
        self._rims = Shapes(renderer, culling="front")

    def show(self, content: SceneContent, visible: bool, theme: Theme) -> None:
        """Move the surfaces to where the body is now."""
        meshes = content.meshes if visible else ()
        for shape, mesh in self._surfaces.drawn(meshes):
            shape.set_triangles(mesh.vertices, mesh.triangles)
            shape.set_colour(LIMB_COLOURS.get(mesh.limb, theme.disabled))
        chosen = [mesh for mesh in meshes if mesh.limb == content.highlighted]
        for shape, mesh in self._rims.drawn(chosen):
            away = _RIM * np.asarray(_surface(mesh).point_normals)
            shape.set_triangles(mesh.vertices + away, mesh.triangles)
            shape.set_colour(theme.accent)


class GhostLayer:
    """Models of other runs, which one sees through: as lines, as dots, or as both."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._surfaces = Shapes(renderer)

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Move the models to where they are now."""
        parts = [(ghost.style, mesh) for ghost in content.ghosts for mesh in ghost.meshes]
        for shape, (style, mesh) in self._surfaces.drawn(parts if visible else ()):
            shape.set_triangles(mesh.vertices, mesh.triangles)
            shape.set_colour(LIMB_COLOURS.get(mesh.limb, theme.disabled))
            shape.prop.style = "points" if style == "dot" else "wireframe"
            shape.prop.vertex_visibility = style == "dashdot"
            shape.prop.point_size = 3.0 * scale
            shape.prop.line_width = scale


class EllipsoidLayer:
    """Two standard deviations around what the tracker found."""

    def __init__(self, renderer: pv.Renderer) -> None:
        sphere = pv.SphereSource(radius=1.0, theta_resolution=12, phi_resolution=7)
        sphere.LatLongTessellationOn()
        # a wire is seen through without the cost of a translucent pass
        self._shapes = Shapes(renderer, sphere.output, style="wireframe")

    def show(self, content: SceneContent, visible: bool, theme: Theme) -> None:
        """Place one ellipsoid for each that can be drawn."""
        placed = [(one.limb, _world_from_sphere(one)) for one in content.ellipsoids if visible]
        for shape, (limb, matrix) in self._shapes.drawn([p for p in placed if p[1] is not None]):
            shape.set_colour(_apart(LIMB_COLOURS[limb], theme))
            shape.actor.user_matrix = matrix


class InsideLayer:
    """What a step inside a frame draws, seen through the model: wires, lines and dots."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._wires, self._lines = Shapes(renderer), Shapes(renderer)
        self._dots = Shapes(renderer, render_points_as_spheres=True)
        self._shown: InsideScene | None = None

    def show(self, scene: InsideScene | None, theme: Theme, scale: float) -> None:
        """Take over another step, or none."""
        if scene is self._shown:
            return
        self._shown = scene
        found = scene or InsideScene()
        for shape, ghost in self._wires.drawn(found.ghosts):
            shape.set_lines(_wire_of(ghost))
            shape.set_colour(LIMB_COLOURS.get(ghost.limb, theme.disabled), 0.55)
            shape.prop.line_width = scale
        for shape, line in self._lines.drawn(found.lines):
            shape.set_lines(line.places.reshape(-1, 3))
            shape.set_colour(line.colour)
            shape.prop.line_width = 1.6 * scale
        for shape, dot in self._dots.drawn(found.dots):
            shape.set_dots(dot.places)
            shape.set_colour(dot.colour)
            shape.prop.point_size = _DOT * scale


def _wire_of(ghost: Ghosts) -> FloatArray:
    """End points (2 L, 3) of rings and of four lines along the cone, for all poses."""
    rings = ghost.vertices.reshape(len(ghost.vertices), -1, _RING, 3)[:, 1:-1]
    beside = np.roll(rings, -1, axis=2)
    around = np.stack([rings[:, [0, -1]], beside[:, [0, -1]]], axis=-2).reshape(-1, 3)
    quarter = rings[:, :, :: _RING // 4]
    along = np.stack([quarter[:, :-1], quarter[:, 1:]], axis=-2).reshape(-1, 3)
    return np.concatenate([around, along])


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


def limb_at(meshes: tuple[PartMesh, ...], eye: FloatArray, direction: FloatArray) -> str:
    """Name the limb whose surface a ray meets first; empty where it meets none, or a leg.

    Parameters
    ----------
    meshes : tuple of PartMesh
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


def _surface(mesh: PartMesh) -> pv.PolyData:
    return pv.PolyData.from_regular_faces(mesh.vertices, mesh.triangles)
