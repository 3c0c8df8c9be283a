"""What is drawn of errors against circumstances, without a window."""

from __future__ import annotations

import numpy as np
import pytest

from app.features.review.explaining import Explained, cameras_of, circumstances, content_of, poses
from app.features.review.limb_numbers import as_csv, numbers_of, stretches_of
from app.session.judgement import judged
from app.session.runs import entry_of_run
from app.session.truth import recorded_truth
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.folder import open_recording
from tests.gui.made_runs import made_run


@pytest.fixture(scope="module")
def recording(small_recording):
    return open_recording(small_recording)


def entry(recording, tmp_path, **wanted):
    made = made_run(recording, **wanted)
    made.meta["views"] = ["S"]
    return entry_of_run(made, tmp_path / "run.npz")


def test_only_views_that_a_run_was_tracked_with_count(recording, tmp_path):
    one = entry(recording, tmp_path)
    (camera,) = cameras_of(one, recording)
    assert camera is recording.reference_camera(recording.view("S"))
    del one.stored.meta["views"]
    assert len(cameras_of(one, recording)) == 2


def test_the_truths_places_and_poses_are_used_and_the_runs_own_without_it(recording, tmp_path):
    one = entry(recording, tmp_path, off=0.3)
    truth = recorded_truth(recording.reference)
    with_truth, alone = judged(one.now(), truth), judged(one.now(), None)
    far = [circumstances(one, judgement, recording).distance for judgement in (with_truth, alone)]
    arm = LIMBS.index("left_forearm")
    assert np.abs(far[0][:, arm] - far[1][:, arm]).min() > 1e-3
    torso = LIMBS.index("torso")
    np.testing.assert_allclose(far[0][:, torso], far[1][:, torso], atol=0.05)
    own = poses(one, alone)
    np.testing.assert_array_equal(own[0].rotations, one.at(0).pose.rotations)
    assert np.abs(poses(one, with_truth)[0].rotations - own[0].rotations).max() > 0.1


def test_a_selection_chooses_points_and_bins(recording, tmp_path):
    one = entry(recording, tmp_path, off=0.05, wild=(5, 6))
    judgement = judged(one.now(), recorded_truth(recording.reference))
    run = Explained(one.name, judgement, circumstances(one, judgement, recording))
    whole = content_of("histogram", [run], None)
    calm = content_of("histogram", [run], range(5))
    assert max(s.edges[-1] for s in whole.steps) > 80 > max(s.edges[-1] for s in calm.steps)
    cloud = content_of("distance", [run], range(5)).clouds[0]
    assert cloud.chosen.tolist() == [True] * 5 + [False] * 3
    assert content_of("views", [run], None).clouds == ()  # not worked out yet
    assert "being computed" in content_of("views", [run], None).words
    assert content_of("speed", [], None) is None


def test_statistics_become_csv_with_every_segment(recording, tmp_path):
    one = entry(recording, tmp_path, wild=(5, 6))
    judgements = {one: judged(one.now(), recorded_truth(recording.reference))}
    stretches = stretches_of(None, 8, (Segment("end", 5, 7),))
    numbers = numbers_of([one], judgements, stretches, 30.0)
    text = as_csv(numbers, 30.0).splitlines()
    assert len(text) == 1 + 2 * 6
    end = next(line for line in text if ",end,5,7,left_upper_arm," in line).split(",")
    assert float(end[-2]) == 100.0
    assert float(end[-1]) == 100.0
    assert stretches_of(range(2, 4), 8, ())[0] == Segment("selection", 2, 4)
