"""Lanes say what the project says, and follow it edit by edit."""

import numpy as np
import pytest

from app.features.annotate.lanes import AnnotationLanes
from app.widgets.timeline.lanes import Mark
from stereotrack_core.annotation.click import UNCERTAIN, Click, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.project.clicks import delete_clicks, move_clicks, place_clicks
from stereotrack_core.project.marks import FrameFlag, flag_frames, mark_keyframes

FRAMES = 60


@pytest.fixture
def lanes(project):
    made = AnnotationLanes(project, FRAMES, cameras=4)
    project.on_change(made.follow)
    return made


def marks_of(lanes, landmark):
    return next(lane.values for lane in lanes.lanes() if lane.id == landmark)


def test_a_landmark_is_clicked_partly_flagged_missing_or_a_gap(project, lanes, make):
    project.apply(place_clicks(make.clicks_at([3], cameras=("N", "O"))[:5]))
    project.apply(place_clicks((Click(4, "N", "head", (3.0, 4.0)),)))
    project.apply(place_clicks((Click(5, "N", "head", (3.0, 4.0), flag=UNCERTAIN),)))
    project.apply(place_clicks((Click(6, "N", "head", None, Visibility.OUTSIDE),)))
    project.apply(mark_keyframes((8,)))
    project.apply(flag_frames((FrameFlag(9, "", "gap"), FrameFlag(10, "head", "gap"))))
    project.apply(flag_frames((FrameFlag(11, "head", "review"),)))
    head = marks_of(lanes, "head")
    said = [Mark(int(mark)).name for mark in head[3:12]]
    assert said == [
        "MISSING", "PARTLY", "FLAGGED", "NONE", "NONE", "MISSING", "GAP", "GAP", "FLAGGED",
    ]  # fmt: skip
    elbow = marks_of(lanes, "left_elbow")
    assert [Mark(int(m)).name for m in elbow[8:12]] == ["MISSING", "GAP", "NONE", "NONE"]
    assert marks_of(lanes, "left_shoulder")[3] == Mark.PARTLY


def test_following_edits_is_the_same_as_reading_everything(project, lanes, make):
    rng = np.random.default_rng(5)
    for _ in range(60):
        frames = rng.integers(0, FRAMES, 2)
        clicks = make.clicks_at(frames.tolist(), cameras=("N", "W"))
        chosen = [clicks[i] for i in rng.integers(0, len(clicks), 4)]
        edits = (
            place_clicks(tuple(chosen)),
            delete_clicks(tuple(one.key for one in chosen)),
            flag_frames((FrameFlag(int(frames[0]), "", "gap"),), off=bool(rng.integers(2))),
            flag_frames((FrameFlag(int(frames[1]), "head"),)),
            mark_keyframes((int(frames[0]),), ("wanted", "done", "none")[rng.integers(3)]),
        )
        project.apply(edits[rng.integers(5)])
        if rng.random() < 0.3:
            project.undo()
    afresh = AnnotationLanes(project, FRAMES, cameras=4)
    for name in NINE.names:
        np.testing.assert_array_equal(marks_of(lanes, name), marks_of(afresh, name))


def test_the_fitted_trajectory_fills_lanes_in(project, lanes, make):
    project.apply(place_clicks(make.clicks_at([10, 20])))
    frame = np.arange(10, 21)
    filled = ~np.isin(frame, (10, 20))
    points = np.stack([make.places_at(int(k)) for k in frame])
    points[5] = np.nan
    sigma = np.full((11, 6), 2.5)
    lanes.show_reference(Reference(frame, points, None, sigma, filled))
    head = marks_of(lanes, "head")
    assert head[10] == head[20] == Mark.CLICKED
    assert head[11] == Mark.INTERPOLATED
    assert head[15] == Mark.NONE
    torso = next(lane for lane in lanes.lanes() if lane.id == "torso ±")
    assert torso.value_text(12) == "2.5 °"
    assert torso.value_text(30) == "unknown"
    lanes.show_reference(None)
    assert marks_of(lanes, "head")[11] == Mark.NONE


def test_a_keyframe_that_is_filled_in_is_still_missing(project, lanes, make):
    project.apply(mark_keyframes((12,)))
    frame = np.arange(10, 15)
    points = np.stack([make.places_at(int(k)) for k in frame])
    lanes.show_reference(Reference(frame, points, filled=np.ones(5, dtype=np.bool_)))
    said = [Mark(int(mark)).name for mark in marks_of(lanes, "head")[10:15]]
    assert said == ["INTERPOLATED", "INTERPOLATED", "MISSING", "INTERPOLATED", "INTERPOLATED"]
    project.apply(flag_frames((FrameFlag(13, "head", "gap"),)))
    assert marks_of(lanes, "head")[13] == Mark.GAP


def test_what_looks_like_an_outlier_is_flagged_until_it_is_edited(project, lanes, make):
    project.apply(place_clicks(make.clicks_at([10, 20])))
    frame = np.array([10, 20])
    points = np.stack([make.places_at(int(k)) for k in frame])
    key = ClickKey(10, "N", "head")
    lanes.show_reference(Reference(frame, points), outliers=[key])
    assert marks_of(lanes, "head")[10] == Mark.FLAGGED
    assert lanes.flagged_frames().tolist() == [10]
    project.apply(move_clicks((key,), (10.0, 0.0)))
    assert marks_of(lanes, "head")[10] == Mark.CLICKED


def test_flagged_frames_are_found_both_ways(project, lanes):
    project.apply(flag_frames((FrameFlag(12, "head"), FrameFlag(40, "head"))))
    assert lanes.next_flagged(12) == 40
    assert lanes.next_flagged(40) is None
    assert lanes.next_flagged(40, backwards=True) == 12
