"""A damaged project is told from a whole one, and what can be read of it is saved."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.locks import lock_path
from stereotrack_core.project import rescue as rescue_module
from stereotrack_core.project.clicks import DeleteClicks, PlaceClicks, place
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.project import Project
from stereotrack_core.project.rescue import rescue

PAGE = 8192
ELBOW = Click(1, "N_right", "left_elbow", (10.25, 20.5))


@pytest.fixture
def clicks(project) -> dict[object, Click]:
    """Two thousand clicks in the project, made by twenty edits."""
    for first in range(0, 1000, 50):
        project.apply(
            PlaceClicks(
                tuple(
                    Click(frame, "N_right", landmark, (float(frame), 2.5))
                    for frame in range(first, first + 50)
                    for landmark in ("left_elbow", "right_elbow")
                )
            )
        )
    return {click.key: click for click in project.clicks.all()}


def damage(path: Path, page: int) -> None:
    with path.open("r+b") as file:
        file.seek(page * PAGE)
        file.write(os.urandom(PAGE))


def execute(project: Project, statement: str, *values: object) -> list[tuple[Any, ...]]:
    return project._access.rows(statement, values)


def pages_of(project: Project, table: str) -> list[int]:
    """Pages of a table besides its root, from 0."""
    rows = execute(project, "SELECT pageno FROM dbstat WHERE name = ? AND pagetype = 'leaf'", table)
    return [row[0] - 1 for row in rows]


@pytest.mark.parametrize("table", ["click", "edit_change", "edit"])
def test_what_one_table_has_lost_the_others_know(project, project_path, tmp_path, clicks, table):
    try:
        page = pages_of(project, table)[0]
    except Exception:  # noqa: BLE001 - depends on how SQLite was built
        pytest.skip("SQLite does not tell where its tables are")
    project.close()
    damage(project_path, page)
    target = tmp_path / "rescued.stereotrack"
    saved = rescue(project_path, target)
    with Project.open(target) as rescued:
        assert {click.key: click for click in rescued.clicks.all()} == clicks
        assert rescued.recording_place().name == "walk"
        assert rescued.check() == ()
        assert (rescued.undo() is not None) == saved.history_whole
        assert saved.history_whole == (table == "click")
        assert (saved.from_history > 0) == (table == "click")
        rescued.apply(place(ELBOW))


@pytest.mark.parametrize("seed", range(12))
def test_wherever_it_is_damaged_there_is_a_sentence_or_it_is_whole(
    project, project_path, tmp_path, clicks, seed
):
    project.close()
    pages = project_path.stat().st_size // PAGE
    damage(project_path, int(np.random.default_rng(seed).integers(1, pages)))
    before = project_path.read_bytes()
    target = tmp_path / "rescued.stereotrack"
    rescue(project_path, target)
    assert project_path.read_bytes() == before
    with Project.open(target) as rescued:
        found = {click.key: click for click in rescued.clicks.all()}
        assert set(found.items()) <= set(clicks.items())
        assert len(found) > 0.5 * len(clicks)
    with suppress(ProjectDamaged), Project.open(project_path) as damaged:
        damaged.clicks.all()
        damaged.undo()
        damaged.redo()


def test_a_project_without_a_beginning_is_not_rescued_but_its_copy_is_named(
    project, project_path, tmp_path, clicks
):
    project.close()
    damage(project_path, 0)
    with pytest.raises(InputError, match="not a stereotrack project"):
        Project.open(project_path)
    with pytest.raises(InputError, match=r"nothing in it can be read.*a copy made with"):
        rescue(project_path, tmp_path / "rescued.stereotrack")
    assert not (tmp_path / "rescued.stereotrack").exists()


@pytest.mark.parametrize("share", [0.6, 0.8, 0.95])
def test_a_project_that_ends_too_early_is_rescued_as_far_as_it_goes(
    project, project_path, tmp_path, clicks, share
):
    project.close()
    content = project_path.read_bytes()
    project_path.write_bytes(content[: int(share * len(content))])
    target = tmp_path / "rescued.stereotrack"
    rescue(project_path, target)
    with Project.open(target) as rescued:
        found = {click.key: click for click in rescued.clicks.all()}
    assert found
    assert set(found.items()) <= set(clicks.items())


def test_after_a_crash_damage_is_noticed_on_opening(project, project_path, clicks):
    crashed = project_path.with_name("crashed.stereotrack")
    shutil.copyfile(project_path, crashed)
    damage(crashed, crashed.stat().st_size // PAGE // 2)
    with pytest.raises(ProjectDamaged, match="recover what is readable"):
        Project.open(crashed)
    assert not lock_path(crashed).exists()


def test_a_file_of_rubbish_cannot_be_rescued(tmp_path):
    rubbish = tmp_path / "rubbish.stereotrack"
    rubbish.write_bytes(os.urandom(20000))
    with pytest.raises(InputError, match="nothing in it can be read"):
        rescue(rubbish, tmp_path / "target.stereotrack")
    assert {path.name for path in tmp_path.iterdir()} == {rubbish.name}
    with pytest.raises(InputError, match="there is no such file"):
        rescue(tmp_path / "missing.stereotrack", tmp_path / "target.stereotrack")


def test_a_deleted_click_stays_deleted(project, project_path, tmp_path, clicks):
    key = next(iter(clicks))
    project.apply(DeleteClicks((key,)))
    project.close()
    target = tmp_path / "rescued.stereotrack"
    assert rescue(project_path, target).history_whole
    with Project.open(target) as rescued:
        assert rescued.clicks.get(key).deleted
        assert rescued.undo().words.startswith("delete")


def test_a_full_drive_takes_nothing_that_was_saved(project, project_path):
    project.apply(place(ELBOW))
    pages = execute(project, "PRAGMA page_count")[0][0]
    execute(project, f"PRAGMA max_page_count = {pages}")
    many = PlaceClicks(tuple(Click(frame, "S_cam", "head", (1.0, 2.0)) for frame in range(5000)))
    with pytest.raises(InputError, match=r"no space left.*All earlier edits are saved"):
        project.apply(many)
    assert [click.key for click in project.clicks.all()] == [ELBOW.key]
    execute(project, "PRAGMA max_page_count = 1000000")
    project.apply(many)
    assert project.clicks.count() == 5001


@pytest.mark.parametrize("room", [0, 20, 30_000])
def test_a_rescue_to_a_full_drive_leaves_nothing(
    tmp_path, project_path, project, room, monkeypatch
):
    """Nor does one that is killed: the new project has its name when all of it is there."""
    from tests.end_to_end.writers import full_disk

    project.apply(PlaceClicks(tuple(Click(k, "S_cam", "head", (1.0, k)) for k in range(2000))))
    project.close()
    target = tmp_path / "new" / "rescued.stereotrack"
    target.parent.mkdir()
    fill = rescue_module._fill

    def fill_where_it_is_full(copy, path):
        assert not target.exists()
        with full_disk(room):
            return fill(copy, path)

    monkeypatch.setattr(rescue_module, "_fill", fill_where_it_is_full)
    with pytest.raises(InputError) as refused:
        rescue(project_path, target)
    assert str(target) in refused.value.where
    assert list(target.parent.iterdir()) == []
    with full_disk(room), pytest.raises(InputError, match="cannot be copied") as refused:
        rescue(project_path, target)
    assert refused.value.remedy.startswith("Free space in")
