"""The scene as pictures: layers that follow the content, in a plotter that never shows itself."""

import ctypes.util
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np
import pyvista as pv
from PySide6.QtGui import QImage
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkCommonCore import vtkLogger

from ..style.theme import Theme
from .content import SceneContent
from .drawing import PARTS, PARTS_ABOVE, Shown
from .orbit import FIELD_OF_VIEW, Orbit

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
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        for name in _kinds():
            kind = getattr(vtkRenderingOpenGL2, name, None)
            if kind is None:
                continue
            window = kind()
            window.SetOffScreenRendering(True)
            if window.SupportsOpenGL():
                os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = name
                return
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
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
        self._place_eye(orbit)
        self._plotter.window_size = (width, height)
        rows = np.ascontiguousarray(self._plotter.image)
        return QImage(rows.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()

    def close(self) -> None:
        """Give the OpenGL context back; nothing can be rendered afterwards."""
        self._plotter.close()

    def _place_eye(self, orbit: Orbit) -> None:
        camera = self._plotter.camera
        camera.view_angle = np.degrees(FIELD_OF_VIEW)
        camera.focal_point = orbit.focus
        camera.position = orbit.eye
        camera.up = orbit.up
        camera.clipping_range = (max(0.02, 0.01 * orbit.distance), orbit.distance + 30.0)
