import csv
import dataclasses
import shutil

import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.run import SweepRun
from stereotrack_core.experiments.sweep.store import SweepStore
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import keep_run
from stereotrack_core.project.setups import Corrections, save_corrections, save_reference
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.create import create_study
from stereotrack_core.study.results import result_columns, write_result_table
from stereotrack_core.study.run import StudyRequest, places_of, plan_study, write_reports
from stereotrack_core.study.status import study_status
from tests.study.conftest import SETTINGS, InThisProcess


def track(study, **more):
    """Track; how many were computed, and the runs' files."""
    plan = plan_study(StudyRequest(study.path, **{**SETTINGS, **more}))
    store = SweepStore(places_of(study))
    try:
        outcome = SweepRun(plan.sweep, store, InThisProcess()).do()
    finally:
        store.close()
    assert all(result.done for result in store.results.values())
    return outcome.computed, [job.keep for job in plan.sweep.jobs], plan


def status_of(study):
    cache = StudyCache(study.cache)
    return {row.row.recording: row for row in study_status(study, cache)}


@pytest.fixture
def ben(study, tmp_path):
    """The study with a project of one recording that has a reference, and is calibrated better."""
    folder = tmp_path / "data/ben/slow"
    recording = open_recording(folder)
    truth = recording.reference
    cameras = {
        name: dataclasses.replace(camera, matrix=camera.matrix * [[1.001], [1.001], [1]])
        for name, camera in recording.cameras.items()
    }
    with Project.create(tmp_path / "data/ben/slow.stereotrack", folder) as project:
        reference = Reference(truth.frame, truth.points + [0.1, 0, 0], meta={})
        project.apply(save_reference("by hand", reference))
        project.apply(Choose("reference", "by hand"))
        project.apply(save_corrections("better", Corrections("a board", cameras=cameras)))
        project.apply(Choose("description", "better"))
    return create_study(study.path, [tmp_path / "data"]).study


def test_runs_are_kept_measured_and_not_computed_again(ben, tmp_path):
    computed, files, plan = track(ben)
    assert (computed, plan.left_out) == (3, ())
    assert track(ben)[0] == 0

    rows = status_of(ben)
    slow = rows["data/ben/slow"].shown
    assert str(slow.place.path) in files
    assert (slow.outdated, slow.failures, slow.facts.reference) == ((), 0, "by hand")
    assert slow.facts.value("torso_position", "mean") == pytest.approx(100, abs=10)
    other = rows["data/anna/slow"].shown
    assert other.facts.reference == "the recording's reference"
    assert other.facts.value("torso_position", "mean") < 10

    (tmp_path / "data/anna/slow/reference.csv").unlink(missing_ok=True)
    slow.place.path.unlink()
    assert track(ben, select=("condition=slow",))[0] == 1, "only the run that is missing"
    (tmp_path / "data/ben/slow.stereotrack").unlink()
    ben = dataclasses.replace(
        ben, rows=tuple(dataclasses.replace(row, project="") for row in ben.rows)
    )
    assert status_of(ben)["data/ben/slow"].shown.outdated == ("the calibration has changed since",)
    results(ben, tmp_path)


def results(study, tmp_path):
    """All numbers of its runs are one table, in both formats."""
    rows = tuple(status_of(study).values())
    written = write_result_table(tmp_path / "results.csv", study, rows)
    with (tmp_path / "results.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
    assert len(found) == written
    assert tuple(found[0]) == result_columns(study)
    assert {row["unit"] for row in found} >= {"mm", "deg", "deg/s", "%", "1", "s"}
    assert {row["subject"] for row in found} == {"anna", "ben"}
    ranges = [row for row in found if row["measure"] == "left_elbow_flexion"]
    assert {row["statistic"] for row in ranges} >= {"minimum", "maximum", "range"}
    assert {row["up_to_date"] for row in found if row["subject"] == "ben"} == {"no"}
    with pytest.raises(InputError, match="type of file"):
        write_result_table(tmp_path / "results.xlsx", study, rows)
    pytest.importorskip("pyarrow")
    from pyarrow import parquet

    assert write_result_table(tmp_path / "results.parquet", study, rows) == written
    table = parquet.read_table(tmp_path / "results.parquet").to_pylist()
    assert [row["value"] for row in table] == [float(row["value"]) for row in found]
    assert {row["seed"] for row in table} == {0}


@pytest.mark.slow
def test_a_page_about_a_run_is_written_once(study):
    track(study, select=("subject=ben",))
    row = status_of(study)["data/ben/slow"]
    files = [run.place.path for run in row.runs]
    assert write_reports([row], files) == (files[0].with_suffix(".html"),)
    assert write_reports([row], files) == ()


def test_a_recording_that_cannot_be_tracked_does_not_stop_the_others(study, tmp_path):
    (tmp_path / "data/ben/slow/calibration.toml").unlink()
    (tmp_path / "data/anna/fast").rename(tmp_path / "data/anna/.gone")
    plan = plan_study(StudyRequest(study.path, **SETTINGS))
    assert [job.recording for job in plan.sweep.jobs] == ["data/anna/slow"]
    assert len(plan.left_out) == 2
    with pytest.raises(InputError, match="accurat"):
        plan_study(StudyRequest(study.path, preset="accurat"))


def test_a_copy_has_a_run_of_its_own_and_is_told_of(study, tmp_path):
    shutil.copytree(tmp_path / "data/anna/slow", tmp_path / "data/carl/slow")
    with_copy = create_study(study.path, [tmp_path / "data"]).study
    assert track(with_copy)[0] == 4
    assert track(with_copy)[0] == 0
    rows = status_of(with_copy)
    for one, other in (("anna", "carl"), ("carl", "anna")):
        row = rows[f"data/{one}/slow"]
        assert row.shown is not None
        assert [finding.what for finding in row.findings] == [
            f"the same recording is also listed as data/{other}/slow"
        ]
    assert not rows["data/ben/slow"].findings


def test_different_settings_are_kept_side_by_side(study):
    def names(**more):
        plan = plan_study(StudyRequest(study.path, select=("subject=ben",), **more))
        return {job.keep.rpartition("/")[2] for job in plan.sweep.jobs}

    assert names() == {"accurate-seed0.npz"}
    assert names(seeds="0,1") == {"accurate-seed0.npz", "accurate-seed1.npz"}
    others = [{"views": "NS"}, {"frames": "0:3"}, {"changes": ("iterations=3",)}, {"smooth": True}]
    assert len(set.union(*(names(**more) for more in others))) == len(others)


def test_runs_of_the_project_are_measured_as_well(ben, tmp_path):
    _, files, _ = track(ben, select=("subject=anna", "condition=slow"))
    run = read_run(files[0])
    with Project.open(tmp_path / "data/ben/slow.stereotrack") as project:
        project.apply(keep_run("by window", run))
    row = status_of(ben)["data/ben/slow"]
    (own,) = row.runs
    assert (own.place.name, own.place.kept_in) == ("by window", "project")
    assert own.outdated == ("the recording has changed since",)
    assert own.facts.value("torso_position", "mean") == pytest.approx(100, abs=10)
