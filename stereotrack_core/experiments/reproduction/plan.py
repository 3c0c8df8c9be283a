"""What has to be tracked for the tables: ways of tracking, and runs that share their clouds."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from platformdirs import user_data_path

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.description import LENGTHS, Recording, Subject
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.thesis_recordings import ThesisRecording, thesis_recordings
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec

THESIS = "thesis"
FEW_VIEWS = ("N", "S")
"""The two cameras of table 4.3."""

LEFT_OUT_WITH_FEW_VIEWS = "P3"
POINTS = (24, 40, 64, 120)
"""Model points m of table 4.2; 64 is the reference."""

_REFERENCE_POINTS = 64


@dataclass(frozen=True)
class PlannedRun:
    """One run of the tables; without its seed a column of one."""

    preset: str
    points: int | None = None
    """Model points m, where they differ from the preset's."""
    few_views: bool = False
    """Two cameras instead of all."""
    averaged: bool = False
    """The same averaged proportions for everybody."""
    anew: bool = False
    """Put on the reference's pose at the beginning of every segment, instead of continuously from
    the first frame on. This is for judging alone: such a run knows the truth."""
    seed: int = 0

    @property
    def way(self) -> str:
        """Short name of everything but the seed, which is also part of the run's file name."""
        parts = [self.preset]
        parts += [] if self.points is None else [f"m{self.points}"]
        parts += ["NS"] if self.few_views else []
        parts += ["averaged"] if self.averaged else []
        parts += ["anew"] if self.anew else []
        return "-".join(parts)

    @property
    def name(self) -> str:
        """Name of the run's file without its suffix."""
        return f"{self.way}-seed{self.seed}"

    def spec(self, frames: range | None = None, start: Pose | None = None) -> RunSpec:
        """How it is tracked; the thesis's people stood in a defined pose first, others find it."""
        settings = preset(self.preset)
        if self.points is not None:
            settings = settings.replaced(model_points=self.points)
        return RunSpec(
            settings,
            preset=self.preset,
            frames=frames,
            views=FEW_VIEWS if self.few_views else None,
            seed=self.seed,
            init=start or ("tpose" if self.preset == THESIS else "auto"),
        )


@dataclass(frozen=True)
class Group:
    """Runs of one recording with the same views and depth parameters, which share clouds."""

    recording: str
    runs: tuple[PlannedRun, ...]


def groups(recordings: Sequence[str], presets: Sequence[str], seeds: int) -> tuple[Group, ...]:
    """All runs, what tells most first: table 4.1, then the others.

    The preset ``thesis``, which draws points at random, runs with all seeds; others with one.
    """
    thesis = THESIS in presets
    stages: list[list[PlannedRun]] = []
    if thesis:
        stages.append([PlannedRun(THESIS), PlannedRun(THESIS, anew=True)])
    others = [name for name in presets if name != THESIS]
    stages += [[PlannedRun(name), PlannedRun(name, averaged=True)] for name in others]
    stages += [[PlannedRun(name, few_views=True)] for name in presets]
    if thesis:
        more = [PlannedRun(THESIS, points=m) for m in POINTS if m != _REFERENCE_POINTS]
        stages.append([*more, PlannedRun(THESIS, averaged=True)])
    return tuple(
        Group(recording, tuple(_seeded(stage, seeds)))
        for stage in stages
        for recording in recordings
        if not (stage[0].few_views and recording == LEFT_OUT_WITH_FEW_VIEWS)
    )


def _seeded(runs: Sequence[PlannedRun], seeds: int) -> Iterator[PlannedRun]:
    for run in runs:
        for seed in range(seeds if run.preset == THESIS else 1):
            yield dataclasses.replace(run, seed=seed)


def averaged_subject(subjects: Sequence[Subject | None]) -> Subject:
    """Mean of everybody's lengths; a length that nobody has measured stays unknown."""
    known = [subject for subject in subjects if subject is not None]
    lengths: dict[str, Any] = {}
    for name in LENGTHS:
        values = [getattr(subject, name) for subject in known]
        measured = [value for value in values if value is not None]
        if measured:
            lengths[name] = float(np.mean(measured))
    return Subject(name="averaged", **lengths)


def recording_for(run: PlannedRun, recording: Recording, average: Subject) -> Recording:
    """What a tracker may know of a recording: never its reference."""
    subject = average if run.averaged else recording.subject
    return dataclasses.replace(recording, reference=None, subject=subject)


