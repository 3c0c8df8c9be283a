"""Runs and trajectories in files, by the suffix of their name, and where their recording is."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop import reference_npz
from stereotrack_core.interop.bvh import write_bvh
from stereotrack_core.interop.c3d import read_c3d, write_c3d
from stereotrack_core.interop.landmark_file import FileAxes, Stated
from stereotrack_core.interop.markers import Markers, landmarks_in_world
from stereotrack_core.interop.run_journal import PART_SUFFIX, read_unfinished
from stereotrack_core.interop.run_npz import check_run, read_meta, read_npz, write_npz
from stereotrack_core.interop.trc import read_trc, write_trc
from stereotrack_core.reading import check_file
from stereotrack_core.recording import landmarks
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import DESCRIPTION, describe, fingerprint
from stereotrack_core.recording.frame_times import stated_fps
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import upright_run


def _read_archive(path: Path, stated: Stated) -> landmarks.LandmarkTrajectory:
    if stated.about_file:
        raise unstatable(path)
    read = reference_npz.read_reference if reference_npz.is_reference(path) else read_run
    return read(path).trajectory()


def _read_table(path: Path, stated: Stated) -> landmarks.LandmarkTrajectory:
    """Landmarks of a table, whose axes are those of the world unless others are stated."""
    trajectory = landmarks.read_landmarks(path)
    if stated.names:
        raise unstatable(path)
    axes = FileAxes(stated.up.rotation, "as usual in tables of landmarks")
    markers = Markers(landmarks.LANDMARKS, trajectory.points, axes, path, "landmark")
    points, (axes_taken, *_) = landmarks_in_world(markers, stated)
    notes = () if stated.world_from_file is None else (axes_taken,)
    return replace(trajectory, points=points, notes=(*trajectory.notes, *notes))


_OWN_AXES = (".csv", ".trc", ".c3d")
"""Suffixes of files whose axes, and but for ``.csv`` whose names, may be others than here."""

_READERS: Mapping[str, Callable[[Path, Stated], landmarks.LandmarkTrajectory]] = {
    ".npz": _read_archive,
    PART_SUFFIX: _read_archive,
    ".csv": _read_table,
    ".trc": read_trc,
    ".c3d": read_c3d,
}

_WRITERS: Mapping[str, Callable[[Path, landmarks.LandmarkTrajectory, float], None]] = {
    ".trc": write_trc,
    ".c3d": write_c3d,
    ".bvh": write_bvh,
}
"""What landmarks can be written as that states a frame rate."""

TRAJECTORY_SUFFIXES: tuple[str, ...] = tuple(_READERS)  # what :func:`read_trajectory` reads

RUN_SUFFIXES: tuple[str, ...] = (".npz", ".csv", ".trc", ".c3d", ".bvh")
"""What a run can be written as by what everybody has; only ``.npz`` keeps all of it."""


def run_suffix(path: Path) -> str:
    """The suffix that says how a run is written; InputError if not in :data:`RUN_SUFFIXES`."""
    return _suffix(path, RUN_SUFFIXES)


def write_run(path: Path, run: Run, fps: float | None = None) -> None:
    """Write a run completely (.npz) or its landmarks (.csv, .trc, .c3d, .bvh).

    The last three state which axis points up, and get one that does. They need frames per second,
    by default the run's. Raises InputError for an unknown suffix, a place that cannot be written
    to, or if nothing states the frame rate.

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
        trajectory = (run if own_world else upright_run(run)).trajectory()
        fps = stated_fps(run.meta) if fps is None else fps
        write_trajectory(path, trajectory, fps, run.residual)


def write_trajectory(
    path: Path,
    trajectory: landmarks.LandmarkTrajectory,
    fps: float | None,
    residual: FloatArray | None = None,
) -> None:
    """Write landmarks (.csv, .trc, .c3d, .bvh); only ``.csv`` needs no `fps`, frames per second.

    `residual` (F,), metres, is kept by ``.c3d`` alone. Raises InputError for another suffix, a
    place that cannot be written to, or a missing frame rate.
    """
    suffix = _suffix(path, (".csv", *_WRITERS))
    if suffix == ".csv":
        landmarks.write_landmarks(path, trajectory)
    elif fps is None:
        remedy = "Give it, for example with --fps 30, or use .csv, which needs none."
        raise InputError("the frame rate is not known", path, remedy)
    elif suffix == ".c3d":
        write_c3d(path, trajectory, fps, residual)
    else:
        _WRITERS[suffix](path, trajectory, fps)


def holds_run(path: Path) -> bool:
    """Whether a file holds a run with all of its numbers, by its suffix; not what is in it."""
    suffix = Path(path).suffix.lower()
    return suffix == PART_SUFFIX or (suffix == ".npz" and not reference_npz.is_reference(path))


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
        remedy = "Use an .npz file written by `stereotrack track`."
        raise InputError("this file is not a complete run", path, remedy)
    return read_npz(path)


