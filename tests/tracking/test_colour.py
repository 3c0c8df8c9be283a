"""From colour pictures to a cloud with colours, and to a run."""

from dataclasses import astuple, replace

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
from stereotrack_core.tracking.part_colours import PartColours
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


@pytest.mark.parametrize(("apart", "teaches"), [((0.02, 0.06), False), ((0.08, 0.13), True)])
def test_only_points_well_apart_from_all_other_limbs_teach_a_colour(rng, apart, teaches):
    points, frames = surface_points(BODY, POSES["t"], 2500, rng), BODY.frames(POSES["t"])
    placed, limb = placed_cones(BODY, frames), LIMB_OF_PART[BODY.cones["part"]]
    own, distance = limb[nearest_on_surface(points, placed, 0.01).cone], np.zeros(len(points))
    for one in np.unique(own):
        to_others = nearest_on_surface(points[own == one], placed[limb != one], np.inf)
        distance[own == one] = np.abs(to_others.distance)
    chosen = points[(distance > apart[0]) & (distance < apart[1])]
    assert len(chosen) > 100
    taught = PartColours.unknown(BODY).updated(BODY, chosen, np.zeros(chosen.shape), frames)
    assert taught.count.sum() == (len(chosen[::2]) if teaches else 0)


@pytest.mark.parametrize(("off", "asked"), [(0.0, True), (0.23, True), (0.27, False)])
@pytest.mark.parametrize("way", [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
def test_colours_are_asked_for_within_25_cm_of_a_cone(off, asked, way):
    frames, c = (
        BODY.frames(POSES["t"]),
        int(np.flatnonzero(LIMB_OF_PART[BODY.cones["part"]] == 4)[0]),
    )
    cone = placed_cones(BODY, frames)[c]
    beside = off + max(cone["r1"], cone["r2"])
    point = cone["origin"] + cone["rotation"] @ (beside * np.array(way) + [0.0, 0.0, 1e-6])
    known = PartColours(*(np.full_like(part, 100.0) for part in astuple(PartColours.unknown(BODY))))
    foreign = replace(known, mean=0.0 * known.mean, square=0.0 * known.square)
    penalty = foreign.penalty(BODY, point[None], np.full((1, 3), 99.0), frames)[0, c]
    assert penalty == (3.0 if asked else 1.0)
