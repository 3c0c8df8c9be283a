"""From colour pictures to a cloud with colours, and to a run."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.part_colours import PartColours, colour_features
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.step import PersonModel
from tests.tracking.recordings import VIEWS, rendered_depth, write_depth_recording
from tests.tracking.running import Stepping, tracked_frames
from tests.tracking.scenes import CAMERAS, POSES, angle_errors, clouds_of, surface_points

BODY = body_model(AVERAGE)
TINTS = {"N": (1.0, 1.0, 1.0), "O": (1.15, 0.9, 1.0), "S": (0.9, 1.0, 1.1), "W": (1.0, 1.1, 0.9)}
FRAMES = 3
TINY = {"pixel_step": 1, "speckle_size": 0}
"""For pictures as small as these."""


@pytest.fixture
def coloured(tmp_path):
    """Four depth views of a body in a blue shirt; every camera sees it in its own tint."""
    recording = write_depth_recording(tmp_path, BODY, [POSES["t"]] * FRAMES)
    for name in VIEWS:
        seen = np.isfinite(rendered_depth(BODY, POSES["t"], recording.cameras[name]))
        picture = np.where(seen[..., None], (150.0, 90.0, 60.0), (90.0, 90.0, 90.0)) / TINTS[name]
        for k in range(FRAMES):
            write_png(tmp_path / name / f"{k:04d}.png", picture.astype(np.uint8))
    return recording


def _cloud(recording, *, colour):
    chain = DepthChain(recording, DepthParameters(**TINY), colour=colour)
    with FrameReader(recording, colour=colour) as reader:
        chain.learn_background(reader, range(FRAMES))
        cloud = chain.process(reader.frame_set(1))
    chain.close()
    return cloud


def test_points_get_the_colours_that_their_view_shows(coloured):
    cloud = _cloud(coloured, colour=True)
    trunk = np.linalg.norm(cloud.points - [0.05, -0.1, 1.2], axis=1) < 0.3
    for view, gains in enumerate(TINTS.values()):
        own = np.median(cloud.colours[trunk & (cloud.view == view)], axis=0)
        np.testing.assert_allclose(own * gains, (150, 90, 60), rtol=0.03)


def test_recordings_are_looked_at_for_colours(coloured, tmp_path_factory):
    settings = preset("accurate").replaced(**TINY, fit_shape=False, search_arms=False)
    run = track(coloured, RunSpec(settings, frames=range(FRAMES), init="tpose"))
    assert run.tracked.all()
    (first, *_), _ = tracked_frames(coloured, RunSpec(settings, init="tpose"), range(FRAMES))
    assert first.cloud.colours is not None
    grey = write_depth_recording(tmp_path_factory.mktemp("grey"), BODY, [POSES["t"]] * FRAMES)
    found = {}
    for weight in (0.0, 0.06):
        spec = RunSpec(settings.replaced(colour_weight=weight), init="tpose")
        frames, _ = tracked_frames(grey, spec, range(FRAMES))
        assert frames[0].cloud.colours is None
        found[weight] = np.array([frame.x for frame in frames])
    np.testing.assert_array_equal(found[0.0], found[0.06])


def _clouds(rng, count=3):
    clouds = clouds_of(BODY, POSES["t"], rng, count, noise=0.006)
    return [replace(c, colours=rng.uniform(30.0, 200.0, c.points.shape)) for c in clouds]


def _tracked(clouds, *, coloured=True, **changes):
    setup = Setup(BODY, preset("fast").replaced(**changes).tracking, CAMERAS, 10.0, 0)
    follower = Follower(setup, uses_colours=coloured)
    tracker = Stepping(PersonModel(follower))
    tracker.start(POSES["t"])
    return [tracker.step(cloud) for cloud in clouds], tracker


def test_without_weight_or_colours_nothing_differs_bit_for_bit(rng):
    clouds = _clouds(rng)
    plain, _ = _tracked(clouds, coloured=False)
    unweighted, _ = _tracked(clouds)
    grey = [replace(cloud, colours=None) for cloud in clouds]
    without, _ = _tracked(grey, colour_weight=0.06)
    for a, b, c in zip(plain, unweighted, without, strict=True):
        for other in (b, c):
            np.testing.assert_array_equal(a.x, other.x)
            np.testing.assert_array_equal(a.P, other.P)


def test_colours_are_learned_and_senseless_ones_do_no_harm(rng):
    found, tracker = _tracked(_clouds(rng), colour_weight=0.06)
    assert all(estimate.tracked for estimate in found)
    assert tracker.state.leader.colours.count.sum() > 500
    assert angle_errors(BODY, found[-1].pose, POSES["t"])[[0, 2, 3, 4, 5]].max() < 6.0
    assert found[-1].correspondences.data.shape[1] == 3


def test_learned_colours_fade_by_two_percent_a_frame(rng):
    points, frames = surface_points(BODY, POSES["t"], 2500, rng), BODY.frames(POSES["t"])
    dark, bright = (np.full(points.shape, level) for level in (0.0, 1.0))
    first = PartColours.unknown(BODY).updated(BODY, points, dark, frames)
    second = first.updated(BODY, points, bright, frames)
    taught = first.count > 0
    np.testing.assert_allclose(second.count, 1.98 * first.count)
    np.testing.assert_allclose(second.mean[taught], 1.0 / 1.98)


def _patch(cone, point, turns):
    """Height (0 to 5) and angle (0 to 7) of a cone's patch at a point, and how far it is beside."""
    x, y, z = (point - cone["origin"]) @ cone["rotation"]
    height = int(np.clip(np.floor(6.0 * z / cone["height"]), 0, 5))
    angle = int(np.degrees(np.arctan2(y, x)) % 360.0 / 45.0) if turns else 0
    return height, angle, np.array([np.hypot(x, y), max(-z, z - cone["height"])])


