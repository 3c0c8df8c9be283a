"""A render window of VTK that never shows itself, and its pictures."""

from __future__ import annotations

import ctypes.util
import os
import sys
from collections.abc import Iterator

import numpy as np
from PySide6.QtGui import QImage
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger, vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from .orbit import FIELD_OF_VIEW, Orbit

_FINE_SAMPLES = 4


class SceneUnavailable(Exception):
    """There is no OpenGL to be had, in hardware or in software."""


def _candidates() -> Iterator[vtkRenderWindow]:
    # The factory's own choice ends in a crash where OSMesa is asked for and absent, and takes
    # an X connection where there is one; EGL needs neither a display nor a library beside it.
    if not sys.platform.startswith("linux"):
        yield vtkRenderWindow()
        return
    yield from _made("vtkEGLRenderWindow")
    if os.environ.get("DISPLAY"):
        yield from _made("vtkXOpenGLRenderWindow")
    if _osmesa_is_there():
        yield from _made("vtkOSOpenGLRenderWindow")


def _made(name: str) -> Iterator[vtkRenderWindow]:
    kind = getattr(vtkRenderingOpenGL2, name, None)
    if kind is not None:
        yield kind()


def _osmesa_is_there() -> bool:
    try:
        return ctypes.util.find_library("OSMesa") is not None
    except OSError:  # it asks a compiler, which writes to a drive that may be full
        return False


def _usable_window() -> vtkRenderWindow:
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        for window in _candidates():
            window.SetOffScreenRendering(True)
            window.SetShowWindow(False)
            if window.SupportsOpenGL():
                return window
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
    raise SceneUnavailable("OpenGL is not to be had on this machine, not even in software.")


class SceneWindow:
    """Renders what its two layers hold into pictures.

    Attributes
    ----------
    scene : vtkRenderer
        Bodies, points and floor, which hide each other.
    above : vtkRenderer
        What is seen through everything, such as the reference.

    Raises
    ------
    SceneUnavailable
        If no OpenGL is to be had.
    """

    def __init__(self) -> None:
        self._window = _usable_window()
        self._window.SetMultiSamples(0)
        self._window.SetNumberOfLayers(2)
        self.scene = vtkRenderer()
        self.above = vtkRenderer()
        self.above.SetLayer(1)
        self.above.SetActiveCamera(self.scene.GetActiveCamera())
        self.scene.SetGradientBackground(True)
        self._window.AddRenderer(self.scene)
        self._window.AddRenderer(self.above)
        self._pixels = vtkUnsignedCharArray()

    def set_background(self, top: str, bottom: str) -> None:
        """Colours of the gradient behind everything, as #rrggbb."""
        self.scene.SetBackground(*unit_rgb(bottom))
        self.scene.SetBackground2(*unit_rgb(top))

    def picture(self, width: int, height: int, orbit: Orbit, *, fine: bool = False) -> QImage:
        """Render at `width` by `height` pixels; `fine` smooths edges and takes longer."""
        self._window.SetMultiSamples(_FINE_SAMPLES if fine else 0)
        self._window.SetSize(width, height)
        self._place_eye(orbit)
        self._window.Render()
        self._window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, self._pixels, 0)
        rows = vtk_to_numpy(self._pixels).reshape(height, width, 4)
        upright = np.ascontiguousarray(rows[::-1])
        image = QImage(upright.data, width, height, 4 * width, QImage.Format.Format_RGBX8888)
        return image.copy()

    def close(self) -> None:
        """Give the OpenGL context back; nothing can be rendered afterwards."""
        self._window.Finalize()

    def _place_eye(self, orbit: Orbit) -> None:
        camera = self.scene.GetActiveCamera()
        camera.SetViewAngle(np.degrees(FIELD_OF_VIEW))
        camera.SetFocalPoint(*orbit.focus)
        camera.SetPosition(*orbit.eye)
        camera.SetViewUp(*orbit.up)
        camera.SetClippingRange(max(0.02, 0.01 * orbit.distance), orbit.distance + 30.0)


def unit_rgb(colour: str) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 of #rrggbb."""
    return (
        int(colour[1:3], 16) / 255,
        int(colour[3:5], 16) / 255,
        int(colour[5:7], 16) / 255,
    )
