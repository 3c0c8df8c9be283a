"""Which versions of this program and of what it computes with are running."""

import importlib
import platform
import sys
from functools import cache
from importlib.util import find_spec
from types import ModuleType

import cv2
import numpy as np

from stereotrack_core.errors import InputError
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


def extra_library(module: str, extra: str, *, missing: str, where: str, instead: str) -> ModuleType:
    """A library that not everybody installs. Raises InputError where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise _not_installed(extra, missing, where, instead) from None


def check_library(module: str, extra: str, *, missing: str, where: str, instead: str) -> None:
    """The same without loading it, for what another process will do with it."""
    if find_spec(module) is None:
        raise _not_installed(extra, missing, where, instead)


def _not_installed(extra: str, missing: str, where: str, instead: str) -> InputError:
    remedy = f"Install it with `pip install 'stereotrack[{extra}]'`, or use {instead}."
    if getattr(sys, "frozen", False):  # nothing can be installed into it
        remedy = f"The stand-alone program does not have it. {remedy}"
    return InputError(missing, where, remedy)


@cache  # it reads and parses a file
def _installed(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # loads half of `email`

    try:
        return version(package)
    except PackageNotFoundError:  # put together without its list of packages
        return "unknown"
