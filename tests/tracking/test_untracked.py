"""Where nothing was tracked, the step that took the points is named, with its remedy."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.writing import write_png
from stereotrack_core.tracking.run_checks import untracked_in
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import HEIGHT, SMALL, VIEWS, WIDTH, write_depth_recording
from tests.tracking.running import tracked_frames
from tests.tracking.scenes import pose_with_arms

FRAMES = 3


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Three frames of four depth views with masks."""
    pose = pose_with_arms([1, 0, 0], [1, 0, 0], [-1, 0, 0], [-1, 0, 0], place=(0, 0, 0.95))
    body = body_model(AVERAGE, SMALL.body)
    folder = tmp_path_factory.mktemp("untracked") / "cones"
    return write_depth_recording(folder, body, [pose] * FRAMES)


def with_views(recording, **changes):
    views = tuple(dataclasses.replace(view, **changes) for view in recording.views)
    return dataclasses.replace(recording, views=views)


def untracked(recording, **changes):
    settings = SMALL.replaced(**changes)
    frames, _ = tracked_frames(recording, RunSpec(settings, init="tpose"), range(FRAMES))
    return untracked_in([frame.without_cloud() for frame in frames], recording, settings)


def only_cause(recording, **changes):
    told = untracked(recording, **changes)
    [cause] = told.causes
    assert cause.views == VIEWS
    return cause.sentence(), told.counts["N"]


def test_of_frames_that_are_tracked_nothing_is_said(recording):
    told = untracked(recording)
    assert (told.causes, told.counts) == ((), {})


def test_points_outside_of_the_volume_are_told_with_where_they_are(recording):
    words, counts = only_cause(recording, volume_bottom=1.9, volume_x=6.0, volume_y=6.0)
    assert "0 of" in words
    assert "inside the working volume" in words
    assert "-3.0 to 3.0 by 1.9 to 4.3 m" in words
    assert "volume_bottom" in words
    assert counts.inside == 0 < counts.taken == counts.person == counts.measured
    assert np.linalg.norm(counts.middle) < 2.0


@pytest.mark.parametrize(("factor", "away"), [(1000.0, True), (0.001, False)])
def test_another_unit_is_told(factor, away, recording):
    unit = factor * recording.views[0].depth_unit
    words, _ = only_cause(with_views(recording, depth_unit=unit))
    assert "m from the camera" in words
    assert "`unit` of depth views" in words


def test_a_mask_that_leaves_nothing_is_told(recording, tmp_path):
    nobody = np.zeros((HEIGHT, WIDTH), dtype=bool)
    for k in range(FRAMES):
        write_png(recording.folder / f"nobody_{k}.png", nobody)
    masks = dataclasses.replace(recording.views[0].mask, frames="nobody_%d.png")
    words, counts = only_cause(with_views(recording, mask=masks))
    assert "the mask leaves 0 of" in words
    assert counts.measured > 0 == counts.person


def test_who_stands_still_is_part_of_a_background_that_is_learned(recording):
    words, counts = only_cause(with_views(recording, mask=None))
    assert "learned from the recording itself" in words
    assert "background_mode=none" in words
    assert counts.measured > 0 == counts.person


def test_points_without_neighbours_are_told(recording):
    words, counts = only_cause(recording, outlier_distance=1.0)
    assert "neighbours within 1 mm" in words
    assert "outlier_distance" in words
    assert counts.inside > 0 == counts.kept
