"""What the parameters of the depth chain change about backgrounds, volumes and clouds."""

import functools

import numpy as np
import pytest

from stereotrack_core.depth.background import ViewBackground
from stereotrack_core.depth.chain import DepthChain, MeasuredViews, source_of
from stereotrack_core.depth.coarse import matcher_of
from stereotrack_core.depth.match import STEPS, DisparityRange, Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.sources import disparity_range
from stereotrack_core.depth.view_chain import ViewResult
from stereotrack_core.depth.volume import settled
from tests.depth.recordings import MemoryReader, depth_recording, frame_set, stereo_recording
from tests.depth.scenes import pair_with_disparity
from tests.depth.test_volume import AWAY, away, passing
from tests.effects import check

USUAL, WHOLE = DepthParameters(), Region.whole(320, 240)
RECORDINGS = {"stereo": stereo_recording(), "depth": depth_recording(mask=True)}
STEREO, DEPTH = RECORDINGS.values()


def source(**changes):
    return source_of(STEREO, STEREO.views[0], USUAL.replaced(**changes))


def background(*shown, **changes):
    """Background of a view that has learned from images that show one disparity each."""
    scene = ViewBackground(source(), USUAL.replaced(**changes))
    for disparity in shown:
        scene.learn(np.full((240, 320), disparity, np.float32), WHOLE)
    return scene


def limit(**changes):
    """Largest excess over the background that is no foreground yet, pixels."""
    excess = np.linspace(0.0, 5.0, 320, dtype=np.float32)
    front = background(10.0, **changes).foreground(np.tile(10.0 + excess, (240, 1)), WHOLE)
    return excess[~front[100]].max()


def percentile(**changes):
    frames = np.ones((21, 240, 320), np.float32)
    frames[:, 5, 5] += np.arange(21)
    scene = background(**changes)
    scene.take_frames([(frame, None) for frame in frames])
    return scene.model.disparity[5, 5]


def left_of(points, **changes):
    """How many of a view's points are left."""
    view = ViewResult(None, "", points, np.zeros((len(points), 2), np.int64), {})
    seen = MeasuredViews(0, {"K": view}, {}, {})
    p = USUAL.replaced(**{"outlier_neighbours": 2} | changes)
    return len(DepthChain(DEPTH, p).fused(seen).points)


LINE = np.arange(20)[:, None] * [0.05, 0.0, 0.0]
GROUPS = np.concatenate([k + np.arange(k)[:, None] * [0.001, 0.0, 0.0] for k in (3, 6, 12)])
IMAGES = frame_set(STEREO, 0).views["A"]
AREA = int(frame_set(DEPTH, 0).views["K"].mask.sum())


@functools.cache
def cloud(kind, **changes):
    """Points of the box, 0.5 m wide and from 0.5 to 1.4 m high."""
    recording, chain = RECORDINGS[kind], DepthChain(RECORDINGS[kind], USUAL.replaced(**changes))
    sets = [frame_set(recording, 0)]
    chain.learn_background(MemoryReader(recording, sets, kind == "stereo"), range(1))
    return chain.process(sets[0]).points


def searched(**changes):
    small = USUAL.replaced(volume_x=0.4, volume_y=1.6)
    return disparity_range(source().geometry, small.replaced(**changes))


TRUTH = np.full((96, 640), 20.0)
TRUTH[40:56, 300:316] = 150.0  # something small before a wall
SMALL, WALL = np.s_[44:52, 304:312], np.s_[20:76, 40:250]
PAIR = pair_with_disparity(TRUTH)
STRIPES = 127 + 60 * np.sin(2 * np.pi * np.arange(640) / 8)
STRIPED = [(STRIPES + 0.1 * (one - 127.0)).astype(np.uint8) for one in PAIR]


def matched(pair, most=32, where=WALL, **changes):
    """Disparities, NaN where there are none."""
    matcher = matcher_of(USUAL.replaced(match_left_right=-1, **changes), DisparityRange(1, most))
    steps = matcher(*pair)[where]
    return np.where(steps > matcher.disparities.invalid, steps / STEPS, np.nan)


