"""Which versions of this program and of what it computes with are running."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

import cv2
import numpy as np

from stereotrack_core.version import __version__


def versions() -> dict[str, str]:
    """Versions by name: what the numbers of a run can depend on besides its parameters."""
    return {
        "stereotrack": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": _installed("scipy"),
        "opencv": str(cv2.__version__),
        "numba": _installed("numba"),
        "machine": platform.machine(),
    }


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # put together without its list of packages
        return "unknown"
