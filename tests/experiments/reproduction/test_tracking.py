"""Runs that share clouds, and runs that are begun anew at poses given from outside."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.reproduction.plan import (
    Group,
    Places,
    PlannedRun,
    averaged_subject,
)
from stereotrack_core.experiments.reproduction.results import write_results
from stereotrack_core.experiments.reproduction.runs import track_group
from stereotrack_core.experiments.reproduction.tables import outcome_of
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.motions import Part
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

FRAMES = 9
PARTS = (Part("t-pose", "t-pose", 0, 3), Part("point", "point", 5, 3))


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduction") / "P2"
    options = SceneOptions(width=480, height=360, focal=300.0, furnished=False, noise=1.0)
    simulate(folder, Simulation(person="P2", frames=FRAMES, options=options, parts=PARTS))
    return open_recording(folder)


def poses(recording, frames):
    return {frame: pose_of_landmarks(recording.reference.points[frame]) for frame in frames}


def tracked(recording, *entries, starts=None, **options):
    given = poses(recording, (0, 5)) if starts is None else starts
    average = averaged_subject([recording.subject])
    made = track_group(recording, Group("P2", entries), average, range(FRAMES), given, **options)
    return [run for _, run in made]


def same(a, b):
    assert a.tracked.all()
    return np.array_equal(a.landmarks, b.landmarks, equal_nan=True)


def test_a_run_that_shares_clouds_is_the_one_that_does_not(recording):
    ways = (PlannedRun("thesis"), PlannedRun("thesis", seed=1), PlannedRun("thesis", points=24))
    shared = tracked(recording, *ways)
    alone = track(
        recording,
        RunSpec(PlannedRun("thesis").spec().settings, seed=1, init="tpose", preset="thesis"),
    )
    assert same(shared[1], alone)
    assert not same(shared[0], shared[1])
    assert not same(shared[0], shared[2])
    assert shared[2].meta["parameters"]["model_points"] == 24
    assert shared[0].meta["started_at_reference"] == []


def test_no_truth_reaches_a_run_that_is_not_begun_anew(recording):
    wrong = replace(recording.reference, points=recording.reference.points + 0.5)
    lied_to = replace(recording, reference=wrong)
    entries = (PlannedRun("thesis"), PlannedRun("thesis", anew=True))
    plain, anew = tracked(recording, *entries)
    still_plain, misled = tracked(lied_to, *entries, starts=poses(lied_to, (0, 5)))
    assert same(plain, still_plain)
    assert not same(anew, misled)
    assert anew.meta["started_at_reference"] == [0, 5]
    assert plain.meta["started_at_reference"] == []


def test_runs_begun_anew_go_on_from_the_given_pose(recording):
    [run] = tracked(recording, PlannedRun("thesis", anew=True))
    [other] = tracked(recording, PlannedRun("thesis", anew=True), starts=poses(recording, (0,)))
    assert np.array_equal(run.frame, np.arange(FRAMES))
    assert np.array_equal(run.landmarks[:5], other.landmarks[:5], equal_nan=True)
    assert not np.array_equal(run.landmarks[5:], other.landmarks[5:], equal_nan=True)
    errors = outcome_of(recording, PlannedRun("thesis", anew=True), run).errors
    assert np.degrees(errors.upper_arm[5]).max() < 60.0


def test_averaged_proportions_are_another_body(recording):
    taller = replace(recording.subject, upper_arm_length=0.4)
    entries = Group("P2", (PlannedRun("thesis"), PlannedRun("thesis", averaged=True)))
    made = track_group(recording, entries, taller, range(FRAMES), {})
    own, averaged = (run for _, run in made)
    assert own.meta["subject"]["upper_arm_length"] != 0.4
    assert averaged.meta["subject"]["upper_arm_length"] == 0.4
    assert averaged.meta["proportions"] == "averaged"


def test_stopping_keeps_nothing_of_the_group(recording):
    seen = []
    with pytest.raises(Cancelled):
        tracked(
            recording, PlannedRun("thesis"), on_frames=seen.append,
            cancelled=lambda: len(seen) >= 2,
        )  # fmt: skip
    assert seen == [1, 1]


def test_the_page_is_written_before_anything_is_tracked(recording, tmp_path):
    places = Places(tmp_path)
    planned = [Group(recording.name, (PlannedRun("thesis"),))]
    write_results(places, [recording], planned, ["thesis", "fast"], short=True)
    page = places.page.read_text(encoding="utf-8")
    for name in preset("fast").values():
        assert name in page
