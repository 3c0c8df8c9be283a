"""What commands are given: runs and projects, with what belongs to them and must be told.

The modules of projects and of other programs' files are loaded when one is opened, as most
commands go without.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, Sigmas, click_detections
from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.arrays import IntArray
from stereotrack_core.cli.output import say
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.evaluation import joint_angles
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.interop import run_file
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.interop.landmark_file import Stated, world_from_axes
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.camera_checks import up_of_cameras
from stereotrack_core.recording.description import Recording, Segment, read_segments
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.folder import describe, fingerprint, open_recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import frame_count
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.run_spec import AUTO, FirstPose
from stereotrack_core.tracking.stored import up_of_meta
from stereotrack_core.tracking.unfinished import INCOMPLETE

if TYPE_CHECKING:
    from stereotrack_core.project.project import Project


@dataclass(frozen=True, eq=False)
class Truth:
    """What a run is measured against."""

    reference: LandmarkTrajectory
    source: Path
    segments: Sequence[Segment]
    states: Reference | None = None  # the reference with its uncertainty, where it states one


def read_measured(
    path: Path, stated: Stated | None = None, folder: Path | None = None
) -> tuple[LandmarkTrajectory, Run | None]:
    """Landmarks of a file, at its recording's rate where that is found, and the run if complete."""
    if run_file.holds_run(path):
        stored = run_file.read_run(path)
        say_if_unfinished(path, stored)
        if folder is not None:
            open_recording(folder)
            stored = replace(stored, meta={**stored.meta, "recording_folder": str(folder)})
        return _at_its_rate(stored.trajectory(), _tracked_recording(stored.meta)), stored
    if path.suffix.lower() == ".npz":
        found = read_reference(path).trajectory(np.inf)
    else:
        found = run_file.read_trajectory(path, stated)
        say_notes(found.notes)
    return found if found.fps else _at_its_rate(found, recording_in(path.parent)), None


def _at_its_rate(found: LandmarkTrajectory, recording: Recording | None) -> LandmarkTrajectory:
    return found if recording is None else replace(found, fps=recording.fps)


def _tracked_recording(meta: Mapping[str, Any]) -> Recording | None:
    folder = meta.get("recording_folder")
    return describe(Path(folder), []) if folder and Path(folder).is_dir() else None


def truth_of(
    given: Path | None,
    meta: Mapping[str, Any],
    measured: LandmarkTrajectory,
    stated: Stated | None = None,
    max_sigma: float = MAX_SIGMA,
    exclude: Sequence[str] = (),
) -> Truth:
    """The reference that was named, else that of the run's recording; `meta` is what a run states.

    It is taken to the frames of what is measured, by time. Landmarks that are less certain than
    `max_sigma` (metres) are unknown, which is said, and so are those of the sources to `exclude`.
    `stated`: names and axes of the file, which is turned into the run's world. Raises InputError
    where there is none.
    """
    folder = meta.get("recording_folder")
    recording = _tracked_recording(meta)
    segments = recording.segments if recording is not None else ()
    if given is not None:
        own = given.with_name("segments.csv")
        beside = segments or (read_segments(own) if own.is_file() else ())
        stated = replace(stated or Stated(), up=up_of_meta(meta))
        states = named_reference(given, recording, measured.fps, measured.frame, stated)
        if exclude and states.provenance is None:
            what = "the reference does not state where its landmarks come from"
            raise InputError(what, given, "Omit --exclude, or fit it again.")
        states = states.without(exclude)
        say_left_out(given, states, max_sigma)
        return Truth(states.trajectory(max_sigma), given, beside, states)
    if not folder:
        what = "the file does not state its recording"
        raise InputError(what, remedy="Give the reference with --reference.")
    if recording is None:
        remedy = "Move it back beside the run, or give the reference with --reference."
        raise InputError("the run's recording was not found", folder, remedy)
    if recording.reference is None:
        remedy = "See `stereotrack info`, or give the reference with --reference."
        raise InputError("the recording has no readable reference", folder, remedy)
    say_notes(recording.reference.notes)
    return Truth(recording.reference, Path(folder), segments)


