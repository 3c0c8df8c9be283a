"""Runs that were under way in a project when the program ended: found again and kept."""

from __future__ import annotations

import contextlib
import glob
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.file_lock import take_lock
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import PART_SUFFIX
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import free_name, keep_run, kept_runs
from stereotrack_core.tracking.frame import Run


def place_for_run(project: Path) -> Path:
    """A new file beside a project, for the frames of a run that is being tracked."""
    number = 1
    while (path := project.with_name(f"{project.name}.run{number}{PART_SUFFIX}")).exists():
        number += 1
    return path


def unfinished_runs(project: Path) -> tuple[Path, ...]:
    """Files of runs that nobody is tracking any more, by their names."""
    pattern = f"{glob.escape(project.name)}.run*{PART_SUFFIX}"
    return tuple(path for path in sorted(project.parent.glob(pattern)) if _is_left(path))


@dataclass(frozen=True)
class TakenIn:
    """A run that the project keeps now.

    Attributes
    ----------
    name : str
    last : int
        Its last frame.
    """

    name: str
    last: int


def take_in(project: Project, path: Path) -> TakenIn | None:
    """Keep a run that was under way, and remove its file; None where there is nothing to keep.

    Raises
    ------
    InputError
        Where the file holds something else, or the project cannot be written to; it stays then.
    """
    run = read_run(path)
    taken = None
    if len(run.frame) and not _is_kept(project, run):
        last = int(run.frame[-1])
        taken = TakenIn(free_name(project.runs, f"interrupted at frame {last}"), last)
        project.apply(keep_run(taken.name, run))
    path.unlink(missing_ok=True)
    return taken


def _is_kept(project: Project, run: Run) -> bool:
    """Whether the project has the run, because the program was killed just after keeping it."""
    known = [kept.facts for kept in kept_runs(project.runs)]
    return any(one.made == run.meta["made"] and one.frames >= len(run.frame) for one in known)


def _is_left(path: Path) -> bool:
    with contextlib.suppress(OSError), path.open("r+b") as file:
        take_lock(file)
        return True
    return False
