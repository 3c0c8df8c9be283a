"""Mono views are tracked by keypoints alone."""

import numpy as np
import pytest

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_journal import RunJournal, Wish, read_unfinished
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec, measured_keypoints
from tests.same_run import same_run
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import mono_recording, poses, truth
from tests.tracking.recordings import write_depth_recording
from tests.tracking.running import tracked_frames


@pytest.fixture(scope="module")
def mono(tmp_path_factory) -> Recording:
    return mono_recording(tmp_path_factory.mktemp("mono"))


def apart(run) -> np.ndarray:
    """Distances (F, 9) from the truth, metres."""
    return np.linalg.norm(run.landmarks - truth().points, axis=2)


def test_a_person_is_followed_without_any_cloud(mono):
    exact = KeypointErrors(noise=0.3, gross=0.05, exchanged=0.1)
    keypoints = simulated_keypoints(truth(), mono.cameras, exact, seed=3)
    spec = RunSpec(preset("accurate"), keypoints=keypoints)
    run = track(mono, spec)
    assert run.tracked.all()
    assert run.meta["keypoints"]["count"] == len(keypoints)
    assert run.meta["warnings"] == []
    assert np.median(apart(run)) < 0.015
    assert apart(run)[:, : LANDMARKS.index("left_hip")].max() < 0.12
    again = track(mono, spec)
    np.testing.assert_array_equal(run.x, again.x)
    smooth = track(mono, RunSpec(preset("accurate"), keypoints=keypoints, smooth=True))
    assert np.median(apart(smooth)) < 0.015


@pytest.mark.parametrize(("name", "beside_depth"), [("thesis", False), ("accurate", True)])
def test_beside_a_cloud_only_a_tracker_that_measures_keypoints_is_given_them(
    name, beside_depth, mono, tmp_path
):
    keypoints = simulated_keypoints(truth(), mono.cameras, KeypointErrors(), seed=3)
    settings = preset(name)
    depth = write_depth_recording(tmp_path / "depth", body_model(AVERAGE), poses()[:1])
    assert measured_keypoints(mono, settings, keypoints) is keypoints
    assert (measured_keypoints(depth, settings, keypoints) is keypoints) == beside_depth


def test_a_given_pose_is_kept_and_otherwise_the_first_frames_tell_it(mono):
    keypoints = simulated_keypoints(truth(), mono.cameras, KeypointErrors(noise=0.3), seed=3)
    given = displaced(poses()[0], np.r_[np.zeros(8), 0.5, np.zeros(5)], (2, 3, 4, 5))
    ready = []
    for init in ("auto", given):
        with Clouds(mono, RunSpec(preset("accurate"), keypoints=keypoints, init=init)) as clouds:
            ready.append(prepare(clouds))
    found, waiting = ready
    assert np.abs(found.state.pose.rotations - poses()[0].rotations).max() < 0.3
    assert waiting.init is given
    assert not waiting.started


def test_silhouettes_measure_what_noisy_keypoints_do_not(tmp_path):
    seen = mono_recording(tmp_path, seen=True)
    keypoints = simulated_keypoints(truth(), seen.cameras, KeypointErrors(noise=3.0), seed=1)
    off = []
    for measured in (False, True):
        chosen = preset("accurate").replaced(measure_silhouettes=measured)
        run = track(seen, RunSpec(chosen, keypoints=keypoints, smooth=True))
        off.append(np.median(apart(run)))
    assert off[1] < 0.7 * off[0]


def test_a_run_that_goes_on_is_the_one_that_nobody_stopped(mono, tmp_path):
    keypoints = simulated_keypoints(truth(), mono.cameras, KeypointErrors(noise=0.5), seed=2)
    spec = RunSpec(preset("accurate"), keypoints=keypoints, smooth=True)
    path, states = tmp_path / "run.part", []
    journal = RunJournal(path, lambda: 1.0, Wish(smooth=True))

    def keep(advance):
        journal.keep(advance)
        states.append(path.read_bytes())

    whole = track(mono, spec, on_advance=keep)
    journal.close()
    path.write_bytes(states[4])
    begun, wish = read_unfinished(path)
    journal = RunJournal(path, lambda: 1.0, wish)
    again = track(mono, spec, on_advance=journal.keep, begun=begun)
    journal.close()
    assert same_run(whole, again)


def test_frames_without_keypoints_are_not_tracked_and_it_is_found_again(mono):
    keypoints = simulated_keypoints(truth(), mono.cameras, KeypointErrors(noise=0.2))
    keypoints = keypoints[(keypoints.frame < 2) | (keypoints.frame > 3)]
    spec = RunSpec(preset("accurate"), keypoints=keypoints)
    frames, _ = tracked_frames(mono, spec, range(6))
    assert [frame.tracked for frame in frames] == [True, True, False, False, True, True]
    assert frames[2].reason == "there are only 0 keypoints"


def test_what_cannot_be_tracked_is_said(mono):
    keypoints = simulated_keypoints(truth(), mono.cameras)
    with pytest.raises(InputError, match=r"or keypoints of a 2-D detector"):
        track(mono, RunSpec(preset("accurate")))
    with pytest.raises(InputError, match="keypoints of 1 view tell no depth"):
        track(mono, RunSpec(preset("accurate"), keypoints=keypoints, views=("N",)))
    with pytest.raises(InputError, match="needs depth"):
        track(mono, RunSpec(preset("thesis"), keypoints=keypoints))
