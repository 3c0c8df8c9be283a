"""What is tracked for which table."""

from stereotrack_core.experiments.reproduction.plan import (
    PlannedRun,
    averaged_subject,
    groups,
    recording_for,
)
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.landmarks import LandmarkTrajectory

PEOPLE = ("P1", "P2", "P3", "P4")


def ways(planned, recording):
    return [e for group in planned if group.recording == recording for e in group.runs]


def test_all_tables_have_their_runs_and_none_is_planned_twice():
    planned = groups(PEOPLE, ("thesis", "accurate"), 5)
    entries = ways(planned, "P1")
    assert len(entries) == len(set(entries))
    names = {entry.name for entry in entries if entry.seed == 4}
    assert names == {
        *("thesis-seed4", "thesis-anew-seed4", "thesis-NS-seed4", "thesis-averaged-seed4"),
        *("thesis-m24-seed4", "thesis-m40-seed4", "thesis-m120-seed4"),
    }
    assert {entry.name for entry in entries if entry.preset == "accurate"} == {
        *("accurate-seed0", "accurate-averaged-seed0", "accurate-NS-seed0"),
    }


def test_p3_is_left_out_with_two_cameras():
    planned = groups(PEOPLE, ("thesis",), 1)
    assert not any(entry.few_views for entry in ways(planned, "P3"))
    assert any(entry.few_views for entry in ways(planned, "P4"))


def test_runs_of_a_group_see_the_same_clouds():
    for group in groups(PEOPLE, ("thesis", "accurate"), 2):
        ways_ = set(group.runs)
        assert len({way.few_views for way in ways_}) == 1
        assert len({way.spec().settings.depth for way in ways_}) == 1


def test_what_tells_most_comes_first():
    planned = groups(PEOPLE, ("thesis", "accurate"), 5)
    assert [group.recording for group in planned[:4]] == list(PEOPLE)
    assert {entry.way for entry in planned[0].runs} == {"thesis", "thesis-anew"}


def test_the_number_of_points_is_all_that_differs():
    usual, few = (
        PlannedRun("thesis").spec().settings,
        PlannedRun("thesis", points=24).spec().settings,
    )
    assert few == usual.replaced(model_points=24)
    assert PlannedRun("thesis", points=24, seed=3).name == "thesis-m24-seed3"


def test_averaged_lengths_are_means_of_what_is_known():
    average = averaged_subject(
        [Subject("a", shoulder_width=0.3, hip_width=0.2), Subject("b", shoulder_width=0.4), None]
    )
    assert average == Subject("averaged", shoulder_width=0.35, hip_width=0.2)


def test_no_tracker_gets_the_reference(tmp_path):
    import numpy as np

    truth = LandmarkTrajectory(np.arange(2), np.zeros((2, 9, 3)))
    own, average = Subject("own"), Subject("averaged")
    recording = Recording(tmp_path, "P1", 10.0, (), {}, own, truth)
    for way in (
        PlannedRun("thesis"),
        PlannedRun("thesis", anew=True),
        PlannedRun("accurate", averaged=True),
    ):
        given = recording_for(way, recording, average)
        assert given.reference is None
        assert given.subject == (average if way.averaged else own)
