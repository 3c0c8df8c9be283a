"""Compiled loops: numba is loaded at the first call, and the functions they call are compiled."""

from __future__ import annotations

import subprocess
import sys

from stereotrack_core.compiled import compiled


@compiled(inline="always")
def _next(x):
    """One more."""
    return x + 1


@compiled()
def _count(x, upto):
    while x < upto:
        x = _next(x)
    return x


def test_a_loop_calls_another_and_both_are_compiled():
    assert _count(2, 7) == 7
    assert _count.machine().signatures, "numba has compiled it"
    assert _next(1) == 2
    assert _next.__doc__ == "One more."


def test_decorating_does_not_load_numba():
    script = "import sys, stereotrack_core.tracking.tracker; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n"