def named_reference(
    path: Path,
    recording: Recording | None,
    fps: float | None = None,
    measured: IntArray | None = None,
    stated: Stated | None = None,
) -> Reference:
    """The reference of a file at the frames of a recording, or of the rate `fps`, by time.

    Says what was done to it. A file that states no rate has that of the recording it lies beside.
    Frames after the last one of the recording and of what is `measured` (F,) are left out.
    """
    reference = run_file.reference_in(path, stated)
    rate = fps if recording is None else recording.fps
    if rate is None:
        if reference.fps is not None:
            say(
                f"{path}: it has {reference.fps:.6g} frames per second, but what it is compared "
                "with states no rate, so frames are compared by their numbers."
            )
    else:
        if reference.fps is None and (beside := recording_in(path.parent)) is not None:
            reference = replace(reference, meta={**reference.meta, "fps": beside.fps})
        reference = reference.at_rate(rate, str(path))
    if recording is not None:
        count = 0 if measured is None else int(measured.max(initial=-1)) + 1
        if reference.frame.max(initial=0) >= count:
            with suppress(InputError):  # of a recording that cannot be read
                count = max(count, frame_count(recording))
        if count:
            reference = run_file.at_recording(reference, recording.fps, count, str(path))
    say_notes(reference.notes)
    return reference


def say_left_out(path: Path, reference: Reference, max_sigma: float = MAX_SIGMA) -> None:
    """Say what of a reference is too uncertain to be used."""
    if reference.covariance is not None and (note := reference.left_out(max_sigma)):
        say(f"{path}: {note}")


def recording_of_run(given: Path | None, run: Run, otherwise: str) -> Recording | None:
    """The recording that is named, else the one that the run names.

    Says so where it is not the one that was tracked, and says `otherwise` where there is none.
    """
    folder = given or Path(str(run.meta.get("recording_folder") or ""))
    if given is None and not (run.meta.get("recording_folder") and folder.is_dir()):
        say(f"The run's recording was not found, so {otherwise}. Give its folder with --recording.")
        return None
    recording = open_recording(folder)
    if run.meta.get("fingerprint") not in (None, fingerprint(recording)):
        what = f"{folder}: this is not the recording that was tracked"
        say(f"{what}; its images and its reference do not belong to the run.")
    return recording


def say_if_unfinished(path: Path, run: Run) -> None:
    """Say where a run lacks frames that are still to come."""
    if run.meta.get(INCOMPLETE):
        first, end = run.meta["frames"]
        had = f"it has {len(run.frame)} of {counted(end - first, 'frame')}"
        say(f"{path}: this run was stopped and is incomplete: {had}.")


def clicks_in_file(path: Path, recording: Recording, frames: int) -> tuple[Sequence[Click], Sigmas]:
    """Clicks of a project or of a file of clicks, and their usual standard deviation in pixels.

    A project knows that of each landmark. Clicks in cameras that the recording does not have are
    left out. Raises InputError where they cannot be read.
    """
    if path.suffix != SUFFIX:
        from stereotrack_core.interop.labels import read_clicks

        return read_clicks(path, recording, frames=frames).checked(), USUAL_SIGMA
    with open_project(path) as project:
        every, sigma = project.clicks.used(), project.click_sigmas()
    return [one for one in every if one.camera in recording.cameras], sigma


def clicks_for_tracking(path: Path, recording: Recording, frames: int) -> Detections:
    """Clicks of a project or file as measurements; InputError without any of the nine landmarks."""
    clicks, sigma = clicks_in_file(path, recording, frames)
    found = click_detections(clicks, recording.cameras, sigma, str(path.resolve()))
    if not len(found):
        what = "there is no click on any of the nine landmarks"
        raise InputError(what, path, "Click landmarks in frames in which the tracker is wrong.")
    return found


def open_project(path: Path, *, read_only: bool = True) -> Project:
    """Open a project and say on standard error what its file has to tell."""
    from stereotrack_core.project.project import Project

    project = Project.open(path, read_only=read_only)
    say_notes(project.notes)
    return project