def _placed_with_limbs(pose):
    limb = LIMB_OF_PART[BODY.cones["part"]]
    return placed_cones(BODY, BODY.frames(pose)), limb, np.isin(limb, (0, 1))


def test_a_colour_is_as_foreign_to_a_part_as_its_patches_say(rng):
    (placed, _, turns), shape = _placed_with_limbs(POSES["reaching"]), (len(BODY.cones), 6, 8)
    mean = rng.normal(0.0, 0.15, (*shape, 3))
    square = mean**2 + rng.normal(0.01, 0.02, mean.shape)
    colours = PartColours(rng.uniform(4.0, 12.0, shape), mean, square)
    data = surface_points(BODY, POSES["reaching"], 250, rng, 0.15)
    levels = rng.uniform(-5.0, 255.0, data.shape)
    blue, green, red = np.log(np.maximum(levels, 0.0) + 10.0).T
    features = colour_features(levels)
    expected = np.stack([(blue + green + red) / 3.0, red - green, blue - green], axis=1)
    np.testing.assert_allclose(features, expected)
    features = 0.2 * (features - features.mean(axis=0))
    features[::9, 1] = np.nan
    found = colours.penalty(BODY, data, features, BODY.frames(POSES["reaching"]))
    for i, c in np.ndindex(found.shape):
        height, angle, off = _patch(placed[c], data[i], turns[c])
        variance = np.maximum(square - mean**2, 0.0)[c, height, angle] + [0.04, 0.0036, 0.0036]
        apart = features[i] - mean[c, height, angle]
        asked = (off <= max(placed[c]["r1"], placed[c]["r2"]) + 0.25).all()
        known = asked and colours.count[c, height, angle] >= 8.0 and np.isfinite(features[i, 1])
        sigmas = min(np.sqrt(np.mean(apart**2 / variance)), 3.0)
        assert found[i, c] == pytest.approx(sigmas if known else 1.0)
    assert np.mean((found > 1.0) & (found < 3.0)) > 0.05


def test_patches_learn_the_mean_and_square_of_the_data_that_surely_belong_to_them(rng):
    pose = POSES["pointing"]
    placed, limb, turns = _placed_with_limbs(pose)
    data = surface_points(BODY, pose, 1500, rng, 0.015)
    features = rng.normal(0.0, 1.0, data.shape)
    features[::11, 2] = np.nan
    colours = PartColours.unknown(BODY)
    sums = np.zeros((*colours.count.shape, 7))
    nearest = nearest_on_surface(data, placed, 0.03)
    apart = [nearest_on_surface(data, placed[limb == k], np.inf).distance for k in range(7)]
    for i in range(0, len(data), 2):
        c = nearest.cone[i]
        others = [abs(apart[k][i]) for k in range(7) if k != limb[c]]
        if c >= 0 and np.isfinite(features[i]).all() and min(others) >= 0.07:
            height, angle, _ = _patch(placed[c], data[i], turns[c])
            sums[c, height, angle] += [1.0, *features[i], *features[i] ** 2]
    found = colours.updated(BODY, data, features, BODY.frames(pose))
    np.testing.assert_allclose(found.count, sums[..., 0])
    means = sums[..., 1:] / np.maximum(sums[..., :1], 1.0)
    np.testing.assert_allclose(found.mean, means[..., :3], atol=1e-12)
    np.testing.assert_allclose(found.square, means[..., 3:], atol=1e-12)
    assert sums[..., 0].sum() > 200
