"""The formats that runs, references, clicks and keypoints are written in.

A format is an entry of :data:`FORMATS` that carries its own functions. The command and the window
offer what stands there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.atomic import write_file
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation import joint_angles
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.reference_npz import write_reference, write_reference_table
from stereotrack_core.interop.run_file import write_run, write_trajectory
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tables import csv_text
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import fps_of_run

# A complete run, landmarks of any origin, a project's reference, its clicks, or its keypoints.
Kind: TypeAlias = Literal["run", "trajectory", "reference", "clicks", "keypoints"]
_KINDS: tuple[Kind, ...] = ("run", "trajectory", "reference", "clicks", "keypoints")


@dataclass(frozen=True)
class Exported:
    """Files that were written."""

    files: Mapping[Path, str]  # files or folders, and in words what is in them
    notes: tuple[str, ...] = ()  # remarks on them, as sentences

    def saved(self) -> str:
        """``30 frames saved to run.trc``; of several files the first one is named."""
        path, what = next(iter(self.files.items()))
        more = f"; {counted(len(self.files) - 1, 'more file')} beside it"
        return f"{what} saved to {path}{more if len(self.files) > 1 else ''}"

    def words(self) -> str:
        """The same with all remarks."""
        return " ".join((f"{self.saved()}.", *self.notes))


@dataclass(frozen=True)
class ClickedRecording:
    """Clicks with what names their places: the recording's cameras and the project's landmarks."""

    clicks: Sequence[Click]
    recording: Recording
    landmarks: LandmarkSet
    left_out: Sequence[str] = ()  # cameras that the project does not use

    @staticmethod
    def of(project: Project, recording: Recording) -> ClickedRecording:
        """The clicks of a project, without cameras that are left out."""
        out = sorted(project.marks.unused_cameras())
        return ClickedRecording(project.clicks.used(), recording, project.landmark_set(), out)


@dataclass(frozen=True)
class ExportFormat:
    """A format of this or of another program: a function for each kind of data that it can hold."""

    name: str  # as `--format` calls it
    label: str  # as a dialog calls it
    suffixes: tuple[str, ...]  # of its files; the first one is usual
    run: Callable[[Path, Run, float | None], Exported] | None = None
    trajectory: Callable[[Path, LandmarkTrajectory, float | None], Exported] | None = None
    reference: Callable[[Path, Reference, float | None], Exported] | None = None
    clicks: Callable[[Path, ClickedRecording], Exported] | None = None
    keypoints: Callable[[Path, Keypoints, Recording], Exported] | None = None
    module: str = ""  # library that it needs besides
    extra: str = ""  # optional dependency that installs the library
    beside: bool = False  # whether provenance has no place in it, so that a table lies beside
    lost_of_reference: str = ""  # parts of a fitted reference without a place in it, in words

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Kinds of data that it can hold."""
        return tuple(kind for kind in _KINDS if getattr(self, kind) is not None)

    @property
    def missing(self) -> str:
        """How what it needs is installed, as a sentence; empty where all is there."""
        if not self.module or find_spec(self.module) is not None:
            return ""
        return f"It needs `pip install 'stereotrack[{self.extra}]'`."

    def named(self, path: Path) -> Path:
        """The path with a suffix, where it has none of this format."""
        if path.suffix.lower() in self.suffixes:
            return path
        return path.with_name(f"{path.name}{self.suffixes[0]}")


def export_reference(
    path: Path,
    reference: Reference,
    form: ExportFormat,
    fps: float | None,
    max_sigma: float = MAX_SIGMA,
) -> Exported:
    """Write what is known of a reference within a standard deviation, metres; says what is not.

    ``npz`` and ``csv`` keep uncertainty and provenance, of other formats a table beside does.
    Raises InputError as :func:`writer` does.
    """
    known, lost = reference.within(max_sigma), ""
    written = writer(form, "reference")(path, known, fps)
    if form.beside and (known.covariance is not None or known.provenance is not None):
        written = _with_table(written, path, partial(write_reference_table, reference=known))
    if form.lost_of_reference and reference.covariance is not None:
        lost = f"{form.label} cannot store: {form.lost_of_reference}."
    notes = (*written.notes, reference.left_out(max_sigma), lost)
    return replace(written, notes=tuple(filter(None, notes)))


def export_clicks(path: Path, clicked: ClickedRecording, form: ExportFormat) -> Exported:
    """Write clicks; raises InputError as :func:`writer` does."""
    written = writer(form, "clicks")(path, clicked)
    if form.beside:
        write = partial(write_clicks, clicks=clicked.clicks, recording=clicked.recording)
        written = _with_table(written, path, write)
    empty = "" if clicked.clicks else "The project has no clicks, so the file is empty."
    out = ", ".join(clicked.left_out)
    notes = (empty, f"Left out: clicks in {out}, which the project does not use." if out else "")
    return replace(written, notes=tuple(filter(None, notes)))


def _with_table(written: Exported, path: Path, write: Callable[[Path], None]) -> Exported:
    """Write a table of provenance beside a file."""
    table = path.with_name(f"{path.name}.provenance.csv")
    write(table)
    return replace(written, files={**written.files, table: "provenance of each landmark"})


def export_angles(path: Path, angles: joint_angles.JointAngles, fps: float | None) -> Exported:
    """Write joint angles of every frame as CSV."""
    if fps is None:
        raise InputError("the frame rate is not known", path, "Give it, for example with --fps 30.")
    write_file(path, csv_text(joint_angles.frame_columns(), joint_angles.frame_rows(angles, fps)))
    return Exported({path: f"joint angles of {counted(len(angles.frame), 'frame')}"})


