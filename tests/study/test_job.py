"""Batches of jobs in this process."""

import dataclasses

import pytest

from stereotrack_core.evaluation.failure_segments.reasons import WHY_WORDS
from stereotrack_core.evaluation.measures import MEASURES
from stereotrack_core.evaluation.summary import errors_against, summarise
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.study.description import StudyRecording
from stereotrack_core.study.job import do_batch
from stereotrack_core.study.points import Point, grid_points, parsed_axis
from stereotrack_core.study.status import RowStatus
from stereotrack_core.tracking import lockstep
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec


def by_identity(jobs, **options):
    return {result.identity: result for result in do_batch(jobs, **options)}


def test_results_are_those_of_runs_alone(plan, cones):
    jobs = plan(*grid_points([parsed_axis("iterations=2,4")]), seeds=(0, 3))
    results = by_identity(jobs)
    for job in jobs:
        run = track(
            cones, RunSpec(job.spec.settings, frames=range(4), seed=job.spec.seed, init="tpose")
        )
        reference = LandmarkTrajectory(cones.reference.frame[:4], cones.reference.points[:4])
        summary = summarise(errors_against(run.trajectory(), reference))
        result = results[job.identity]
        assert (result.status, result.frames, result.error) == ("done", 4, "")
        assert result.measures["forearms_p95"] == summary.measure("forearms").statistics.p95
        assert (
            result.measures["torso_position"] == summary.measure("torso_position").statistics.mean
        )
        assert result.measures["lost"] == 100.0 * summary.lost
        assert result.measures["unexplained_fraction"] == pytest.approx(
            100.0 * run.unexplained_fraction.mean()
        )
        assert result.measures["gaps"] == 0.0
        assert result.measures["seconds"] > 0
        assert result.measures["frames_per_second"] > 0
        names = {measure.name for measure in MEASURES}
        assert names - set(result.measures) <= {"lost_precision", "lost_recall", "keypoint_error"}
        assert {name for name in result.measures if "/" not in name} <= names
    assert len({result.measures["forearms"] for result in results.values()}) == 4


def test_a_kept_run_says_why_its_arm_searches_failed(plan, cones, tmp_path):
    """A reference whose arms point up: all of the cloud speaks against them, and no search errs."""
    points = cones.reference.points.copy()
    names = list(LANDMARKS)
    for side in ("left", "right"):
        shoulder = points[:, names.index(f"{side}_shoulder")]
        for joint, up in (("elbow", 0.3), ("hand", 0.55)):
            points[:, names.index(f"{side}_{joint}")] = shoulder + [0.0, 0.0, up]
    changes = {"pixel_step": 1, "speckle_size": 0, "data_points": 200, "fit_shape": False}
    (job,) = plan(Point(), changes=changes)
    job = dataclasses.replace(job, keep=str(tmp_path / "run.npz"))
    job = dataclasses.replace(job, truth=LandmarkTrajectory(cones.reference.frame, points))
    (result,) = do_batch([job])
    counts = {why: result.measures[f"failures_{why}:count"] for why in WHY_WORDS}
    assert counts["search"] == counts["right"] == 0.0
    assert sum(counts.values()) == result.measures["failures_by_error:count"] > 0
    row = RowStatus(StudyRecording("a"), results=(result,))
    assert row.reasons in {f"{why} {count:g}" for why, count in counts.items()}


def test_a_job_that_fails_stops_no_other(plan, monkeypatch):
    jobs = plan(*grid_points([parsed_axis("iterations=2,3,4")]))
    alone = by_identity(jobs[2:])
    whole = Follower.step

    def step(follower, state, cloud, recorder=None):
        if follower.setup.parameters.iterations == 3 and cloud.frame == 2:
            raise ZeroDivisionError("no hope")
        return whole(follower, state, cloud, recorder)

    monkeypatch.setattr(Follower, "step", step)
    results = by_identity(jobs)
    assert [results[job.identity].status for job in jobs] == ["done", "failed", "done"]
    failed = results[jobs[1].identity]
    assert (failed.error, failed.final) == ("ZeroDivisionError: no hope", False)
    kept = results[jobs[2].identity].measures
    assert kept["forearms"] == alone[jobs[2].identity].measures["forearms"]


def test_a_recording_that_is_another_by_now_fails_in_words(plan, copied):
    jobs = plan(Point(), recording=copied.open(), seeds=(0, 1))
    picture = copied.folder / "N_depth" / "0000.png"
    picture.write_bytes(picture.read_bytes() + b" ")
    for result in by_identity(jobs).values():
        assert result.final
        assert "the recording has changed since the work was started" in result.error
    (gone,) = do_batch([dataclasses.replace(jobs[0], folder=str(copied.folder / "none"))])
    assert gone.final
    assert "none" in gone.error


def test_no_tracker_sees_the_reference(plan, monkeypatch):
    seen = []
    whole = lockstep.Clouds

    def clouds(recording, *arguments):
        seen.append(recording.reference)
        return whole(recording, *arguments)

    monkeypatch.setattr(lockstep, "Clouds", clouds)
    by_identity(plan(Point()))
    assert seen == [None]
