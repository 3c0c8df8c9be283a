"""Points together, and how long the rest takes."""

import dataclasses
import math

import pytest

from stereotrack_core.experiments.runner.job import JobResult, failure
from stereotrack_core.experiments.sweep.plan import expected_seconds
from stereotrack_core.experiments.sweep.points import grid_points, parsed_axis
from stereotrack_core.experiments.sweep.run import summarised


@pytest.fixture
def jobs(plan):
    return plan(*grid_points([parsed_axis("iterations=2,3,4,5")]), seeds=(0, 1, 2))


def results_of(jobs, values):
    """Results with these forearm errors; None fails."""
    found = {}
    for job, value in zip(jobs, values, strict=True):
        found[job.identity] = (
            failure(job.identity, ValueError("bad"), final=False)
            if value is None
            else JobResult(job.identity, "done", {"forearms": value, "frames_per_second": value})
        )
    return found


def test_points_are_sorted_with_the_best_first(jobs):
    values = [5, 6, 7, 1, 2, None, 9, 9, 9, None, None, None]
    found = summarised(jobs, results_of(jobs, values), "forearms")
    assert [one.point.by_name["iterations"] for one in found] == [3, 2, 4, 5]
    assert [(one.runs, one.failed) for one in found] == [(2, 1), (3, 0), (3, 0), (0, 3)]
    assert found[1].values["forearms"].mean == 6.0
    assert found[1].values["forearms"].deviation == 1.0
    assert math.isnan(found[1].values["unexplained_fraction"].mean)
    assert math.isnan(found[3].values["forearms"].mean)
    fast = summarised(jobs, results_of(jobs, values), "frames_per_second")
    assert [one.point.by_name["iterations"] for one in fast] == [4, 2, 3, 5]


def test_jobs_without_a_result_are_left_out(jobs):
    results = results_of(jobs[:2], [1, 2])
    (found,) = summarised(jobs, results, "forearms")
    assert found.runs == 2


def test_the_rest_takes_what_the_same_took_before(jobs, plan):
    def took(seconds):
        return {jobs[0].identity: JobResult(jobs[0].identity, "done", {"seconds": seconds})}

    assert expected_seconds(jobs[1:], jobs, {}, 1) is None
    assert expected_seconds(jobs[1:], jobs, took(8.0), 2) == pytest.approx(11 * 8.0 / 2)
    longer = [
        dataclasses.replace(job, spec=dataclasses.replace(job.spec, frames=range(8)))
        for job in jobs[:3]
    ]
    assert expected_seconds(longer, jobs, took(8.0), 1) == pytest.approx(3 * 16.0)
    fewer = plan(*grid_points([parsed_axis("views=N")]))
    assert expected_seconds(fewer, jobs, took(8.0), 1) == pytest.approx(2.0)
