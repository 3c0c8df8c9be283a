"""What commands are given: runs and projects, with what belongs to them and must be told."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.output import counted, say
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.annotation.reference import Reference
    from stereotrack_core.project.project import Project
    from stereotrack_core.recording.description import Recording, Segment
    from stereotrack_core.recording.finding import Finding
    from stereotrack_core.recording.landmarks import LandmarkTrajectory
    from stereotrack_core.tracking.frame import Run


@dataclass(frozen=True, eq=False)
class Truth:
    """What a run is measured against."""

    reference: LandmarkTrajectory
    source: Path
    segments: Sequence[Segment]
    states: Reference | None = None
    """The reference with its uncertainty, where it states one."""


def read_measured(path: Path) -> tuple[LandmarkTrajectory, Run | None]:
    """Landmarks of a file, and the run where it holds a complete one."""
    from stereotrack_core.interop.run_file import holds_run, read_run, read_trajectory

    if holds_run(path):
        stored = read_run(path)
        say_if_unfinished(path, stored)
        return stored.trajectory(), stored
    return read_trajectory(path), None


def truth_of(given: Path | None, meta: Mapping[str, Any]) -> Truth:
    """The reference that was named, else that of the run's recording.

    Raises
    ------
    InputError
        Where there is none.
    """
    from stereotrack_core.interop.reference_npz import is_reference, read_reference
    from stereotrack_core.interop.run_file import read_trajectory
    from stereotrack_core.recording.folder import describe

    folder = meta.get("recording_folder")
    recording: Recording | None = None
    if folder and Path(folder).is_dir():
        recording = describe(Path(folder), [])
    segments = recording.segments if recording is not None else ()
    if given is not None:
        beside = segments or _segments_beside(given)
        if given.suffix.lower() == ".npz" and is_reference(given):
            states = read_reference(given)
            return Truth(states.trajectory(), given, beside, states)
        return Truth(read_trajectory(given), given, beside)
    if not folder:
        raise InputError(
            "the file does not say which recording it belongs to",
            remedy="Name the truth with --reference.",
        )
    if recording is None:
        raise InputError(
            "the run's recording is not there any more",
            where=str(folder),
            remedy="Move it back beside the run, or name the truth with --reference.",
        )
    if recording.reference is None:
        raise InputError(
            "the recording has no reference that can be read",
            where=str(folder),
            remedy="See `stereotrack info`, or name the truth with --reference.",
        )
    return Truth(recording.reference, Path(folder), segments)


def _segments_beside(reference: Path) -> Sequence[Segment]:
    from stereotrack_core.recording.segments_file import read_segments

    beside = reference.with_name("segments.csv")
    return read_segments(beside) if beside.is_file() else ()


def recording_of_run(given: Path | None, run: Run, otherwise: str) -> Recording | None:
    """The recording that is named, else the one that the run names.

    Says so where it is not the one that was tracked, and says `otherwise` where there is none.
    """
    from stereotrack_core.recording.fingerprint import fingerprint
    from stereotrack_core.recording.folder import open_recording

    folder = given or Path(str(run.meta.get("recording_folder") or ""))
    if given is None and not (run.meta.get("recording_folder") and folder.is_dir()):
        say(f"The run's recording is not there, so {otherwise}; name its folder with --recording.")
        return None
    recording = open_recording(folder)
    if run.meta.get("fingerprint") not in (None, fingerprint(recording)):
        say(
            f"{folder}: this is not the recording that was tracked; its pictures and its reference "
            "do not belong to the run."
        )
    return recording


def segments_of(truth: Truth) -> Sequence[Segment]:
    """Named stretches of the recording.

    Raises
    ------
    InputError
        Where there are none.
    """
    if not truth.segments:
        raise InputError(
            "there are no segments",
            where=str(truth.source),
            remedy="Put a segments.csv beside the reference, or leave --segments out.",
        )
    return truth.segments


def segments_beside_runs(truth: Truth | None, meta: Mapping[str, Any]) -> Sequence[Segment]:
    """Named stretches that come with the reference, or else with the run's recording.

    Raises
    ------
    InputError
        Where there are none.
    """
    if truth is not None:
        return segments_of(truth)
    from stereotrack_core.recording.folder import describe

    folder = Path(str(meta.get("recording_folder", "")))
    recording = describe(folder, []) if meta.get("recording_folder") else None
    if recording is None or not recording.segments:
        raise InputError(
            "there are no segments",
            where=str(folder),
            remedy="Put a segments.csv into the recording, or leave --segments out.",
        )
    return recording.segments


def warn_about_size(truth: Truth) -> None:
    """Say where the reference is not as large as a person."""
    from stereotrack_core.recording.content_checks import check_size

    for finding in check_size(truth.reference):
        say(f"{truth.source}: {finding.what}. {finding.remedy}")


def say_if_unfinished(path: Path, run: Run) -> None:
    """Say where a run lacks frames that are still to come."""
    from stereotrack_core.tracking.unfinished import INCOMPLETE

    if run.meta.get(INCOMPLETE):
        first, end = run.meta["frames"]
        say(
            f"{path}: this run was stopped and is not complete; it has {len(run.frame)} of the "
            f"{counted(end - first, 'frame')} that were asked for."
        )


def open_project(path: Path, *, read_only: bool = True) -> Project:
    """Open a project and say on standard error what its file has to tell."""
    from stereotrack_core.project.project import Project

    project = Project.open(path, read_only=read_only)
    say_notes(project.notes)
    return project


def say_notes(notes: Iterable[Finding]) -> None:
    """Say what the person should know about a project."""
    for note in notes:
        say(f"{note.severity}: {note.where}: {note.what}. {note.remedy}")


def recording_of(project: Project) -> Recording:
    """The recording of a project.

    Raises
    ------
    InputError
        Where it is not found.
    """
    from stereotrack_core.recording.folder import open_recording

    place = project.find_recording()
    if place.finding is not None and place.folder is not None:
        say(f"{place.finding.severity}: {place.finding.where}: {place.finding.what}.")
    if place.folder is None:
        raise InputError(
            "the project's recording is not found",
            where=project.recording_place().absolute,
            remedy="Move it back beside the project, or choose its folder in the workbench.",
        )
    return open_recording(place.folder)