def named_scenarios(project: Project) -> tuple[Segment, ...]:
    """Named stretches of a project and of its recording, where that is found; else InputError."""
    from stereotrack_core.project.scenarios import segments_of

    found = segments_of(project, recording_of(project))
    if not found:
        remedy = "Select frames in the timeline of the workbench and choose Name stretch."
        raise InputError("no stretch has a name", project.path, remedy)
    return found


def say_notes(notes: Iterable[Finding]) -> None:
    """Say what the person should know about a project."""
    for note in notes:
        say(f"{note.severity}: {note.where}: {note.what}. {note.remedy}".rstrip())


def keypoints_from(path: Path, recording: Recording, args: Namespace) -> Keypoints:
    """Keypoints of a project or of a detector's file; says what was decided and is left out.

    The options --layout and --person hold. Raises InputError where there are none.
    """
    from stereotrack_core.project.detectors import keypoints_in

    found = keypoints_in(path, recording, args.layout, args.person)
    for note in found.notes:
        say(f"{path}: {note}.")
    if found.left_out:
        say(f"{path}: left out: {found.summary()}")
    number, cameras = counted(len(found.keypoints), "keypoint"), len(found.keypoints.cameras)
    say(f"{path}: {number} of {counted(cameras, 'camera')}")
    return found.keypoints


def recording_of(project: Project) -> Recording:
    """The recording of a project. Raises InputError where it is not found."""
    place = project.find_recording()
    if place.finding is not None and place.folder is not None:
        say(f"{place.finding.severity}: {place.finding.where}: {place.finding.what}.")
    if place.folder is None:
        what = "the project's recording was not found"
        remedy = "Move it back beside the project, or choose its folder in the workbench."
        raise InputError(what, project.recording_place().absolute, remedy)
    return open_recording(place.folder)


def angles_in(
    path: Path, trajectory: LandmarkTrajectory, run: Run | None, fps: float | None
) -> tuple[joint_angles.JointAngles, float]:
    """Joint angles of a file, and the given or its own rate; InputError where there is none."""
    rate = fps if fps is not None else trajectory.fps
    if rate is None:
        raise InputError("the file does not state its frame rate", path, "Give --fps N.")
    if run is not None:
        return joint_angles.angles_of_run(run), rate
    if path.suffix.lower() == ".npz":
        trajectory = read_reference(path).trajectory()
    return joint_angles.angles_of_trajectory(trajectory), rate


def stated_for(args: Namespace, *paths: Path | None) -> dict[Path, Stated]:
    """The same for each of several files: those of other programs, else tables of landmarks.

    Raises InputError if something is stated, and none of the files can have other names or axes.
    """
    stated, given = stated_in(args), [path for path in paths if path is not None]
    if not stated.about_file:
        return {}
    able = [path for path in given if run_file.has_own_axes(path)]
    if not able:
        if given:
            raise run_file.unstatable(given[0])
        raise InputError("no file is given that they could be of", "--name, --axes", "Omit them.")
    return dict.fromkeys([p for p in able if p.suffix.lower() != ".csv"] or able, stated)


def stated_in(args: Namespace) -> Stated:
    """What the options --name and --axes say about a file of another tool."""
    axes = None if args.axes is None else world_from_axes(args.axes)
    return Stated(stated_names(args.names, "--name"), axes)


def initial_pose(args: Namespace, first: int, recording: Recording) -> FirstPose:
    """Where --init says that tracking begins; InputError for a file without the frame."""
    stated = replace(stated_in(args), up=up_of_recording(recording))
    notes: list[Finding] = []
    pose = first_pose(args.init or AUTO, first, recording, stated=stated, notes=notes)
    say_notes(notes)
    return pose


def up_of_recording(recording: Recording) -> Upright:
    """Which axis of a recording's world points up: z unless its cameras prove another one."""
    likely = up_of_cameras(recording)
    return Upright(likely.axis) if likely.sure else Z_UP


def recording_in(folder: Path) -> Recording | None:
    """The recording of a folder, as far as it can be read; None where there is none."""
    return describe(folder, []) if (folder / "recording.toml").is_file() else None
