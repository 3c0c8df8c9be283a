"""Drawing of the scene, one function for each part, in a plotter that is never shown."""

import ctypes.util
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any, TypeAlias

import numpy as np
import pyvista as pv
from PySide6.QtGui import QImage

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON
from stereotrack_core.vtk_build import vtk_module

from ..style.colours import LIMB_COLOURS, OLD
from ..style.theme import Theme
from .content import (
    FIELD_OF_VIEW,
    FLOOR_HALF,
    NORTH_TIP,
    Orbit,
    SceneContent,
    frustum_corners,
    frustum_depth,
)

_SKIN = {
    "lighting": True, "interpolation": "flat", "ambient": 0.3, "diffuse": 0.7, "specular": 0.15,
    "specular_power": 20.0,
}  # fmt: skip
_SIGMAS = 2.0
_RING = 8  # vertices of a cone's ring, as ghosts are made
_RIM = 0.012
_FAR = 100.0
_FLOOR_STEP = 0.5
_CORNERS = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
"""Where the corners of a picture are in its texture, whose rows count from below."""

_BONES = np.array([[LANDMARKS.index(a), LANDMARKS.index(b)] for a, b in SKELETON])
_SHOULDERS = [LANDMARKS.index("left_shoulder"), LANDMARKS.index("right_shoulder")]


@dataclass(frozen=True, eq=False)
class Drawn:
    """A mesh as it is drawn by one actor."""

    mesh: pv.PolyData
    colour: str | None = None  # #rrggbb; None where each point of the mesh has a colour of its own
    width: float = 1.0
    size: float = 1.0  # `width` and `size`: device-independent pixels of lines and dots
    metres: float = 0.0
    limits: tuple[float, float] = (0.0, np.inf)
    """`metres` and `limits`: dots are as large as this in the world, within limits in pixels, where
    `metres` is not 0."""
    look: Mapping[str, object] = field(default_factory=dict)
    """Further properties, see :class:`pyvista.Property`."""
    image: ImageArray | None = None
    """(H, W) or (H, W, 3) uint8. Grey or RGB, on the whole of the mesh."""


Part: TypeAlias = Callable[[SceneContent, Theme], list[Drawn]]


def _cloud(content: SceneContent, _theme: Theme) -> list[Drawn]:
    if not len(content.cloud_points):
        return []
    mesh = pv.PolyData(content.cloud_points)
    mesh.point_data.set_scalars(content.cloud_colours, "colour")
    return [Drawn(mesh, metres=0.007, limits=(1.0, 4.0))]


def _model(content: SceneContent, theme: Theme) -> list[Drawn]:
    return [Drawn(_body(content.meshes, theme), look=_SKIN)] if content.meshes else []


