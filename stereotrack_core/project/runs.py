"""Runs in a project: kept complete, listed and compared without reading them, named."""

import contextlib
import glob
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain, count
from pathlib import Path
from typing import Any, NamedTuple

from stereotrack_core.arrays import IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import PART_SUFFIX, has_frames
from stereotrack_core.interop.run_npz import run_bytes, run_of_bytes
from stereotrack_core.locks import take_lock
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.entries import (
    Entries,
    delete_entry,
    facts_as_json,
    row_of,
    save_entry,
)
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import RUN
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import changed_parameters

_META = ("preset", "seed", "views", "init", "smoothed", "wall_seconds", "made")


@dataclass(frozen=True)
class RunFacts:
    """A run in a list, with its frames and those tracked; unknown is empty or None."""

    frames: int = 0
    tracked: int = 0
    first: int | None = None
    last: int | None = None
    preset: str = ""
    changed: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)  # preset's, run's
    seed: int | None = None
    views: tuple[str, ...] = ()
    init: str = ""  # where the first pose came from
    smoothed: bool = False
    detector: str = ""  # that looked at the pictures, or whose keypoints were used
    wall_seconds: float | None = None
    made: str = ""  # when it was tracked, ISO 8601, UTC

    @property
    def changed_words(self) -> str:
        """``iterations 2 instead of 6, data_points 400 instead of 800``; empty where none is."""
        told = (f"{name} {_text(b)} instead of {_text(a)}" for name, (a, b) in self.changed.items())
        return ", ".join(told)


_READERS: Mapping[str, Any] = {
    **dict.fromkeys(("frames", "tracked", "first", "last", "seed"), int),
    **dict.fromkeys(("preset", "init", "made", "detector"), str),
    "changed": lambda values: {name: (a, b) for name, (a, b) in dict(values).items()},
    "views": lambda names: tuple(str(name) for name in names),
    "smoothed": bool,
    "wall_seconds": float,
}
"""How the facts are made of what was kept, by name."""


def facts_of_meta(meta: Mapping[str, Any], frame: IntArray, tracked: int) -> dict[str, Any]:
    """Facts for :func:`run_facts` from a run's meta, frames (F,), and number of poses."""
    facts: dict[str, Any] = {"frames": len(frame), "tracked": tracked}
    facts |= {key: meta[key] for key in _META if key in meta}
    if len(frame):
        facts |= {"first": int(frame[0]), "last": int(frame[-1])}
    sources = dict(meta.get("keypoints") or {}).get("sources", ())
    if detector := meta.get("detector") or ", ".join(sources):
        facts["detector"] = detector
    if meta.get("parameters"):
        changed = changed_parameters(meta["parameters"], str(meta.get("preset", "")))
        facts["changed"] = {name: list(values) for name, values in changed.items()}
    return facts


def run_facts(stored: Mapping[str, Any]) -> RunFacts:
    """Read facts as they were kept, perhaps by others. Raises ValueError and the like."""
    there = {name: read for name, read in _READERS.items() if stored.get(name) is not None}
    return RunFacts(**{name: read(stored[name]) for name, read in there.items()})


def _text(value: Any) -> str:
    if value is None or value == "":
        return "unknown"
    if isinstance(value, bool):
        return "yes" if value else "no"
    short = f"{value:g}" if isinstance(value, float) else str(value)
    return short if not isinstance(value, float) or float(short) == value else repr(value)


@dataclass(frozen=True)
class KeptRun:
    """A run of a project without its numbers, whose hash tells runs apart."""

    name: str
    content: str
    who: str
    at: str
    facts: RunFacts


def keep_run(name: str, run: Run) -> Edit:
    """The edit that puts a complete run into the project, under a :func:`free_name` if wanted."""
    facts = facts_of_meta(run.meta, run.frame, int(run.tracked.sum()))
    return save_entry(RUN, name, facts_as_json(facts), run_bytes(run))


def delete_run(name: str) -> Edit:
    """The edit that takes a run out of the list; :func:`restore_run` brings it back."""
    return delete_entry(RUN, name)


