"""Small hot loops compiled by numba, which is loaded when the first of them is called."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Any, TypeVar, cast

_FunctionT = TypeVar("_FunctionT", bound=Callable[..., Any])
_lock = threading.RLock()


def load_before_threads() -> None:
    """Load what two threads must not load at once; called before the first of them is started.

    Numba loads the package ``scipy.linalg``, and ``scipy.special`` a module of it, each holding
    what the other waits for: Python ends one of them with an error.
    """
    import scipy.linalg  # noqa: F401


def compiled(**options: Any) -> Callable[[_FunctionT], _FunctionT]:
    """Compile a function at its first call, and keep the machine code on the drive.

    It runs without the interpreter's lock and without fast-math, so that results are repeatable.
    Decorating costs nothing: loading numba takes about as long as making the window, and many
    modules that the window needs at its start hold a loop for later.

    Parameters
    ----------
    options : more arguments of ``numba.njit``
    """

    def decorate(function: _FunctionT) -> _FunctionT:
        return cast(_FunctionT, _Compiled(function, options))

    return decorate


class _Compiled:
    """A function that numba knows nothing of until it is called."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self._function, self._options = function, options
        self._machine: Callable[..., Any] | None = None

    def __call__(self, *args: Any) -> Any:
        return (self._machine or self.machine())(*args)

    def machine(self) -> Callable[..., Any]:
        """What numba makes of it, made once.

        The names in its module that stand for such functions are given what numba makes of these,
        since numba compiles calls of its own functions only.
        """
        with _lock:
            if self._machine is None:
                import numba

                names = self._function.__globals__
                for name in self._function.__code__.co_names:
                    if isinstance(called := names.get(name), _Compiled):
                        names[name] = called.machine()
                self._machine = numba.njit(cache=True, nogil=True, **self._options)(self._function)
            return self._machine
