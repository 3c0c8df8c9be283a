"""Whatever happens to a project file: a sentence, never a traceback, and never a wrong click."""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.errors import InputError
from stereotrack_core.project.click_edits import (
    DeleteClicks,
    PlaceClicks,
    PlaceRepeats,
    place,
)
from stereotrack_core.project.marks import FrameFlag, SetFlags, SetKeyframes
from stereotrack_core.project.project import Project
from stereotrack_core.project.references import Reference, load_reference, save_reference
from stereotrack_core.project.rescue import rescue
from stereotrack_core.project.setups import load_subject, save_subject
from stereotrack_core.recording.description import Subject

PAGE = 4096
HEAD = Click(500, "S_cam", "head", (1.0, 2.0))


@pytest.fixture
def whole(project, project_path) -> tuple[bytes, dict[ClickKey, Click]]:
    """A project that holds something of everything, and its clicks."""
    for first in range(0, 100, 10):
        project.apply(
            PlaceClicks(
                tuple(
                    Click(frame, camera, landmark, (frame + 0.5, 3.0))
                    for frame in range(first, first + 10)
                    for camera in ("N_left", "S_cam")
                    for landmark in ("left_elbow", "head")
                )
            )
        )
    project.apply(SetKeyframes((1, 2, 3)))
    project.apply(SetFlags((FrameFlag(3),)))
    project.apply(save_subject(Subject("P", shoulder_width=0.4)))
    project.apply(save_reference("r", Reference(np.arange(5), np.ones((5, 9, 3)))))
    project.predictions.replace("x", [Prediction(3, "S_cam", "head", "x", (1.0, 2.0))])
    project.apply(PlaceRepeats(1, (HEAD,)))
    project.undo()
    clicks = {click.key: click for click in project.clicks.all()}
    project.close()
    return project_path.read_bytes(), clicks


def spoilt(content: bytes, choose: random.Random) -> tuple[str, bytes]:
    """A page of rubbish, wrong bytes, wrong letters, or an end that comes too soon."""
    spoilt = bytearray(content)
    match kind := choose.choice(["page", "bytes", "letters", "end"]):
        case "page":
            first = PAGE * choose.randrange(len(content) // PAGE)
            spoilt[first : first + PAGE] = choose.randbytes(PAGE)
        case "bytes":
            for _ in range(choose.choice([1, 20, 400])):
                spoilt[choose.randrange(len(content))] = choose.randrange(256)
        case "letters":
            for place_of_letter in choose.choices(range(len(content)), k=30):
                if content[place_of_letter] >= ord(" "):
                    spoilt[place_of_letter] = choose.choice(b'0123456789abc"[]{},\xff')
        case "end":
            del spoilt[choose.randrange(len(content)) :]
    return kind, bytes(spoilt)


def use_everything(project: Project) -> None:
    uses: list[Callable[[], object]] = [
        lambda: project.clicks.all(with_deleted=True),
        project.clicks.seen,
        project.progress,
        lambda: project.predictions.at(3),
        project.history.entries,
        project.subject,
        project.landmark_set,
        lambda: load_reference(project.references, "r"),
        lambda: load_subject(project.subjects, "P"),
        project.clicks.again,
        project.recording_place,
        lambda: project.view_settings.get("frame"),
        project.check,
        project.undo,
        project.redo,
        lambda: project.apply(place(HEAD)),
        lambda: project.apply(DeleteClicks((ClickKey(5, "S_cam", "head"),))),
        project.back_up,
    ]
    for use in uses:
        with suppress(InputError):
            use()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(120))
def test_a_spoilt_file_gives_sentences_and_what_can_be_saved(whole, tmp_path, seed):
    content, clicks = whole
    kind, changed = spoilt(content, random.Random(seed))
    path, target = tmp_path / "spoilt.stereotrack", tmp_path / "rescued.stereotrack"
    path.write_bytes(changed)
    with suppress(InputError), Project.open(path) as project:
        use_everything(project)
    clean_away(path)
    path.write_bytes(changed)
    with suppress(InputError):
        saved = rescue(path, target)
        with Project.open(target) as rescued:
            assert rescued.check() == ()
            if kind in ("page", "end"):  # a letter that changed within a row cannot be noticed
                found = {click.key: click for click in rescued.clicks.all()}
                assert set(found.items()) <= set(clicks.items())
            use_everything(rescued)
            if saved.history_whole:
                while rescued.undo() is not None:
                    pass
                assert rescued.clicks.all() == ()


def clean_away(path: Path) -> None:
    for each in [*path.parent.glob(f"{path.stem}*"), *path.parent.glob(f".{path.stem}*")]:
        each.unlink()
