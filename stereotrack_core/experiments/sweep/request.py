"""What somebody asks a sweep for: in the window's dialog, or on the command line."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import InputError

TRIALS = 30
_PROGRAM = (
    "import runpy, sys; sys.path[:] = {path!r}; "
    "runpy.run_module('stereotrack_core', run_name='__main__', alter_sys=True)"
)


@dataclass(frozen=True)
class SweepRequest:
    """A sweep in the words of a person; see ``stereotrack sweep --help``.

    Attributes
    ----------
    recordings : tuple of Path
    table : Path
        Where the results go.
    grid, search : tuple of str
        ``NAME=a,b,c`` and ``NAME=LOW:HIGH``.
    points : Path or None
        A list of points; at most one of grid, list and search is given.
    trials, search_seed : int
        Points that a search tries, and its seed.
    minimise : str or None
        Measure that says which point is best; None: the usual one.
    preset : str
    changes : tuple of str
        ``NAME=VALUE`` for what differs from the preset.
    seeds : str
    frames, views : str or None
        None: all.
    init : str
    smooth : bool
    workers, together : int or None
        Processes on this machine, and jobs that one does together; None: as many as is good.
    scheduler : str or None
        Address of a Dask cluster; None: this machine.
    retries : int
    again : bool
        Compute also what is in the table already.
    """

    recordings: tuple[Path, ...]
    table: Path
    grid: tuple[str, ...] = ()
    points: Path | None = None
    search: tuple[str, ...] = ()
    trials: int = TRIALS
    search_seed: int = 0
    minimise: str | None = None
    preset: str = "accurate"
    changes: tuple[str, ...] = ()
    seeds: str = "0"
    frames: str | None = None
    views: str | None = None
    init: str = "auto"
    smooth: bool = False
    workers: int | None = None
    together: int | None = None
    scheduler: str | None = None
    retries: int = 1
    again: bool = False

    def check(self) -> None:
        """Refuse what does not go together, and numbers that mean nothing.

        Raises
        ------
        InputError
        """
        least = {"workers": 1, "together": 1, "trials": 1, "retries": 0, "search_seed": 0}
        for name, low in least.items():
            value = getattr(self, name)
            if value is not None and value < low:
                option = f"--{name.replace('_', '-')}"
                raise InputError(
                    f"{value} is less than {low}", where=option, remedy=f"Give {low} or more."
                )
        if sum(map(bool, (self.grid, self.points, self.search))) > 1:
            raise InputError(
                "a sweep uses a grid, a list or a search",
                where="--grid, --list, --search",
                remedy="Use only one of them.",
            )
        if self.scheduler and self.workers is not None:
            raise InputError(
                "a sweep runs on this machine or on a cluster",
                where="--workers, --scheduler",
                remedy="Use only one of them.",
            )
        if self.table.suffix.lower() != ".csv":
            raise InputError(
                "the table must be a CSV file",
                where=str(self.table),
                remedy="Use a name that ends in .csv.",
            )

    def arguments(self) -> list[str]:
        """The command that does the sweep."""
        words = ["sweep", *map(str, self.recordings), "-o", str(self.table)]
        lists = {"--grid": self.grid, "--search": self.search, "--set": self.changes}
        words += [word for option, texts in lists.items() for text in texts
                  for word in (option, text)]  # fmt: skip
        values = {
            "--list": self.points, "--minimise": self.minimise, "--preset": self.preset,
            "--seeds": self.seeds, "--frames": self.frames, "--views": self.views,
            "--init": self.init, "--workers": self.workers, "--together": self.together,
            "--scheduler": self.scheduler, "--retries": self.retries,
        }  # fmt: skip
        if self.search:
            values |= {"--trials": self.trials, "--search-seed": self.search_seed}
        words += [
            word
            for option, value in values.items()
            if value is not None
            for word in (option, str(value))
        ]
        flags = {"--smooth": self.smooth, "--again": self.again}
        return [*words, *(option for option, asked in flags.items() if asked)]


def program_command(arguments: Sequence[str]) -> list[str]:
    """What to start so that the command line does this in a process of its own."""
    return [sys.executable, "-c", _PROGRAM.format(path=sys.path), *arguments]
