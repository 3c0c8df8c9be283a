"""The measured points, the body model and what is known about its limbs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import Theme
from .content import Ellipsoid, LimbMesh, SceneContent
from .geometry import Shape
from .window import unit_rgb

_POINT_METRES = 0.007
_POINT_SIZES = np.array([1.0, 4.0])
_SIGMAS = 2.0
_RIM = 0.012


class CloudLayer:
    """Measured points as dots."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._shape = Shape(renderer)
        self._shown: tuple[object, object] = (None, None)

    def set_dots_to(self, pixels_per_metre: float, scale: float) -> None:
        """Let dots be as large as what they stand for, within what can be told apart."""
        size = float(np.clip(_POINT_METRES * pixels_per_metre, *(scale * _POINT_SIZES)))
        self._shape.actor.GetProperty().SetPointSize(size)

    def show(self, content: SceneContent, visible: bool) -> None:
        """Take over the points where they are not the ones shown already."""
        self._shape.set_visible(visible and len(content.cloud_points) > 0)
        arrays = (content.cloud_points, content.cloud_colours)
        if visible and (arrays[0] is not self._shown[0] or arrays[1] is not self._shown[1]):
            self._shape.set_dots(content.cloud_points)
            self._shape.set_point_colours(content.cloud_colours)
            self._shown = arrays


class ModelLayer:
    """One surface for each part of the body, in its limb's colour.

    The limb that is selected keeps its colour and gets a rim: the inner side of a surface that
    stands a little away from it.
    """

    def __init__(self, renderer: vtkRenderer) -> None:
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
            away = mesh.vertices + _RIM * vertex_normals(mesh.vertices, mesh.triangles)
            shape.set_triangles(away, mesh.triangles)
            shape.set_colour(theme.accent)

    def _new_surface(self) -> Shape:
        shape = Shape(self._renderer, lit=True)
        properties = shape.actor.GetProperty()
        properties.SetInterpolationToFlat()
        properties.SetAmbient(0.3)
        properties.SetDiffuse(0.7)
        properties.SetSpecular(0.15)
        properties.SetSpecularPower(20.0)
        return shape

    def _new_rim(self) -> Shape:
        shape = Shape(self._renderer)
        shape.actor.GetProperty().SetFrontfaceCulling(True)
        return shape


def _fill(shapes: list[Shape], count: int, make: Callable[[], Shape]) -> None:
    """Make shapes until there are `count`, and draw so many of them."""
    while len(shapes) < count:
        shapes.append(make())
    for index, shape in enumerate(shapes):
        shape.set_visible(index < count)


def vertex_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Unit normals (V, 3) outwards, from triangles that are counter-clockwise from outside."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: FloatArray = normals / np.maximum(lengths, 1e-12)
    return result


class GhostLayer:
    """Models of other runs, which one sees through: as lines, as dots, or as both."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._surfaces: list[Shape] = []

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Move the models to where they are now."""
        parts = [(ghost.style, mesh) for ghost in content.ghosts for mesh in ghost.meshes]
        _fill(self._surfaces, len(parts) if visible else 0, lambda: Shape(self._renderer))
        for shape, (style, mesh) in zip(self._surfaces, parts if visible else (), strict=False):
            shape.set_triangles(mesh.vertices, mesh.triangles)
            shape.set_colour(LIMB_COLOURS.get(mesh.limb, theme.disabled))
            properties = shape.actor.GetProperty()
            if style == "dot":
                properties.SetRepresentationToPoints()
            else:
                properties.SetRepresentationToWireframe()
            properties.SetVertexVisibility(style == "dashdot")
            properties.SetPointSize(3.0 * scale)
            properties.SetLineWidth(scale)


class EllipsoidLayer:
    """Two standard deviations around what the tracker found."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        source = vtkSphereSource()
        source.SetThetaResolution(12)
        source.SetPhiResolution(7)
        source.LatLongTessellationOn()
        source.SetRadius(1.0)
        self._mapper = vtkPolyDataMapper()
        self._mapper.SetInputConnection(source.GetOutputPort())
        self._actors: list[vtkActor] = []

    def show(self, content: SceneContent, visible: bool, theme: Theme) -> None:
        """Place one ellipsoid for each that can be drawn."""
        drawn = [
            (ellipsoid, matrix)
            for ellipsoid in content.ellipsoids
            if visible and (matrix := _world_from_sphere(ellipsoid)) is not None
        ]
        while len(self._actors) < len(drawn):
            actor = vtkActor()
            actor.SetMapper(self._mapper)
            actor.PickableOff()
            # a wire is seen through without the cost of a translucent pass
            actor.GetProperty().SetRepresentationToWireframe()
            actor.GetProperty().SetLighting(False)
            self._renderer.AddActor(actor)
            self._actors.append(actor)
        for index, actor in enumerate(self._actors):
            actor.SetVisibility(index < len(drawn))
            if index < len(drawn):
                ellipsoid, matrix = drawn[index]
                actor.GetProperty().SetColor(*_apart(LIMB_COLOURS[ellipsoid.limb], theme))
                actor.SetUserMatrix(matrix)


def _apart(colour: str, theme: Theme) -> FloatArray:
    """A limb's colour, moved toward the reference's so that it is seen before the limb."""
    mixed: FloatArray = 0.5 * (np.array(unit_rgb(colour)) + unit_rgb(theme.reference))
    return mixed


def _world_from_sphere(ellipsoid: Ellipsoid) -> vtkMatrix4x4 | None:
    covariance = ellipsoid.covariance
    if not (np.isfinite(covariance).all() and np.isfinite(ellipsoid.centre).all()):
        return None
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    matrix = np.eye(4)
    matrix[:3, :3] = axes * (_SIGMAS * np.sqrt(np.maximum(variances, 1e-8)))
    matrix[:3, 3] = ellipsoid.centre
    result = vtkMatrix4x4()
    result.DeepCopy(matrix.ravel().tolist())
    return result


def limb_at(meshes: tuple[LimbMesh, ...], eye: FloatArray, direction: FloatArray) -> str:
    """Name the limb whose surface a ray meets first; empty where it meets none, or a leg.

    Parameters
    ----------
    meshes : tuple of LimbMesh
    eye, direction : (3,) float64, world
        The ray; its direction need not be normalised.
    """
    best, found = np.inf, ""
    for mesh in meshes:
        distance = ray_distance(mesh.vertices, mesh.triangles, eye, direction)
        if distance < best:
            best, found = distance, mesh.limb
    return found if found in LIMB_COLOURS else ""


def ray_distance(
    vertices: FloatArray, triangles: IntArray, eye: FloatArray, direction: FloatArray
) -> float:
    """Distance along a ray to a surface, in lengths of `direction`; inf where it misses.

    The test of Moeller and Trumbore (doi:10.1080/10867651.1997.10487468), from both sides.
    """
    corner = vertices[triangles[:, 0]]
    first = vertices[triangles[:, 1]] - corner
    second = vertices[triangles[:, 2]] - corner
    across = np.cross(direction, second)
    determinant = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / determinant
        offset = eye - corner
        u = np.einsum("ij,ij->i", offset, across) * inverse
        turned = np.cross(offset, first)
        v = turned @ direction * inverse
        distance = np.einsum("ij,ij->i", second, turned) * inverse
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0) & np.isfinite(distance)
    return float(distance[hit].min()) if hit.any() else np.inf
