"""A damaged project is told from a whole one, and its backup is named."""

from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.locks import lock_path
from stereotrack_core.project.clicks import place, place_clicks
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.project import Project

PAGE = 8192
ELBOW = Click(1, "N_right", "left_elbow", (10.25, 20.5))


@pytest.fixture
def clicks(project) -> dict[object, Click]:
    """Two thousand clicks in the project, made by twenty edits."""
    for first in range(0, 1000, 50):
        project.apply(
            place_clicks(
                tuple(
                    Click(frame, "N_right", landmark, (float(frame), 2.5))
                    for frame in range(first, first + 50)
                    for landmark in ("left_elbow", "right_elbow")
                )
            )
        )
    return {click.key: click for click in project.clicks.all()}


def damage(path: Path, page: int) -> None:
    content = bytearray(path.read_bytes())
    content[page * PAGE : (page + 1) * PAGE] = np.random.default_rng(page).bytes(PAGE)
    path.write_bytes(content)


def refuse(path: Path) -> str:
    """What both ways of opening a damaged project say, which changes nothing."""
    before = path.read_bytes()
    for read_only in (True, False):
        with pytest.raises(ProjectDamaged) as refused:
            Project.open(path, read_only=read_only)
        assert path.read_bytes() == before
        assert not lock_path(path).exists()
    return str(refused.value)


@pytest.mark.parametrize("seed", range(3))
def test_a_page_of_rubbish_is_noticed_wherever_it_is(project, project_path, clicks, seed):
    project.close()
    pages = project_path.stat().st_size // PAGE
    damage(project_path, int(np.random.default_rng(seed).integers(1, pages)))
    said = refuse(project_path)
    assert "Open a copy made with File, Project, Save a copy" in said
    assert "This file is not changed." in said


def test_the_backup_made_before_a_change_of_format_is_named(project, project_path, clicks):
    backup = project_path.with_name("walk.format1.stereotrack")
    project.save_copy(backup)
    project.close()
    damage(project_path, project_path.stat().st_size // PAGE // 2)
    said = refuse(project_path)
    assert "Open its backup with File, Open a project" in said
    assert f"`stereotrack open {backup}`" in said
    with Project.open(backup) as opened:
        assert {click.key: click for click in opened.clicks.all()} == clicks


def test_a_full_drive_takes_nothing_that_was_saved(project, project_path):
    def limit(pages: int) -> None:
        with project._access.alone() as database:
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
            database.execute(f"PRAGMA max_page_count = {pages}").fetchall()

    project.apply(place(ELBOW))
    limit(1)  # no more than there are
    many = place_clicks(tuple(Click(frame, "S_cam", "head", (1.0, 2.0)) for frame in range(5000)))
    with pytest.raises(InputError, match=r"no space left.*All earlier edits are saved"):
        project.apply(many)
    assert [click.key for click in project.clicks.all()] == [ELBOW.key]
    limit(1_000_000)
    project.apply(many)
    assert project.clicks.count() == 5001