def _told(write: Callable[..., object], words: Callable[[Any], str]) -> Callable[..., Exported]:
    """The function that writes data, and says in words what is in the file then."""

    def written(path: Path, data: Any, more: Any = None) -> Exported:
        write(path, data, more)
        return Exported({path: words(data)})

    return written


def _frames(write: Callable[[Path, Any, float | None], object]) -> Callable[..., Exported]:
    return _told(write, lambda data: counted(len(data.frame), "frame"))


def _clicks(write: Callable[[Path, ClickedRecording], object]) -> Callable[..., Exported]:
    return _told(lambda path, data, _: write(path, data), lambda data: f"{len(data.clicks)} clicks")


def _landmarks_of_reference(path: Path, reference: Reference, fps: float | None) -> None:
    sigma = None if reference.covariance is None else reference.of_the_nine(reference.sigma())
    write_trajectory(path, reference.trajectory(np.inf), fps, sigma)


def _angles_of_run(path: Path, run: Run, fps: float | None) -> Exported:
    fps = fps_of_run(run) if fps is None else fps
    return export_angles(path, joint_angles.angles_of_run(run), fps)


def _angles(path: Path, trajectory: LandmarkTrajectory, fps: float | None) -> Exported:
    return export_angles(path, joint_angles.angles_of_trajectory(trajectory), fps)


def _deeplabcut(path: Path, clicked: ClickedRecording) -> Exported:
    written = write_deeplabcut(path, clicked.clicks, clicked.landmarks.names)
    return Exported({file: f"{count} clicks" for file, count in written.items()})


def _coco_results(path: Path, keypoints: Keypoints, recording: Recording) -> Exported:
    others = write_results(path, keypoints, recording)
    told = f", {others} that COCO does not have left out" if others else ""
    return Exported({path: f"{counted(len(keypoints) - others, 'keypoint')}{told}"})


_TRAJECTORIES = (_frames(write_run), _frames(write_trajectory), _frames(_landmarks_of_reference))
_LOST = "covariances between axes, and uncertainties of limbs"

FORMATS: tuple[ExportFormat, ...] = (
    ExportFormat(
        "csv", "Table", (".csv",), *_TRAJECTORIES[:2],
        _frames(lambda path, one, _: write_reference_table(path, one)),
        _clicks(lambda path, one: write_clicks(path, one.clicks, one.recording)),
        _told(write_table, lambda keypoints: counted(len(keypoints), "keypoint")),
        lost_of_reference=_LOST,
    ),
    ExportFormat(
        "trc", "TRC, OpenSim", (".trc",), *_TRAJECTORIES, beside=True, lost_of_reference=_LOST,
    ),
    ExportFormat("c3d", "C3D", (".c3d",), *_TRAJECTORIES, beside=True, lost_of_reference=_LOST),
    ExportFormat(
        "bvh", "BVH", (".bvh",), *_TRAJECTORIES, beside=True,
        lost_of_reference=f"{_LOST}, and gaps: unknown landmarks stay as they were last known",
    ),
    ExportFormat(
        "npz", "Complete, with uncertainty", (".npz",), _TRAJECTORIES[0],
        reference=_frames(lambda path, one, _: write_reference(path, one)),
    ),
    ExportFormat(
        "angles", "Joint angles", (".csv",), _angles_of_run, _angles,
        lambda path, one, fps: _angles(path, one.trajectory(np.inf), fps), beside=True,
    ),
    ExportFormat(
        "coco", "COCO keypoints", (".json",),
        clicks=_clicks(lambda path, c: write_coco(path, c.clicks, c.recording, c.landmarks)),
        keypoints=_coco_results,
    ),
    ExportFormat(
        "slp", "SLEAP", (".slp",),
        clicks=_clicks(lambda path, c: write_sleap(path, c.clicks, c.recording, c.landmarks)),
        module="sleap_io", extra="sleap", beside=True,
    ),
    ExportFormat("dlc", "DeepLabCut", (".csv",), clicks=_deeplabcut, beside=True),
)  # fmt: skip


def formats_of(*kinds: Kind) -> tuple[ExportFormat, ...]:
    """Formats that any of these can be written as, in the order in which they are offered."""
    return tuple(one for one in FORMATS if set(kinds) & set(one.kinds))


def format_named(name: str) -> ExportFormat:
    """The format of that name; LookupError where there is none."""
    found = next((one for one in FORMATS if one.name == name), None)
    if found is None:
        raise LookupError(name)
    return found


def format_of_file(path: Path) -> ExportFormat:
    """The format that a file's name means, of several the first one; InputError for none."""
    suffix = path.suffix.lower()
    found = next((one for one in FORMATS if suffix in one.suffixes), None)
    if found is None:
        every = sorted({one for form in FORMATS for one in form.suffixes})
        remedy = f"Give --format, or a name that ends in one of {', '.join(every)}."
        raise InputError(f"the suffix {suffix!r} means no format", path, remedy)
    return found


def writer(form: ExportFormat, kind: Kind) -> Callable[..., Exported]:
    """The function that writes a kind of data in a format; InputError where there is none.

    It is given path and data, and the frames per second or, of keypoints, the recording. A complete
    run has its own rate where none is given. It raises InputError if the file cannot be written.
    """
    found: Callable[..., Exported] | None = getattr(form, kind)
    if found is None:
        remedy = f"Use one of {', '.join(one.name for one in formats_of(kind))}."
        raise InputError(f"this cannot be exported as {form.name}", "--format", remedy)
    return found
