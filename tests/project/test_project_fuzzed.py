"""Whatever happens to a project file: a sentence, never a traceback, and never a wrong click."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Prediction
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import BlindRepeat, DeleteClicks, PlaceClicks, place
from stereotrack_core.project.connection import Connection, most_steps
from stereotrack_core.project.database import make_database
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.marks import FrameFlag, SetFlags, SetKeyframes
from stereotrack_core.project.merging import clicks_of_project
from stereotrack_core.project.project import Project
from stereotrack_core.project.rescue import rescue
from stereotrack_core.project.runs import keep_run, kept_runs, load_run
from stereotrack_core.project.setups import (
    Corrections,
    ParameterSet,
    load_landmark_set,
    load_parameters,
    load_reference,
    load_subject,
    save_corrections,
    save_landmark_set,
    save_parameters,
    save_reference,
    save_subject,
)
from stereotrack_core.recording.description import Subject
from tests.project.spoiling import spoil
from tests.project.test_runs import run

HEAD = Click(500, "S_cam", "head", (1.0, 2.0))
PLACE = ("walk", "walk", "/nowhere/walk", "0" * 32)
MANY = 100


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A project that holds something of everything, and is the same every time."""
    path = tmp_path_factory.mktemp("whole") / "whole.stereotrack"
    make_database(path, PLACE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stereotrack_core.project.project.now", lambda: "2026-01-05T10:00:00.000")
        with Project.open(path, who="A") as project:
            fill(project)
    return path


def fill(project: Project) -> None:
    for first in range(0, 100, 10):
        clicks = [
            Click(frame, camera, landmark, (frame + 0.5, 3.0))
            for frame in range(first, first + 10)
            for camera in ("N_left", "S_cam")
            for landmark in ("left_elbow", "head")
        ]
        project.apply(PlaceClicks(tuple(clicks)))
    project.apply(SetKeyframes((1, 2, 3)))
    project.apply(SetFlags((FrameFlag(3),)))
    for edit in (
        save_subject(Subject("P", shoulder_width=0.4)),
        save_landmark_set(NINE),
        save_parameters("mine", ParameterSet("accurate", {"model_points": 40})),
        save_corrections("1", Corrections("because", {"N/left": 0.04}, {"N/left": 2})),
        save_reference("r", Reference(np.arange(5), np.ones((5, 9, 3)))),
        keep_run("accurate", run(), "a note"),
        BlindRepeat(1, PlaceClicks((HEAD,))),
    ):
        project.apply(edit)
    for table, name in (("subject", "P"), ("landmark_set", NINE.name), ("description", "1")):
        project.apply(Choose(table, name))
    project.predictions.replace("x", [Prediction(3, "S_cam", "head", "x", (1.0, 2.0))])
    project.view_settings.set("frame", 3)
    project.undo()


def use_everything(project: Project) -> None:
    uses: list[Callable[[], object]] = [
        lambda: project.clicks.all(with_deleted=True),
        project.clicks.seen,
        project.clicks.frames,
        project.clicks.doubted_frames,
        lambda: project.clicks.at(3),
        project.clicks.again,
        project.clicks.repeat_differences,
        project.progress,
        project.marks.flags,
        lambda: project.predictions.of_source("x"),
        lambda: project.predictions.of_source("x"),
        lambda: [project.history.changes_of(one.number) for one in project.history.entries()],
        project.subject,
        project.landmark_set,
        project.corrections,
        lambda: [load_reference(project.references, one) for one in project.references.names()],
        lambda: [load_subject(project.subjects, one) for one in project.subjects.names()],
        lambda: [
            load_parameters(project.parameter_sets, one) for one in project.parameter_sets.names()
        ],
        lambda: [
            load_landmark_set(project.landmark_sets, one) for one in project.landmark_sets.names()
        ],
        lambda: [load_run(project.runs, one.name) for one in kept_runs(project.runs)],
        lambda: [one.facts.changed_words for one in kept_runs(project.runs)],
        project.recording_place,
        project.find_recording,
        lambda: project.view_settings.get("frame", 0),
        project.check,
        *(project.undo,) * 9,
        *(project.redo,) * 9,
        lambda: project.apply(place(HEAD)),
        lambda: project.apply(DeleteClicks((ClickKey(5, "S_cam", "head"),))),
        lambda: project.predictions.replace("x", []),
        lambda: project.view_settings.set("frame", 5),
        lambda: project.save_copy(project.path.with_stem("copy")),
    ]
    for use in uses:
        with suppress(InputError):
            use()


def use(path: Path, *, read_only: bool) -> None:
    with suppress(InputError), Project.open(path, read_only=read_only) as project:
        use_everything(project)


@pytest.fixture
def steps(monkeypatch) -> dict[Path, int]:
    """Most steps that one statement has taken, by file."""
    most: dict[Path, int] = {}
    ends = Connection._ends

    def counted(database: Connection) -> bool:
        ended = ends(database)
        most[database._path] = max(most.get(database._path, 0), database._steps)
        return ended

    monkeypatch.setattr(Connection, "_ends", counted)
    return most


def check_spoilt(whole: Path, folder: Path, seed: int) -> None:
    """A spoilt project is used for reading, for writing, merged and rescued."""
    folder.mkdir()
    path, target = folder / "spoilt.stereotrack", folder / "rescued.stereotrack"
    kind = spoil(whole, path, seed)
    before = path.read_bytes()
    use(path, read_only=True)
    assert path.read_bytes() == before
    with Project.open(whole, read_only=True) as other:
        known = {click.key: click for click in other.clicks.all()}
        with suppress(InputError):
            clicks_of_project(path, other)
    with suppress(InputError):
        saved = rescue(path, target)
        assert path.read_bytes() == before
        with Project.open(target) as rescued:
            assert rescued.check() == ()
            if kind in ("page", "end"):  # a letter that changed within a row cannot be noticed
                found = {click.key: click for click in rescued.clicks.all()}
                assert set(found.items()) <= set(known.items())
            use_everything(rescued)
            if saved.history_whole:
                while rescued.undo() is not None:
                    pass
                assert rescued.clicks.all() == ()
    use(path, read_only=False)


def check_stretch(whole: Path, folder: Path, seeds: range, steps: dict[Path, int]) -> None:
    for seed in seeds:
        try:
            check_spoilt(whole, folder / f"{seed}", seed)
        except Exception as error:
            error.add_note(f"seed {seed}")
            raise
    for path, most in steps.items():
        if path.exists():
            assert most <= most_steps(path) + 200_000, path


def test_a_spoilt_file_gives_sentences_and_what_can_be_saved(whole, tmp_path, steps):
    check_stretch(whole, tmp_path, range(30), steps)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 2000, MANY))
def test_two_thousand_spoilt_files_give_sentences(whole, tmp_path, steps, first):
    check_stretch(whole, tmp_path, range(first, first + MANY), steps)
