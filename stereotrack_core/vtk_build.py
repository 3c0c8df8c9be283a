"""VTK, in the build that pyvista draws with."""

import importlib
import importlib.util
from typing import Any


def vtk_module(name: str) -> Any:
    """Module of VTK, such as ``vtkCommonCore``.

    pyvista prefers `cvista` where that is installed: its makers' build, a third as large, which
    the folder without Python has. Two builds in one process know nothing of each other's objects.
    """
    if importlib.util.find_spec("cvista") is not None:
        return importlib.import_module(f"cvista.{name}")
    import vtkmodules

    return importlib.import_module(f"{vtkmodules.__name__}.{name}")
