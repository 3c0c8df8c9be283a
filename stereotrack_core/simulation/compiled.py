"""Numba with one setting for all kernels: cached on disk, free of the interpreter's lock."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


def compiled(function: FunctionT) -> FunctionT:
    """Compile a kernel of the renderer; without fast-math, so that results are repeatable."""
    return cast(FunctionT, numba.njit(cache=True, nogil=True)(function))