def right(where, disparity, **changes):
    return np.mean(np.abs(matched(PAIR, 256, where, **changes) - disparity) < 1.0)


WIDE, HOW = ("full", "coarse_to_fine"), ("matcher", "aligned")
EFFECTS = [
    ("match_wide", *WIDE, lambda **p: right(WALL, 20.0, **p), "ratio", 1, 0.05),
    ("match_wide", *WIDE, lambda **p: right(SMALL, 150.0, **p), "ratio", 0, 0.1),
    ("match_uniqueness", 0, 40,
     lambda **p: np.isfinite(matched(STRIPED, **p)).mean(), "ratio", 0.0, 0.5),
    ("match_window", 7, 15,  # the first row that is known
     lambda **p: np.isfinite(matched(PAIR, where=np.s_[:, 200], **p)).argmax(), "slope", 0.5, 0.0),
    ("low_pass", 0.5, 2.0, lambda **p: source(**p).open(IMAGES).picture.std(), "ratio", 0.4, 0.3),
    ("disparity_minimum", 1, 9, lambda **p: searched(**p).minimum, "slope", 1, 0),
    ("disparity_count", 17, 33, lambda **p: searched(**p).count, "difference", 16, 0),
    ("disparity_from_volume", False, True,
     lambda **p: searched(disparity_count=128, **p).count, "difference", -96, 32),
    ("subpixel", *HOW, lambda **p: cloud("stereo", **p)[:, 1].std(), "ratio", 0.5, 0.4),
    ("speckle_size", AREA - 300, AREA, lambda **p: len(cloud("depth", **p)), "ratio", 0, 0),
    ("background_threshold", 1.0, 3.0, limit, "slope", 1.0, 0.02),
    ("background_rate", 0.05, 0.25,
     lambda **p: background(10.0, 20.0, **p).model.disparity[9, 9], "slope", 10.0, 0.01),
    ("background_validity_rate", 0.05, 0.25,
     lambda **p: background(10.0, np.nan, **p).model.frequency[9, 9], "slope", -1.0, 0.01),
    ("background_percentile", 5.0, 50.0, percentile, "slope", 0.2, 0.001),
    ("halo_trim", "none", "silhouette", lambda **p: len(cloud("stereo", **p)), "ratio", 0.9, 0.08),
    ("halo_trim", "none", "picture", lambda **p: len(cloud("stereo", **p)), "ratio", 0.9, 0.08),
    ("volume_from_recording", False, True, lambda **p: settled(
        away(DEPTH), USUAL.replaced(**p), passing(DEPTH), ["K"]).volume_centre_x,
     "difference", AWAY[0], 0.5),
    ("volume_bottom", 0.6, 0.9, lambda **p: cloud("depth", **p)[:, 2].min(), "slope", 1.0, 0.07),
    ("volume_z", 0.8, 1.2, lambda **p: cloud("depth", **p)[:, 2].max(), "slope", 1.0, 0.07),
    ("volume_x", 0.1, 0.4, lambda **p: cloud("depth", **p)[:, 0].max(), "slope", 0.5, 0.1),
    ("volume_centre_x", -1.9, -1.6, lambda **p: cloud("depth", **p)[:, 0].max(), "slope", 1, 0.1),
    ("volume_centre_y", 0, 1, lambda **p: Volume.of(USUAL.replaced(**p)).low[1], "slope", 1, 1e-6),
    ("volume_y", 3.0, 4.0, lambda **p: Volume.of(USUAL.replaced(**p)).low[1], "slope", -0.5, 1e-6),
    ("pixel_step", 2, 4, lambda **p: len(cloud("depth", **p)), "ratio", 0.25, 0.02),
    ("outlier_neighbours", 2, 3, lambda **p: left_of(GROUPS, **p), "difference", -3, 0),
    ("outlier_distance", 49.0, 51.0, lambda **p: left_of(LINE, **p), "difference", 18, 0),
    ("outlier_repeat", False, True, lambda **p: left_of(LINE, **p), "difference", -18, 0),
]  # fmt: skip


@pytest.mark.parametrize("row", EFFECTS, ids=lambda row: row[0])
def test_a_parameter_changes_the_cloud_as_it_says(row):
    check(*row)
