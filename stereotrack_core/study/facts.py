"""What a study has to know of a recording and of its project; read once, then from the cache."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.plain_data import Kind, check_kind, plain
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import kept_runs
from stereotrack_core.project.setups import Corrections
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import OWN_FILE
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.folder import (
    DESCRIPTION,
    calibration_fingerprint,
    describe,
    fingerprint,
    identifying_files,
    open_recording,
)
from stereotrack_core.recording.images import is_pattern
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.study.cache import Read

_MOST_DIAGNOSTICS = 20
_FORGET = "Delete the cache of the study."
_RECORDING: Kind = {
    **dict.fromkeys(("name", "fingerprint", "calibration"), str),
    **dict.fromkeys(("frames", "errors", "warnings"), int),
    "views": [str],
    "diagnostics": [str],
    "fps": float,
    "reference": bool,
}
_PROJECT: Kind = {
    **dict.fromkeys(("keyframes", "done", "flagged", "clicks"), int),
    **dict.fromkeys(("reference", "reference_content", "calibration", "problem"), str),
    "runs": [{"name": str, "content": str}],
}
_NAMED = ("calibration", "reference", "subject", "segments")


@dataclass(frozen=True)
class RecordingFacts:
    """What a recording says about itself."""

    name: str
    fingerprint: str
    """Empty where it cannot be opened."""
    calibration: str
    """Fingerprint of its cameras."""
    frames: int
    fps: float
    views: tuple[str, ...]
    """Name and kind: ``N stereo``."""
    errors: int
    warnings: int
    """`errors` and `warnings`: how many the fast examination has found."""
    diagnostics: tuple[str, ...]
    """Errors and warnings in words, the gravest first."""
    reference: bool
    """Whether it brings one."""

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> RecordingFacts:
        """From plain data. Raises InputError where they are another's."""
        check_kind(facts, _RECORDING, "recording", _FORGET)
        lists = {key: tuple(facts[key]) for key in ("views", "diagnostics")}
        return cls(**{**facts, **lists})


@dataclass(frozen=True)
class ProjectRun:
    """A run that a project keeps."""

    name: str
    content: str
    """Hash of its numbers."""


@dataclass(frozen=True)
class ProjectFacts:
    """What a project knows of its recording."""

    keyframes: int
    done: int
    flagged: int
    clicks: int
    """Keyframes to annotate, those of them that are done and flagged, and all clicks."""
    runs: tuple[ProjectRun, ...]
    """Oldest first."""
    reference: str
    """Name of the reference that was chosen; empty where none was."""
    reference_content: str
    """Hash of its numbers."""
    calibration: str
    """Fingerprint of the recording's cameras as the project corrects them; empty: as they are."""
    problem: str = ""
    """Why it cannot be read."""

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> ProjectFacts:
        """From plain data. Raises InputError where they are another's."""
        check_kind(facts, _PROJECT, "project", _FORGET)
        return cls(**{**facts, "runs": tuple(ProjectRun(**run) for run in facts["runs"])})


def read_recording_facts(folder: Path) -> Read:
    """Open a recording, examine it fast and count its frames."""
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    findings = examine(folder)
    frames = 0
    if recording is not None and not complaints:
        try:
            with FrameReader(recording, read_ahead=0) as reader:
                frames = reader.frame_count
        except InputError as error:
            findings = (Finding.of(error), *findings)
    facts = RecordingFacts(
        name=folder.name if recording is None else recording.name,
        fingerprint="" if recording is None or complaints else fingerprint(recording),
        calibration="" if recording is None else calibration_fingerprint(recording),
        frames=frames,
        fps=0.0 if recording is None else recording.fps,
        views=() if recording is None else tuple(f"{v.name} {v.kind}" for v in recording.views),
        errors=sum(one.severity == "error" for one in findings),
        warnings=sum(one.severity == "warning" for one in findings),
        diagnostics=tuple(
            f"{one.severity}: {one.where}: {one.what}. {one.remedy}"
            for one in findings[:_MOST_DIAGNOSTICS]
            if one.severity != "note"
        ),
        reference=recording is not None and recording.reference is not None,
    )
    return Read(plain(facts), tuple(dict.fromkeys(_sources(folder, recording))))


def description_files(folder: Path) -> tuple[Path, ...]:
    """Files of a recording that say what is in it and where its cameras are, or a reference."""
    try:
        named = load_toml(folder / DESCRIPTION)
    except InputError:
        named = {}
    told = [folder / name for key in _NAMED if isinstance(name := named.get(key), str)]
    return (folder / DESCRIPTION, *told)


def _sources(folder: Path, recording: Recording | None) -> Iterator[Path]:
    """All that the facts depend on; of many images the folder, the first and the last."""
    yield from (folder, *description_files(folder), folder / OWN_FILE)
    for view in () if recording is None else recording.views:
        for stream in view.streams().values():
            for file in (stream.frames, stream.background):
                if file is None:
                    continue
                if is_pattern(file):
                    yield (folder / file).parent
                yield from identifying_files(folder, file)


def read_project_facts(path: Path, folder: Path | None) -> Read:
    """Open a project for reading; `folder`: where its recording is, None where it is missing."""
    sources = (path, *(() if folder is None else description_files(folder)))
    try:
        with Project.open(path, read_only=True) as project:
            facts = _facts_of(project, folder)
    except InputError as error:
        facts = ProjectFacts(0, 0, 0, 0, (), "", "", "", problem=str(error))
    return Read(plain(facts), sources)


def _facts_of(project: Project, folder: Path | None) -> ProjectFacts:
    progress = project.progress()
    reference = project.chosen(project.references)
    corrections, calibration = project.corrections(), ""
    if corrections is not None and folder is not None:
        calibration = calibration_fingerprint(corrected(open_recording(folder), corrections))
    return ProjectFacts(
        keyframes=progress.keyframes,
        done=progress.done,
        flagged=progress.flagged,
        clicks=progress.clicks,
        runs=tuple(ProjectRun(run.name, run.content) for run in kept_runs(project.runs)),
        reference=reference or "",
        reference_content=""
        if reference is None
        else str(project.references.get(reference).content or ""),
        calibration=calibration,
    )


def corrected(recording: Recording, corrections: Corrections | None) -> Recording:
    """A recording as its project corrects it. Raises InputError where that does not fit."""
    return recording if corrections is None else corrections.applied_to(recording)


def corrections_of(project: Path | None) -> Corrections | None:
    """What a project corrects of its recording; None where nothing.

    Raises InputError where it cannot be read.
    """
    if project is None:
        return None
    with Project.open(project, read_only=True) as opened:
        return opened.corrections()
