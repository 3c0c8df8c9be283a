"""A study from its description to its tables."""

import csv
import dataclasses
import math

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import choose, save_reference
from stereotrack_core.project.marks import mark_keyframes
from stereotrack_core.project.project import Project
from stereotrack_core.project.scenarios import keep_scenario
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.study import job as job_module
from stereotrack_core.study.description import with_recordings
from stereotrack_core.study.job import JobResult, failure
from stereotrack_core.study.points import grid_points, parsed_axis
from stereotrack_core.study.run import StudyRun, plan_study, summarised
from stereotrack_core.study.status import study_status
from stereotrack_core.study.store import (
    Store,
    read_table,
    stored_results,
    words_of,
    write_result_table,
)
from tests.study.conftest import InThisProcess, settings


def track(study):
    plan = plan_study(study, study.rows)
    study.runs.mkdir(exist_ok=True)
    with Store(study.table) as store:
        outcome = StudyRun(store, InThisProcess()).do(plan.jobs)
        assert all(result.done for result in store.results.values())
    return outcome.computed, plan


def status_of(study):
    found = study_status(study, study.rows, stored_results(study.table))
    return {row.row.recording: row for row in found}


@pytest.fixture
def ben(study, tmp_path):
    """The study with a project of one recording that has a reference."""
    folder = tmp_path / "data/ben/slow"
    recording = open_recording(folder)
    truth = recording.reference
    with Project.create(tmp_path / "data/ben/slow.stereotrack", folder) as project:
        reference = Reference(truth.frame, truth.points + [0.1, 0, 0], meta={})
        project.apply(save_reference("by hand", reference))
        project.apply(choose(REFERENCE, "by hand"))
        project.apply(mark_keyframes((0, 2, 4)))
        project.apply(mark_keyframes((2,), "done"))
        project.apply(place_clicks((Click(0, "N", "left_wrist", (3.0, 4.0), Visibility.SEEN),)))
    return with_recordings(study, [tmp_path / "data"]).study


def test_runs_are_kept_measured_and_not_computed_again(ben, tmp_path, monkeypatch):
    computed, plan = track(ben)
    assert (computed, plan.left_out) == (3, ())
    assert track(ben)[0] == 0

    rows = status_of(ben)
    slow, other = rows["data/ben/slow"], rows["data/anna/slow"]
    assert (len(slow.results), slow.failures) == (1, 0)
    assert slow.mean("torso_position") == pytest.approx(100, abs=10), "the project's reference"
    assert other.mean("torso_position") < 10
    assert (slow.clicks, slow.annotated) == (1, pytest.approx(100 / 3))

    # another reference: the run is only measured again
    with Project.open(tmp_path / "data/ben/slow.stereotrack") as project:
        project.apply(choose(REFERENCE, None))
    assert status_of(ben)["data/ben/slow"].results == ()
    with monkeypatch.context() as patch:
        patch.setattr(job_module, "track_together", lambda *_, **__: pytest.fail("tracked again"))
        assert track(ben)[0] == 1
    assert status_of(ben)["data/ben/slow"].mean("torso_position") < 10
    assert {len(row.messages) for row in status_of(ben).values()} == {0}

    # a stretch that gets a name: likewise, and it has columns of its own
    with Project.open(tmp_path / "data/ben/slow.stereotrack") as project:
        project.apply(keep_scenario("fast", range(1, 3)))
    with monkeypatch.context() as patch:
        patch.setattr(job_module, "track_together", lambda *_, **__: pytest.fail("tracked again"))
        assert track(ben)[0] == 1
    table = read_table(ben.table)
    assert {"fast/forearms", "fast/lost"} <= set(table.measures)
    assert words_of("fast/forearms") == "fast: forearms, mean [deg]"
    assert np.isfinite(table.numbers("fast/forearms")).sum() == 1

    # a run that is missing is tracked again
    (ben.runs / "data/ben/slow/").rename(tmp_path / "away")
    assert track(ben)[0] == 1
    results(ben, plan_study(ben, ben.rows).jobs, tmp_path)


def results(study, jobs, tmp_path):
    known = stored_results(study.table)
    written = write_result_table(tmp_path / "results.csv", study, jobs, known)
    with (tmp_path / "results.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
    assert len(found) == written
    assert list(found[0])[:4] == ["recording", "project", "subject", "condition"]
    assert {row["unit"] for row in found} >= {"mm", "deg", "%", "1", "s"}
    assert {row["subject"] for row in found} == {"anna", "ben"}
    ranges = [row for row in found if row["measure"] == "left_elbow_flexion"]
    assert {row["statistic"] for row in ranges} >= {"minimum", "maximum", "range"}
    p95 = [row for row in found if row["statistic"] == "95th percentile"]
    assert {row["unit"] for row in p95 if row["measure"] == "forearms"} == {"deg"}


def test_a_recording_that_cannot_be_tracked_does_not_stop_the_others(study, tmp_path):
    (tmp_path / "data/ben/slow/calibration.toml").unlink()
    (tmp_path / "data/anna/fast").rename(tmp_path / "data/anna/.gone")
    plan = plan_study(study, study.rows)
    assert [job.recording for job in plan.jobs] == ["data/anna/slow"]
    assert len(plan.left_out) == 2
    rows = status_of(study)
    assert "was not found" in rows["data/anna/fast"].messages[0]
    assert "calibration.toml" in rows["data/ben/slow"].messages[0]
    with pytest.raises(InputError, match="accurat"):
        plan_study(dataclasses.replace(study, settings=settings(preset="accurat")), study.rows)


@pytest.fixture
def jobs(plan):
    return plan(*grid_points([parsed_axis("iterations=2,3,4,5")]), seeds=(0, 1, 2))


def test_points_are_sorted_with_the_best_first(jobs):
    values = [5, 6, 7, 1, 2, None, 9, 9, 9, None, None, None]
    known = {
        job.identity: failure(job.identity, ValueError("bad"))
        if value is None
        else JobResult(job.identity, "done", {"forearms": value, "frames_per_second": value})
        for job, value in zip(jobs, values, strict=True)
    }
    found = summarised(jobs, known, "forearms")
    assert [one.point.by_name["iterations"] for one in found] == [3, 2, 4, 5]
    assert [(one.runs, one.failed) for one in found] == [(2, 1), (3, 0), (3, 0), (0, 3)]
    assert found[1].values["forearms"].mean == 6.0
    assert found[1].values["forearms"].deviation == 1.0
    assert math.isnan(found[1].values["unexplained_fraction"].mean)
    known.pop(jobs[0].identity)
    assert summarised(jobs[:2], known, "forearms")[0].runs == 1
