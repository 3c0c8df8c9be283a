"""Small hot loops compiled by numba, which is loaded when the first of them is called."""

import functools
import hashlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from types import CodeType, ModuleType
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
    """Compile a function at its first call, with options of ``numba.njit``, and keep the machine
    code.

    It runs without the interpreter's lock and without fast-math, so that results are repeatable.
    A number divided by 0 is infinite or NaN: a check of each division takes a tenth of the time.
    Decorating costs nothing: loading numba takes about as long as making the window, and many
    modules that the window needs at its start hold a loop for later.
    """

    def decorate(function: _FunctionT) -> _FunctionT:
        return cast(_FunctionT, _Compiled(function, {"error_model": "numpy", **options}))

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
        """Numba's version of the function, made once.

        Numba compiles calls of its own functions only, so those that this one calls are replaced in
        its module by numba's versions of them.
        """
        with _lock:
            if self._machine is None:
                import numba

                folder = self._cache_folder()
                names = self._function.__globals__
                for name in _names(self._function.__code__):
                    if isinstance(called := names.get(name), _Compiled):
                        names[name] = called.machine()
                chosen, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder or "")
                try:
                    compiler = numba.njit(cache=folder is not None, nogil=True, **self._options)
                    self._machine = compiler(self._function)
                finally:
                    numba.config.CACHE_DIR = chosen
                _digests[self._function] = self.digest
            return self._machine

    @functools.cached_property
    def digest(self) -> str:
        """Digest of all that is compiled: its code, and the functions and values that it names.

        Numba itself looks at the file of the function alone, and would go on with machine code that
        holds a former version of a function or a constant of another module. The digest is made of
        what is loaded and not of files, which may have changed since. Processor and types stand in
        numba's own index.
        """
        import numba  # noqa: F401 - it loads the others

        names = self._function.__globals__
        named = [(n, _identity(names[n])) for n in _names(self._function.__code__) if n in names]
        versions = [sys.modules[name].__version__ for name in ("llvmlite", "numba", "numpy")]
        code = _code_identity(self._function.__code__), self._function.__defaults__
        text = repr((versions, self._options, code, named))
        return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()

    def _cache_folder(self) -> Path | None:
        """Make the folder of this version's machine code; None if none can be written to."""
        folder = _all_folders()
        if folder is None:
            return None
        folder /= self.digest
        with suppress(OSError):
            folder.mkdir(exist_ok=True)
        return folder


_digests: dict[Callable[..., Any], str] = {}
"""Digests of functions that are replaced in their modules by numba's versions of them."""


def _codes(code: CodeType) -> Iterator[CodeType]:
    """The code of a function, and of those within it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _names(code: CodeType) -> list[str]:
    """Global names that a function may use, in a fixed order."""
    return sorted({name for one in _codes(code) for name in one.co_names})


def _code_identity(code: CodeType) -> list[object]:
    """All that the meaning of a function's code depends on, the same in every process."""
    parts = list[object]()
    for one in _codes(code):
        constants = [c for c in one.co_consts if not isinstance(c, CodeType)]
        names = one.co_names, one.co_varnames, one.co_freevars, one.co_cellvars
        parts += [one.co_code, one.co_argcount, one.co_flags, constants, names]
    return parts


def _identity(value: Any) -> object:
    """A global value as the digest takes it in every process; TypeError if changes go unnoticed."""
    import numpy as np

    if isinstance(value, _Compiled):
        return value.digest
    if (function := getattr(value, "py_func", None)) in _digests:
        return _digests[function]
    if isinstance(value, ModuleType):
        if not value.__name__.startswith("stereotrack"):
            return value.__name__
    elif isinstance(value, np.ndarray):
        return value.dtype.descr, value.shape, value.tobytes()
    elif isinstance(value, bool | int | float | str | np.generic | np.dtype):
        return repr(value)
    elif isinstance(value, tuple):
        return [_identity(part) for part in value]
    raise TypeError(f"a compiled function uses {value!r}, and changes of that would go unnoticed")


@functools.cache
def _all_folders() -> Path | None:
    """Folder that holds a folder for each version of each function; None if none can be written."""
    import numba
    import platformdirs

    if chosen := numba.config.CACHE_DIR:
        places = [Path(chosen)]
    else:
        user = platformdirs.user_cache_path("stereotrack", appauthor=False)
        places = [Path(__file__).parent / "__pycache__", user]
    for place in places:
        folder = place / "compiled"
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None