def removed_runs(runs: Entries) -> tuple[str, ...]:
    """Names of the runs that were removed and can be restored, the last one removed last."""
    return tuple(one.name for one in runs.all(with_deleted=True) if one.deleted)


def restore_run(name: str) -> Edit:
    """Bring back a run that was removed."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        row = state.row(RUN, (name,))
        if row is None or not row[-1]:
            raise InputError(f"no run {name!r} was removed", remedy="Choose another one.")
        yield Change(RUN, (name,), row, (*row[:2], stamp.who, stamp.at, 0))

    return Edit("restore", f"restore run {name}", changes)


def load_run(runs: Entries, name: str) -> Run:
    """A run of the project, bit by bit as it was kept. Raises InputError, ProjectDamaged."""
    data = runs.data(name)
    with making_sense(runs.path):
        return run_of_bytes(data, name)


def kept_runs(runs: Entries) -> tuple[KeptRun, ...]:
    """All runs of a project without their numbers, oldest first. Raises ProjectDamaged."""
    entries = [entry for entry in runs.all() if entry.content is not None]
    with making_sense(runs.path):
        return tuple(
            KeptRun(entry.name, str(entry.content), entry.who, entry.at, run_facts(entry.facts))
            for entry in entries
        )


def free_name(runs: Entries, wanted: str) -> str:
    """`wanted`, or with a number where a run has that name, or had it before it was deleted."""
    taken = {entry.name for entry in runs.all(with_deleted=True)}
    stem = wanted.strip() or "run"
    names = chain([stem], (f"{stem} ({number})" for number in count(2)))
    return next(name for name in names if name not in taken)


def rename_run(name: str, new: str) -> Edit:
    """Give a run another name; who kept it and when stay."""

    def changes(state: State, _stamp: Stamp) -> Iterable[Change]:
        row = row_of(state, RUN, name)
        if not new.strip():
            raise InputError("the run has no name", remedy="Give it one.")
        if new == name:
            return
        there = state.row(RUN, (new,))
        if there is not None and not there[-1]:
            raise InputError(f"there already is a run {new!r}", remedy="Choose another name.")
        yield Change(RUN, (name,), row, None)
        yield Change(RUN, (new,), there, row)

    return Edit("rename", f"rename run {name} to {new}", changes)


def place_for_run(project: Path) -> Path:
    """A new file beside a project, for the frames of a run that is being tracked."""
    places = (project.with_name(f"{project.name}.run{k}{PART_SUFFIX}") for k in count(1))
    return next(path for path in places if not path.exists())


def unfinished_runs(project: Path) -> tuple[Path, ...]:
    """Files of runs that nobody is tracking any more, by their names."""
    left = []
    for path in sorted(project.parent.glob(f"{glob.escape(project.name)}.run*{PART_SUFFIX}")):
        with contextlib.suppress(OSError), path.open("r+b") as file:
            take_lock(file)
            left.append(path)
    return tuple(left)


class TakenIn(NamedTuple):
    """A run that the project keeps now, and its last frame."""

    name: str
    last: int


def take_in(project: Project, path: Path) -> TakenIn | None:
    """Keep a run that was under way and remove its file, or None without frames.

    Raises InputError where it holds something else or cannot be kept; it stays then.
    """
    if not has_frames(path):  # killed before the first one
        path.unlink(missing_ok=True)
        return None
    run, taken = read_run(path), None
    known = [kept.facts for kept in kept_runs(project.runs)]
    # the program may have been killed just after keeping it
    kept = any(one.made == run.meta["made"] and one.frames >= len(run.frame) for one in known)
    if len(run.frame) and not kept:
        last = int(run.frame[-1])
        made = ", ".join(filter(None, (run.meta.get("preset"), f"interrupted at frame {last}")))
        taken = TakenIn(free_name(project.runs, made), last)
        project.apply(keep_run(taken.name, run))
    path.unlink(missing_ok=True)
    return taken
