"""What has to be tracked for the tables: ways of tracking, and runs that share their clouds."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.tracking.parameters import Settings
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
class Way:
    """One way of tracking: a column of a table.

    Attributes
    ----------
    preset : str
    points : int or None
        Model points m, where they differ from the preset's.
    few_views : bool
        Two cameras instead of all.
    averaged : bool
        The same averaged proportions for everybody.
    anew : bool
        Put on the reference's pose at the beginning of every segment, instead of continuously
        from the first frame on. This is for judging alone: such a run knows the truth.
    """

    preset: str
    points: int | None = None
    few_views: bool = False
    averaged: bool = False
    anew: bool = False

    @property
    def name(self) -> str:
        """Short name, which is also part of the run's file name."""
        parts = [self.preset]
        parts += [] if self.points is None else [f"m{self.points}"]
        parts += ["NS"] if self.few_views else []
        parts += ["averaged"] if self.averaged else []
        parts += ["anew"] if self.anew else []
        return "-".join(parts)

    @property
    def settings(self) -> Settings:
        """All parameters."""
        own = preset(self.preset)
        return own if self.points is None else own.replaced(model_points=self.points)

    def spec(self, seed: int, frames: range, start: Pose | None = None) -> RunSpec:
        """A run; the thesis's people stood in a defined pose first, others find it."""
        return RunSpec(
            self.settings,
            preset=self.preset,
            frames=frames,
            views=FEW_VIEWS if self.few_views else None,
            seed=seed,
            init=start or ("tpose" if self.preset == THESIS else "auto"),
        )


@dataclass(frozen=True)
class Entry:
    """One run: a way of tracking with a seed."""

    way: Way
    seed: int

    @property
    def name(self) -> str:
        """Name of the run's file without its suffix."""
        return f"{self.way.name}-seed{self.seed}"


@dataclass(frozen=True)
class Group:
    """Runs of one recording that share clouds and go forward together.

    Attributes
    ----------
    recording : str
    entries : tuple of Entry
        All with the same views and depth parameters.
    """

    recording: str
    entries: tuple[Entry, ...]


def groups(recordings: Sequence[str], presets: Sequence[str], seeds: int) -> tuple[Group, ...]:
    """All runs, what tells most first: table 4.1, then the others.

    The preset ``thesis``, which draws points at random, runs with all seeds; others with one.
    """
    stages: list[list[Entry]] = []
    if THESIS in presets:
        stages.append(_entries([Way(THESIS), Way(THESIS, anew=True)], seeds))
    others = [name for name in presets if name != THESIS]
    stages += [_entries([Way(name), Way(name, averaged=True)], 1) for name in others]
    for name in presets:
        few = Way(name, few_views=True)
        stages.append(_entries([few], seeds if name == THESIS else 1))
    if THESIS in presets:
        more = [Way(THESIS, points=m) for m in POINTS if m != _REFERENCE_POINTS]
        stages.append(_entries([*more, Way(THESIS, averaged=True)], seeds))
    return tuple(
        Group(recording, tuple(stage))
        for stage in stages
        for recording in recordings
        if not (stage[0].way.few_views and recording == LEFT_OUT_WITH_FEW_VIEWS)
    )


def _entries(ways: Sequence[Way], seeds: int) -> list[Entry]:
    return [Entry(way, seed) for way in ways for seed in range(seeds)]


def averaged_subject(subjects: Sequence[Subject | None]) -> Subject:
    """Mean of everybody's lengths; a length that nobody has measured stays unknown."""
    known = [subject for subject in subjects if subject is not None]
    lengths: dict[str, float] = {}
    for field in dataclasses.fields(Subject):
        if field.name == "name":
            continue
        values = [getattr(subject, field.name) for subject in known]
        measured = [value for value in values if value is not None]
        if measured:
            lengths[field.name] = float(np.mean(measured))
    return Subject(name="averaged", **lengths)


def recording_for(way: Way, recording: Recording, average: Subject) -> Recording:
    """What a tracker may know of a recording: never its reference."""
    subject = average if way.averaged else recording.subject
    return dataclasses.replace(recording, reference=None, subject=subject)
