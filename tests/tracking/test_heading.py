"""Which way somebody faces: what frames say of it, and a run that has begun the wrong way round."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import SHANKS
from stereotrack_core.depth.cloud import DepthGeometry, ViewDepth
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.tracked_run import track_recording
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.upright import Z_UP
from stereotrack_core.interop.first_pose import first_pose, with_heading
from stereotrack_core.interop.run_journal import read_unfinished
from stereotrack_core.tracking import pipeline
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.first_pose import facing
from stereotrack_core.tracking.initialise.heading import (
    toes_in_outlines,
)
from stereotrack_core.tracking.initialise.heading_watch import WATCHED, HeadingWatch
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import heading_words
from stereotrack_core.tracking.run_spec import RunSpec, given_heading, is_found
from stereotrack_core.tracking.state import Setup
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, pose_with_arms, turned

BENT = pose_with_arms([0.4, 0.2, -1], [0.1, 1, 0.1], [-0.4, 0.1, -1], [-0.1, 1, 0])


@pytest.fixture(scope="module")
def finder():
    body = body_model(AVERAGE, preset("accurate").body)
    return PoseFinder(Setup(body, preset("accurate").tracking, CAMERAS, 10.0, 0))


def _from_the_east(body, pose, toes):
    """What a view in the east sees of legs, and of feet that reach to `toes` from the ankles."""
    R = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])  # camera_from_world
    camera = RigidTransform(R, -R @ np.array([3.0, 0.0, 1.0])).inverse()
    geometry = DepthGeometry(400.0, 320.0, 240.0, 0.0, 0.0, 640, 480, camera)
    v, u = np.mgrid[:480, :640]
    outline = np.zeros((480, 640), dtype=bool)
    frames = body.frames(pose)
    for shank in SHANKS:
        ankle = frames.origins[shank] + body.skeleton.lengths[shank] * frames.rotations[shank][:, 2]
        x, y, z = geometry.world_from_depth.inverse().apply(ankle[None])[0]
        across = (u - 320.0) / 400.0 * z - x  # to the north
        down = (v - 240.0) / 400.0 * z - y
        outline |= (np.abs(across) < 0.05) & (down > -0.4) & (down < 0.08)
        low, high = sorted((-0.05 * np.sign(toes), toes))
        outline |= (across > low) & (across < high) & (down > 0.0) & (down < 0.08)
    nowhere = np.full(outline.shape, np.nan, dtype=np.float32)
    return ViewDepth(geometry, None, nowhere, ~np.isnan(nowhere), None, outline)


@pytest.mark.parametrize(("toes", "expected"), [(0.18, 1.0), (-0.18, -1.0), (0.04, 0.0)])
def test_toes_show_where_the_front_is(finder, toes, expected):
    body, pose = finder.setup.body, POSES["t"]
    cloud = replace(cloud_of(np.zeros((0, 3))), depths={"E": _from_the_east(body, pose, toes)})
    for each, sign in ((pose, 1.0), (turned_round(pose), -1.0)):
        found = toes_in_outlines(body, body.frames(each), cloud, Z_UP)
        assert found == pytest.approx(sign * expected)


def _watched(finder, poses, fps=10.0, last=None):
    watch = HeadingWatch(fps)
    watch.first = 0, poses[0]
    for k, pose in enumerate(poses):
        watch.take(finder, pose, cloud_of(np.zeros((0, 3)), k), last=k == last)
    return watch


def test_nothing_seen_leaves_the_heading_undecided(finder):
    watch = _watched(finder, [POSES["t"]] * (WATCHED + 5))
    assert watch.state == "undecided"
    assert not watch.active
    assert watch.probability == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_walking_tells_the_front(finder, way):
    step = np.array([0.0, 0.12 * way, 0.0])
    watch = _watched(finder, [turned(POSES["t"], 0.0, k * step) for k in range(30)])
    assert watch.state == ("decided" if way > 0 else "undecided")
    assert (watch.against is None) == (way > 0)
    sideways = [turned(POSES["t"], 0.0, (0.12 * k, 0.0, 0.0)) for k in range(30)]
    assert _watched(finder, sideways).state == "undecided"


def test_a_tracker_that_turns_the_body_round_says_that_it_began_the_wrong_way(finder):
    wrong = turned_round(BENT)
    watch = _watched(finder, [wrong] * 4 + [BENT] * 30)
    assert watch.against is not None
    frame, pose = watch.correct()
    assert (frame, watch.state) == (0, "corrected")
    np.testing.assert_allclose(pose.torso, BENT.torso)
    assert watch.probability > 0.98


def test_it_is_said_where_a_heading_may_be_wrong():
    told = {p: heading_words({"state": "undecided", "probability": p}) for p in (0.3, 0.9, 0.97)}
    assert told[0.3].undecided
    assert "90 %" in told[0.9].what
    assert told[0.97] is None
    settled = {"state": "undecided", "probability": 0.97, "against": 59}
    assert heading_words(settled).brief == "corrected at frame 59"
    assert heading_words({"state": "undecided", "probability": 0.5, "frames": 10}) is None
    assert heading_words({"state": "decided", "probability": 0.999}) is None
    assert heading_words(None) is None


def test_a_given_heading_chooses_between_both_ways():
    south = turned(POSES["reaching"], 180.0)
    assert facing(south, None, Z_UP) is south
    assert facing(south, 170.0, Z_UP) is south
    other = facing(south, 20.0, Z_UP)
    assert other.torso[1, 1] == pytest.approx(1.0)


def _begun_the_wrong_way(folder, monkeypatch, count=15):
    """Recording of somebody who faces south and is taken to face north, and how it is tracked."""
    settings = preset("fast").replaced(
        pixel_step=1, speckle_size=0, search_arms=False, data_points=400, fit_shape=False
    )
    body = body_model(AVERAGE, settings.body)
    poses = [turned(POSES["t"], 180.0)] * 2 + [turned(BENT, 180.0)] * (count - 2)
    wrong = turned_round(poses[0])
    monkeypatch.setattr(pipeline, "first_pose_in", lambda *_: wrong)
    recording = write_depth_recording(folder, body, poses)
    return recording, RunSpec(settings, frames=range(len(poses)))


def test_a_run_that_began_the_wrong_way_round_is_corrected(tmp_path, monkeypatch):
    recording, spec = _begun_the_wrong_way(tmp_path / "south", monkeypatch)
    count, seen = len(spec.frames), []
    part = tmp_path / "run.npz.part"
    job = track_recording(recording, spec, part=part, on_step=lambda done, _: seen.append(done))
    heading, run = job.run.meta["heading"], job.run
    assert heading["state"] == "corrected"
    assert 2 <= heading["against"] < count
    assert seen == [*range(1, heading["against"] + 2), *range(1, count + 1)]
    assert run.frame.tolist() == list(range(count))
    assert (run.landmarks[:, 1, 0] < run.landmarks[:, 0, 0]).all()  # right is in the west
    kept, _wish = read_unfinished(part)
    np.testing.assert_array_equal(kept.run().landmarks, run.landmarks)
    assert kept.checkpoint is not None
    assert heading_words(heading).brief == f"corrected at frame {heading['against']}"


@pytest.mark.parametrize(
    ("heading", "init"),
    [("south", "auto 180"), ("East", "auto 90"), ("-90", "auto 270"), (None, "auto")],
)
def test_a_heading_is_named_by_direction_or_in_degrees(heading, init):
    found = with_heading("auto", heading)
    assert found == init
    assert is_found(found)
    assert given_heading(found) == (None if heading is None else float(init.split()[1]))
    assert first_pose(init, 0) == init


@pytest.mark.parametrize(("init", "heading"), [("tpose", "south"), ("auto", "up"), ("auto", "400")])
def test_a_heading_that_cannot_be_is_refused(init, heading):
    with pytest.raises(InputError, match="--heading"):
        with_heading(init, heading)
