"""Which way somebody faces: what frames say of it, and a run that has begun the wrong way round."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.tracked_run import TrackPlan, track_recording
from stereotrack_core.interop.first_pose import first_pose, with_heading
from stereotrack_core.interop.run_journal import read_unfinished
from stereotrack_core.tracking import tracking
from stereotrack_core.tracking.frame import FirstFrame
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.heading import DECIDED, WATCHED, HeadingWatch
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import heading_words
from stereotrack_core.tracking.run_spec import RunSpec, given_heading, is_found
from stereotrack_core.tracking.state import Setup
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, pose_with_arms, turned

BENT = pose_with_arms([0.4, 0.2, -1], [0.1, 1, 0.1], [-0.4, 0.1, -1], [-0.1, 1, 0])


@pytest.fixture(scope="module")
def finder():
    body = body_model(AVERAGE, preset("accurate").body)
    return PoseFinder(Setup(body, preset("accurate").tracking, CAMERAS, 10.0, 0))


def _watched(finder, poses, fps=10.0, last=None):
    watch = HeadingWatch(fps, first=FirstFrame(0, poses[0]))
    for k, pose in enumerate(poses):
        watch = watch.updated(finder, pose, cloud_of(np.zeros((0, 3)), k), is_last=k == last)
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


@pytest.mark.parametrize(("frames", "against"), [(12, None), (30, 29)])
def test_a_doubtful_heading_gives_way_at_the_end_if_enough_was_seen(finder, frames, against):
    backward = np.minimum(np.arange(frames), 3)[:, None] * np.array([0.0, -0.12, 0.0])
    watch = _watched(finder, [turned(POSES["t"], 0.0, at) for at in backward], last=frames - 1)
    assert 1.0 - DECIDED < watch.probability < 0.4
    assert watch.against == against


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


def _begun_the_wrong_way(folder, monkeypatch, count=15):
    """Recording of somebody who faces south and is taken to face north, and how it is tracked."""
    settings = SMALL.replaced(fit_shape=False, second_look=0)
    body = body_model(AVERAGE, settings.body)
    poses = [turned(POSES["t"], 180.0)] * 2 + [turned(BENT, 180.0)] * (count - 2)
    wrong = turned_round(poses[0])
    monkeypatch.setattr(tracking, "first_pose_in", lambda *_: wrong)
    recording = write_depth_recording(folder, body, poses)
    return recording, RunSpec(settings, frames=range(len(poses)))


def test_a_run_that_began_the_wrong_way_round_is_corrected(tmp_path, monkeypatch):
    recording, spec = _begun_the_wrong_way(tmp_path / "south", monkeypatch)
    count, seen = len(spec.frames), []
    part = tmp_path / "run.npz.part"
    plan = TrackPlan(recording, spec)
    job = track_recording(plan, part=part, on_step=lambda done, _: seen.append(done))
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