def read_trajectory(path: Path, stated: Stated | None = None) -> landmarks.LandmarkTrajectory:
    """Landmarks of a run, a reference (.npz) or landmarks (.csv, .trc, .c3d), at its own rate.

    `stated`: names and axes of a file of another program, axes of a ``.csv``. InputError for an
    unknown suffix, a damaged file, or something stated about another format.
    """
    path = Path(path)
    return _READERS[_suffix(path, TRAJECTORY_SUFFIXES)](path, stated or Stated())


def has_own_axes(path: Path) -> bool:
    """Whether names and axes can be stated of a file of this suffix."""
    return path.suffix.lower() in _OWN_AXES


def unstatable(path: Path) -> InputError:
    """The complaint about names or axes that are stated of a file of this program."""
    what = "landmark names and axes cannot be given for files of this program"
    return InputError(what, path, "Omit --name and --axes.")


def _suffix(path: Path, known: tuple[str, ...]) -> str:
    suffix = path.suffix.lower()
    if suffix not in known:
        what = f"unknown suffix {path.suffix!r}" if suffix else "the name has no suffix"
        remedy = f"Use a name that ends in {', '.join(known[:-1])} or {known[-1]}."
        raise InputError(what, path, remedy)
    return suffix


def reference_in(path: Path, stated: Stated | None = None) -> Reference:
    """The reference that a file of a trajectory holds; InputError where it cannot be read."""
    if reference_npz.is_reference(path):
        if stated is not None and stated.about_file:
            raise unstatable(path)
        return reference_npz.read_reference(path)
    trajectory = read_trajectory(path, stated)
    if path.suffix.lower() == ".csv":
        table = reference_npz.read_reference_table(path)
        if stated is None or stated.world_from_file is None:
            return replace(table, notes=trajectory.notes)
        turn = stated.up.rotation.T @ stated.world_from_file  # into the trajectory's world
        covariance = None if table.covariance is None else turn @ table.covariance @ turn.T
        points = table.points @ turn.T
        return replace(table, points=points, covariance=covariance, notes=trajectory.notes)
    meta: dict[str, Any] = {"imported_from": path.name}
    if trajectory.fps is not None:
        meta["fps"] = trajectory.fps
    return Reference(trajectory.frame, trajectory.points, meta=meta, notes=trajectory.notes)


def at_recording(reference: Reference, fps: float, frames: int, where: str) -> Reference:
    """A file's reference at the `frames` of a recording, by time; InputError if it has none."""
    reference = reference.at_rate(fps, where)
    last = reference.frame.max(initial=-1)
    if not ((reference.frame >= 0) & (reference.frame < frames)).any():
        none = f"the reference contains none of the frames 0 to {frames - 1} of the recording"
        remedy = "Check the times in the file: they count from the recording's first frame."
        raise InputError(f"{none}; its last one is {last}", where, remedy)
    return reference.in_recording(frames, where)


_MOST_FOLDERS = 60  # more recordings beside a run than this are not looked at


def meta_of_run(path: Path) -> Mapping[str, Any]:
    """What a run file says about itself; InputError where it is no run, or damaged."""
    path = Path(path)
    return read_run(path).meta if path.suffix.lower() == PART_SUFFIX else read_meta(path)


def recording_of_run_file(path: Path) -> Path | None:
    """The folder of the recording that a run was tracked in; None where it is not found.

    It is the folder that the run names, also where both have moved together, or a recording of the
    same content beside the run. Raises InputError where the file is no run.
    """
    meta = meta_of_run(path)
    named, content = str(meta.get("recording_folder") or ""), meta.get("fingerprint")
    if named and (Path(named) / DESCRIPTION).is_file():
        return Path(named)
    parent = Path(path).absolute().parent
    beside = (parent / DESCRIPTION, *sorted(parent.glob(f"*/{DESCRIPTION}"))[:_MOST_FOLDERS])
    for folder in (one.parent for one in beside if content is not None and one.is_file()):
        recording = describe(folder, [])
        if recording is not None and fingerprint(recording) == content:
            return folder
    return None


def is_run_of(path: Path, recording: Recording) -> bool:
    """Whether a run was tracked in a recording, or in a copy of it; False for no run."""
    try:
        meta = meta_of_run(path)
    except InputError:
        return False
    if meta.get("fingerprint") is not None:
        return bool(meta["fingerprint"] == fingerprint(recording))
    named = str(meta.get("recording_folder") or "")
    return bool(named) and os.path.realpath(named) == os.path.realpath(recording.folder)