@dataclass(frozen=True)
class Places:
    """Folders of a reproduction."""

    folder: Path

    @property
    def page(self) -> Path:
        """The page that shows everything."""
        return self.folder / "index.html"

    def recording(self, name: str) -> Path:
        """Folder of a recording."""
        return self.folder / "recordings" / name

    def run(self, recording: str, planned: PlannedRun) -> Path:
        """File of a run."""
        return self.folder / "runs" / recording / f"{planned.name}.npz"


def places_in(folder: Path | None, *, short: bool) -> Places:
    """Make the folder where it is missing: that one, or one in the program's own data folder.

    Raises InputError where that cannot be.
    """
    if folder is None:
        name = "reproduce-short" if short else "reproduce"
        folder = user_data_path("stereotrack", appauthor=False) / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be created ({error.strerror})",
            where=str(folder),
            remedy="Give a folder that you may write to: stereotrack reproduce DIR.",
        ) from error
    return Places(folder)


def kept_run(
    places: Places, recording: Recording, fingerprint: str, planned: PlannedRun
) -> Run | None:
    """A run that is there and was made as it would be made now; else None.

    The program's version may be another one; it is told beside the results.
    """
    path = places.run(recording.name, planned)
    if not path.is_file():
        return None
    try:
        run = read_npz(path)
    except InputError:  # damaged: it is made anew
        return None
    wanted = {
        "parameters": planned.spec().settings.values(),
        "seed": planned.seed,
        "fingerprint": fingerprint,
        "way": planned.way,
    }
    same = all(run.meta.get(key) == value for key, value in wanted.items())
    reference = recording.reference
    whole = reference is not None and len(run.frame) == len(reference.frame)
    return run if same and whole else None


def kept_runs(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> Iterator[tuple[Group, list[tuple[Recording, PlannedRun, Run | None]]]]:
    """Every group with its planned runs, their recordings and the runs that are there."""
    by_name = {recording.name: (recording, fingerprint(recording)) for recording in recordings}
    for group in groups:
        recording, print_ = by_name[group.recording]
        yield (
            group,
            [(recording, one, kept_run(places, recording, print_, one)) for one in group.runs],
        )


def missing_recordings(places: Places, *, short: bool) -> tuple[ThesisRecording, ...]:
    """What has to be rendered of the four recordings.

    Raises InputError where a recording is there that is another one.
    """
    wanted = thesis_recordings(short=short)
    for one in wanted:
        if _is_there(places, one):
            _opened(places, one)
    return tuple(one for one in wanted if not _is_there(places, one))


def render_recording(
    places: Places,
    one: ThesisRecording,
    on_progress: Callable[[int, int], None],
    cancelled: Callable[[], bool],
) -> None:
    """Render a recording. Raises Cancelled: nothing of it is left behind."""
    places.recording(one.name).parent.mkdir(parents=True, exist_ok=True)
    simulation = Simulation(one.name, frames=one.frames, options=one.options, parts=one.parts)
    simulate(places.recording(one.name), simulation, on_progress=on_progress, cancelled=cancelled)


def opened_recordings(places: Places, *, short: bool) -> tuple[Recording, ...]:
    """The four recordings; all must be there."""
    return tuple(_opened(places, one) for one in thesis_recordings(short=short))


def _is_there(places: Places, one: ThesisRecording) -> bool:
    return (places.recording(one.name) / "recording.toml").is_file()


def _opened(places: Places, one: ThesisRecording) -> Recording:
    """Open a recording that is the wanted one: its motions, frames and lenses."""
    recording = open_recording(places.recording(one.name))
    frames = 0 if recording.reference is None else len(recording.reference.frame)
    planned = [(part.name, part.first, part.end) for part in one.parts]
    found = [(segment.name, segment.first, segment.end) for segment in recording.segments]
    options = one.options
    lenses = {
        (camera.width, camera.height, round(float(camera.matrix[0, 0]), 3))
        for camera in recording.cameras.values()
    }
    right = {(options.width, options.height, round(options.focal, 3))}
    if frames != one.frames or found != planned or lenses != right:
        raise InputError(
            "this is a different recording from the one that this version would create",
            where=str(recording.folder),
            remedy="Choose another folder, or delete this recording.",
        )
    return recording