def _rims(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Mark the limb that is selected: the inner side of a surface a little away from it."""
    surfaces = [_surface(mesh) for mesh in content.meshes if mesh.limb == content.highlighted]
    for surface in surfaces:
        surface.points = surface.points + _RIM * np.asarray(surface.point_normals)
    return [Drawn(one, theme.accent, look={"culling": "front"}) for one in surfaces]


def _ghosts(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Models of other runs, which one sees through: as lines, as dots, or as both."""
    drawn = []
    for ghost in (ghost for ghost in content.ghosts if ghost.meshes):
        style = "points" if ghost.style == "dot" else "wireframe"
        look = {"style": style, "vertex_visibility": ghost.style == "dashdot"}
        drawn.append(Drawn(_body(ghost.meshes, theme), size=3.0, look=look))
    return drawn


def _ellipsoids(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Two standard deviations around what the tracker found, in wires, which are cheap."""
    drawn = []
    for one in content.ellipsoids:
        if np.isfinite(one.covariance).all() and np.isfinite(one.centre).all():
            variances, axes = np.linalg.eigh((one.covariance + one.covariance.T) / 2)
            half_axes = axes * (_SIGMAS * np.sqrt(np.maximum(variances, 1e-8)))
            wires = pv.PolyData(_sphere().points @ half_axes.T + one.centre, _sphere().faces)
            # a limb's colour, moved toward the reference's, is seen before the limb
            own, other = (pv.Color(c) for c in (LIMB_COLOURS[one.limb], theme.reference))
            mixed = 0.5 * (np.array(own.float_rgb) + other.float_rgb)
            drawn.append(Drawn(wires, pv.Color(mixed).hex_rgb, look={"style": "wireframe"}))
    return drawn


def _reference(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Bones in dashes, and the landmarks that are known as balls."""
    points = content.reference
    if points is None:
        return []
    middle = points[_SHOULDERS].mean(axis=0)
    starts = np.concatenate([points[_BONES[:, 0]], middle[None]])
    ends = np.concatenate([points[_BONES[:, 1]], points[[LANDMARKS.index("head")]]])
    known = pv.PolyData(points[np.isfinite(points).all(axis=1)])
    opacity = OLD if content.reference_is_old else 1.0
    balls = {"render_points_as_spheres": True, "opacity": opacity}
    return [
        Drawn(_lines(_dashes(starts, ends)), theme.reference, 2.0, look={"opacity": opacity}),
        Drawn(known, theme.reference, metres=0.03, limits=(2.5, 7.0), look=balls),
    ]


def _inside(content: SceneContent, theme: Theme) -> list[Drawn]:
    """What a step inside a frame draws, seen through the model: wires, lines and dots."""
    scene = content.inside
    if scene is None:
        return []
    faint, balls = {"opacity": 0.55}, {"render_points_as_spheres": True}
    colours = [LIMB_COLOURS.get(ghost.name, theme.disabled) for ghost in scene.ghosts]
    wires = zip(scene.ghosts, colours, strict=True)
    return [
        *(Drawn(_lines(_wire_of(ghost.places)), colour, look=faint) for ghost, colour in wires),
        *(Drawn(_lines(one.places.reshape(-1, 3)), one.name, 1.6) for one in scene.lines),
        *(Drawn(pv.PolyData(one.places), one.name, size=4.0, look=balls) for one in scene.dots),
    ]


def _floor(_content: SceneContent, theme: Theme) -> list[Drawn]:
    """Grid of half a metre on the floor, with an arrow to the north."""
    grid, arrow = _floor_lines()
    return [Drawn(grid, theme.scene_grid), Drawn(arrow, theme.accent, 2.0)]


@cache
def _floor_lines() -> tuple[pv.PolyData, pv.PolyData]:
    steps = np.arange(-FLOOR_HALF, FLOOR_HALF + 1e-9, _FLOOR_STEP)
    ends = np.array([-FLOOR_HALF, FLOOR_HALF])
    along = np.stack(np.meshgrid(steps, ends, indexing="ij"), axis=-1).reshape(-1, 2)
    grid = np.pad(np.concatenate([along, along[:, ::-1]]), ((0, 0), (0, 1)))
    foot, tip = np.array([[0.0, FLOOR_HALF, 0.0], [0.0, NORTH_TIP, 0.0]])
    back, side = tip - (0.0, 0.18, 0.0), np.array([0.12, 0.0, 0.0])
    arrow = np.stack([foot, tip, back - side, tip, back + side, tip])
    return _lines(grid), _lines(arrow)


def _cameras(content: SceneContent, theme: Theme) -> list[Drawn]:
    """A frustum for each camera, with its newest image on it."""
    depth = frustum_depth(content.cameras)
    drawn = []
    for camera in content.cameras:
        edges, screen = _frustum(camera, depth)
        drawn.append(Drawn(edges, theme.muted, 1.2))
        image = content.camera_images.get(camera.name)
        if image is not None:
            drawn.append(Drawn(screen, "#ffffff", image=image))
    return drawn


def _cameras_before(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Faint frusta of the cameras as they were."""
    depth = frustum_depth((*content.cameras, *content.cameras_before))
    edges = (_frustum(camera, depth)[0] for camera in content.cameras_before)
    return [Drawn(one, theme.disabled, look={"opacity": 0.7}) for one in edges]


def _boards(content: SceneContent, theme: Theme) -> list[Drawn]:
    """Outlines of calibration boards, their upper side in the accent's colour."""
    if not content.boards:
        return []
    corners = np.stack(content.boards)
    edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
    return [
        Drawn(_lines(edges[:, 1:].reshape(-1, 3)), theme.good, look={"opacity": 0.6}),
        Drawn(_lines(edges[:, :1].reshape(-1, 3)), theme.accent, 2.0),
    ]


@lru_cache(maxsize=64)
def _frustum(camera: Camera, depth: float) -> tuple[pv.PolyData, pv.PolyData]:
    """Edges of what a camera sees, and a screen at their end."""
    corners = frustum_corners(camera, depth)
    apex = np.broadcast_to(camera.position_world, (4, 3))
    rays = np.stack([apex, corners], axis=1).reshape(-1, 3)
    rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).reshape(-1, 3)
    screen = pv.PolyData.from_regular_faces(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    screen.active_texture_coordinates = _CORNERS
    return _lines(np.concatenate([rays, rim])), screen


PARTS: tuple[tuple[str, Part], ...] = (
    ("floor", _floor),
    ("cameras", _cameras),
    ("cameras", _cameras_before),
    ("cameras", _boards),
    ("cloud", _cloud),
    ("model", _model),
    ("model", _rims),
    ("model", _ghosts),
)
"""Layers, see :data:`~app.widgets.scene.content.LAYERS`, with what each draws."""

PARTS_ABOVE: tuple[tuple[str, Part], ...] = (
    ("ellipsoids", _ellipsoids),
    ("reference", _reference),
    ("", _inside),
)
"""The same of what is seen through everything else; what has no layer is always drawn."""


class Shown:
    """Draws what it is given in a renderer, with the same actors again and again."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._actors: list[pv.Actor] = []
        self._looks: list[dict[str, Any]] = []
        self._things: list[Drawn] = []

    def show(self, things: list[Drawn], scale: float) -> None:
        """Draw these, with `scale` pixels of the picture for a device-independent one."""
        while len(self._actors) < len(things):
            self._actors.append(pv.Actor(mapper=pv.DataSetMapper(pv.PolyData())))
            self._actors[-1].pickable = False
            self._renderer.add_actor(self._actors[-1], render=False)
            self._looks.append({"mesh": None, "image": None})
        for place, actor in enumerate(self._actors):
            actor.visibility = place < len(things)
        for actor, known, thing in zip(self._actors, self._looks, things, strict=False):
            if thing.mesh is not known["mesh"]:
                actor.mapper.dataset = known["mesh"] = thing.mesh
                actor.mapper.scalar_visibility = thing.colour is None
                if thing.colour is None:
                    actor.mapper.color_mode = "direct"
            if thing.image is not known["image"]:
                actor.texture = _texture(thing.image, actor.texture)
                known["image"] = thing.image
            width = {"line_width": thing.width * scale, "point_size": thing.size * scale}
            colour = {} if thing.colour is None else {"color": thing.colour}
            for name, value in (_PLAIN | width | colour | dict(thing.look)).items():
                if known.get(name) != value:  # setting them all takes its time
                    setattr(actor.prop, name, value)
                    known[name] = value
        self._things = things

    def set_dots_to(self, pixels_per_metre: float, scale: float) -> None:
        """Let dots be as large as what they stand for, within what can be told apart."""
        for actor, known, thing in zip(self._actors, self._looks, self._things, strict=False):
            if thing.metres:
                low, high = thing.limits
                size = np.clip(thing.metres * pixels_per_metre, scale * low, scale * high)
                actor.prop.point_size = known["point_size"] = float(size)


_PLAIN: dict[str, object] = {
    "lighting": False, "opacity": 1.0, "style": "surface", "culling": "none",
    "vertex_visibility": False, "render_points_as_spheres": False,
}  # fmt: skip
"""Properties that not all drawings state, as they are where one does not."""


def limb_at(meshes: tuple[PartMesh, ...], eye: FloatArray, direction: FloatArray) -> str:
    """Name the limb whose surface a ray meets first; empty where it meets none, or a leg.

    The ray leads from `eye` (3,), world, along `direction` (3,), which need not be normalised.
    """
    end = eye + _FAR * direction / np.linalg.norm(direction)
    hits = [(mesh.limb, _surface(mesh).ray_trace(eye, end, first_point=True)[0]) for mesh in meshes]
    far = [(float(np.linalg.norm(hit - eye)), limb) for limb, hit in hits if len(hit)]
    _, found = min(far, default=(np.inf, ""))
    return found if found in LIMB_COLOURS else ""


def _surface(mesh: PartMesh) -> pv.PolyData:
    return pv.PolyData.from_regular_faces(mesh.vertices, mesh.triangles)


def _body(meshes: Sequence[PartMesh], theme: Theme) -> pv.PolyData:
    """All parts as one surface, which is drawn faster than many, in their limbs' colours."""
    counts = [len(mesh.vertices) for mesh in meshes]
    starts = np.cumsum([0, *counts[:-1]])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    colours = [pv.Color(LIMB_COLOURS.get(mesh.limb, theme.disabled)).int_rgb for mesh in meshes]
    body = pv.PolyData.from_regular_faces(
        np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(triangles)
    )
    body.point_data.set_scalars(np.repeat(np.array(colours, np.uint8), counts, axis=0), "colour")
    return body


def _lines(points: FloatArray) -> pv.PolyData:
    """A line between each two of the points (2 L, 3)."""
    return pv.line_segments_from_points(points) if len(points) else pv.PolyData()


@cache
def _sphere() -> pv.PolyData:
    source = pv.SphereSource(radius=1.0, theta_resolution=12, phi_resolution=7)
    source.LatLongTessellationOn()
    return source.output


def _wire_of(vertices: FloatArray) -> FloatArray:
    """End points (2 L, 3) of rings and of four lines along the cone (S, V, 3), for all poses."""
    rings = vertices.reshape(len(vertices), -1, _RING, 3)[:, 1:-1]
    beside = np.roll(rings, -1, axis=2)
    around = np.stack([rings[:, [0, -1]], beside[:, [0, -1]]], axis=-2).reshape(-1, 3)
    quarter = rings[:, :, :: _RING // 4]
    along = np.stack([quarter[:, :-1], quarter[:, 1:]], axis=-2).reshape(-1, 3)
    return np.concatenate([around, along])


def _dashes(starts: FloatArray, ends: FloatArray) -> FloatArray:
    """End points (2 D, 3) of dashes of 2.5 cm along known lines; OpenGL has none."""
    pieces = [np.empty((0, 3))]
    for start, end in zip(starts, ends, strict=True):
        distance = float(np.linalg.norm(end - start))
        if np.isfinite(distance):
            count = max(1, round(distance / 0.05))
            shares = ((np.arange(count)[:, None] + (0.0, 0.55)) / count).ravel()
            pieces.append(start + shares[:, None] * (end - start))
    return np.concatenate(pieces)


def _texture(image: ImageArray | None, before: pv.Texture | None) -> pv.Texture | None:
    """The texture of an image; one that is there already is given the pixels, if they fit it."""
    if image is None:
        return None
    pixels = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
    if before is not None and before.dimensions == pixels.shape[1::-1]:
        before.to_image().active_scalars[:] = pixels[::-1].reshape(-1, 3)
        return before
    texture = pv.Texture(pixels)
    texture.interpolate = True
    return texture


_FINE_SAMPLES = 4


class SceneUnavailable(Exception):
    """There is no OpenGL to be had, in hardware or in software."""


def _choose_window() -> None:
    """Let VTK make windows of a kind that has OpenGL here.

    Its own choice ends in a crash where OSMesa is asked for and absent, and takes an X connection
    where there is one; EGL needs neither a display nor a library beside it.
    """
    if not sys.platform.startswith("linux"):
        return
    logger = vtk_module("vtkCommonCore").vtkLogger
    verbosity = logger.GetCurrentVerbosityCutoff()
    logger.SetStderrVerbosity(logger.VERBOSITY_OFF)
    try:
        for name in _kinds():
            kind = getattr(vtk_module("vtkRenderingOpenGL2"), name, None)
            if kind is None:
                continue
            window = kind()
            window.SetOffScreenRendering(True)
            if window.SupportsOpenGL():
                os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = name
                return
    finally:
        logger.SetStderrVerbosity(verbosity)
    raise SceneUnavailable("No OpenGL is available on this machine, not even in software.")


def _kinds() -> Iterator[str]:
    yield "vtkEGLRenderWindow"
    if os.environ.get("DISPLAY"):
        yield "vtkXOpenGLRenderWindow"
    with suppress(OSError):  # it asks a compiler, which writes to a drive that may be full
        if ctypes.util.find_library("OSMesa"):
            yield "vtkOSOpenGLRenderWindow"


class SceneRenderer:
    """Draws contents one after another with the same actors, what is above seen through the rest.

    Raises :class:`SceneUnavailable` if no OpenGL is to be had.
    """

    def __init__(self) -> None:
        _choose_window()
        self._plotter = pv.Plotter(off_screen=True, lighting="none")
        window, scene = self._plotter.render_window, self._plotter.renderer
        scene.add_light(pv.Light(light_type="headlight"))
        above = pv.Renderer(self._plotter, border=False)
        above.layer = window.GetNumberOfLayers()
        window.SetNumberOfLayers(above.layer + 1)
        window.AddRenderer(above)
        above.camera = scene.camera
        self._plotter.show(auto_close=False)
        self._shown = [
            (Shown(renderer), layer, part)
            for renderer, parts in ((scene, PARTS), (above, PARTS_ABOVE))
            for layer, part in parts
        ]
        self._scale = 1.0

    def set_content(
        self, content: SceneContent, layers: Mapping[str, bool], theme: Theme, scale: float
    ) -> None:
        self._scale = scale
        self._plotter.set_background(theme.scene_bottom, top=theme.scene_top)
        for shown, layer, part in self._shown:
            shown.show(part(content, theme) if layers.get(layer, True) else [], scale)

    def picture(self, width: int, height: int, orbit: Orbit, *, fine: bool = False) -> QImage:
        """Render at `width` by `height` pixels; `fine` smooths edges and takes longer."""
        per_metre = height / (2.0 * orbit.distance * np.tan(FIELD_OF_VIEW / 2))
        for shown, _, _ in self._shown:
            shown.set_dots_to(per_metre, self._scale)
        self._plotter.render_window.SetMultiSamples(_FINE_SAMPLES if fine else 0)
        camera = self._plotter.camera
        camera.view_angle = np.degrees(FIELD_OF_VIEW)
        camera.focal_point, camera.position, camera.up = orbit.focus, orbit.eye, orbit.up
        camera.clipping_range = (max(0.02, 0.01 * orbit.distance), orbit.distance + 30.0)
        self._plotter.window_size = (width, height)
        rows = np.ascontiguousarray(self._plotter.image)
        return QImage(rows.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()

    def close(self) -> None:
        """Give the OpenGL context back; nothing can be rendered afterwards."""
        self._plotter.close()
