"""Runs and trajectories in files, by the suffix of their name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop.bvh import write_bvh
from stereotrack_core.interop.c3d import read_c3d, write_c3d
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.motion.netcdf import write_netcdf
from stereotrack_core.interop.reference_npz import (
    fps_of_reference,
    is_reference,
    read_reference,
    read_reference_table,
)
from stereotrack_core.interop.run_journal import PART_SUFFIX, read_unfinished
from stereotrack_core.interop.run_npz import check_run, read_npz, write_npz
from stereotrack_core.interop.trc import read_trc, write_trc
from stereotrack_core.reading import check_file
from stereotrack_core.recording.landmarks import LandmarkTrajectory, read_landmarks, write_landmarks
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import fps_of_run, upright_run

Timed: TypeAlias = tuple[LandmarkTrajectory, float | None]
"""A trajectory, with frames per second where the file states them."""


def _read_archive(path: Path) -> Timed:
    if is_reference(path):
        reference = read_reference(path)
        return reference.trajectory(), fps_of_reference(reference)
    return _read_timed_run(path)


def _read_timed_run(path: Path) -> Timed:
    run = read_run(path)
    return run.trajectory(), fps_of_run(run) if "fps" in run.meta else None


_READERS: Mapping[str, Callable[[Path], Timed]] = {
    ".npz": _read_archive,
    ".csv": lambda path: (read_landmarks(path), None),
    PART_SUFFIX: _read_timed_run,
}
"""What landmarks are read from that have this program's names and axes."""

_FOREIGN: Mapping[str, Callable[[Path, Stated | None], Timed]] = {
    ".trc": read_trc,
    ".c3d": read_c3d,
}
"""What they are read from with the names and axes of other programs."""

_WRITERS: Mapping[str, Callable[[Path, LandmarkTrajectory, float], None]] = {
    ".trc": write_trc,
    ".c3d": write_c3d,
    ".bvh": write_bvh,
    ".nc": write_netcdf,
}
"""What landmarks can be written as that states a frame rate."""

RUN_SUFFIXES: tuple[str, ...] = (".npz", ".csv", ".trc", ".c3d", ".bvh")
"""What a run can be written as by what everybody has; only ``.npz`` keeps all of it."""


def run_suffix(path: Path) -> str:
    """The suffix that says how a run is written.

    InputError for a suffix that is not in :data:`RUN_SUFFIXES`.
    """
    return _suffix(path, RUN_SUFFIXES)


def write_run(path: Path, run: Run) -> None:
    """Write a run completely (.npz) or its landmarks (.csv, .trc, .c3d, .bvh).

    The last three state which axis points up, and get one that does.

    Raises InputError for an unknown suffix, a place that cannot be written to, or where the format
    needs a frame rate that the run's ``meta["fps"]`` does not state.

    Examples
    --------
    >>> write_run(Path("run.npz"), run)
    >>> write_run(Path("landmarks.trc"), run)
    """
    path = Path(path)
    if run_suffix(path) == ".npz":
        write_npz(path, run)
    else:
        own_world = path.suffix.lower() == ".csv"
        fps = None if own_world else fps_of_run(run)
        trajectory = (run if own_world else upright_run(run)).trajectory()
        write_trajectory(path, trajectory, fps, run.residual)


def write_trajectory(
    path: Path,
    trajectory: LandmarkTrajectory,
    fps: float | None,
    residual: FloatArray | None = None,
) -> None:
    """Write landmarks (.csv, .trc, .c3d, .bvh, .nc).

    `fps`: frames per second; only ``.csv`` needs none. `residual` (F,), metres, kept by ``.c3d``
    alone.

    Raises InputError for another suffix, a place that cannot be written to, or a missing frame
    rate.
    """
    suffix = _suffix(path, (".csv", *_WRITERS))
    if suffix == ".csv":
        write_landmarks(path, trajectory)
    elif fps is None:
        raise InputError(
            "the frame rate is not known",
            where=str(path),
            remedy="Give it, for example with --fps 30, or use .csv, which needs none.",
        )
    elif suffix == ".c3d":
        write_c3d(path, trajectory, fps, residual)
    else:
        _WRITERS[suffix](path, trajectory, fps)


def holds_run(path: Path) -> bool:
    """Whether a file holds a run with all of its numbers, by its suffix; not what is in it."""
    suffix = Path(path).suffix.lower()
    return suffix == PART_SUFFIX or (suffix == ".npz" and not is_reference(path))


def read_run(path: Path) -> Run:
    """Read a run with all of its numbers; one that was stopped says so in its meta.

    Raises InputError for a file that is not a complete run.

    Examples
    --------
    >>> run = read_run(Path("run.npz"))
    >>> run.landmarks.shape  # frames, nine landmarks, x y z in metres
    (100, 9, 3)
    """
    path = Path(path)
    check_file(path)
    if path.suffix.lower() == PART_SUFFIX:
        run = read_unfinished(path)[0].run()
        check_run(path, run)
        return run
    if path.suffix.lower() != ".npz":
        raise InputError(
            "this file is not a complete run",
            where=str(path),
            remedy="Use an .npz file written by `stereotrack track`.",
        )
    return read_npz(path)


def read_trajectory(path: Path, stated: Stated | None = None) -> LandmarkTrajectory:
    """Landmarks of a run, a reference (.npz) or a landmarks file (.csv, .trc, .c3d).

    `stated`: names and axes of a file of another program (.trc, .c3d).

    InputError for an unknown suffix, a damaged file, or something stated about another format.
    """
    return read_timed_trajectory(path, stated)[0]


def read_timed_trajectory(path: Path, stated: Stated | None = None) -> Timed:
    """The same, with frames per second where the file states them."""
    path = Path(path)
    suffix = _suffix(path, (*_READERS, *_FOREIGN))
    if suffix in _FOREIGN:
        return _FOREIGN[suffix](path, stated)
    if _says_something(stated):
        raise InputError(
            "landmark names and axes can only be given for .trc and .c3d files",
            where=str(path),
            remedy="Omit --name and --axes.",
        )
    return _READERS[suffix](path)


def _says_something(stated: Stated | None) -> bool:
    return stated is not None and bool(stated.names or stated.world_from_file is not None)


def _suffix(path: Path, known: tuple[str, ...]) -> str:
    suffix = path.suffix.lower()
    if suffix not in known:
        raise InputError(
            f"unknown suffix {path.suffix!r}" if suffix else "the name has no suffix",
            where=str(path),
            remedy=f"Use a name that ends in {', '.join(known[:-1])} or {known[-1]}.",
        )
    return suffix


def reference_in(path: Path, stated: Stated | None = None) -> Reference:
    """The reference that a file of a trajectory holds; InputError where it cannot be read."""
    if is_reference(path):
        return read_reference(path)
    if path.suffix.lower() == ".csv" and not _says_something(stated):
        return read_reference_table(path)
    trajectory = read_trajectory(path, stated)
    return Reference(trajectory.frame, trajectory.points, meta={"imported_from": path.name})
