from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

from stereotrack_core.depth.chain import DepthChain, source_of
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.sources import moved_up, row_offset
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import BOX, MemoryReader, depth_recording, frame_set, stereo_recording
from tests.depth.scenes import camera

FRONT_Y = BOX[1, 0]


def chain_with_background(recording, empty=True, sets=(), **values):
    chain = DepthChain(recording, DepthParameters().replaced(**values))
    sets = list(sets) or [frame_set(recording, 0)]
    reader = MemoryReader(recording, sets, empty)
    chain.learn_background(reader, range(len(sets)))
    return chain


def assert_is_the_box(points, shift=0.0, tolerance=0.015):
    assert len(points) > 400
    assert abs(np.median(points[:, 1]) - FRONT_Y) < tolerance
    low, high = np.percentile(points, [2, 98], axis=0)
    for axis in (0, 2):
        offset = shift if axis == 0 else 0.0
        assert abs(low[axis] - offset - BOX[axis, 0]) < 0.06
        assert abs(high[axis] - offset - BOX[axis, 1]) < 0.06


@pytest.mark.parametrize(("matcher", "region"), [("bm", "whole"), ("sgbm", "changed")])
def test_every_view_puts_the_box_where_it_stands(matcher, region):
    recording = stereo_recording()
    chain = chain_with_background(recording, matcher=matcher, match_region=region)
    cloud = chain.process(frame_set(recording, 7, shift=0.1))
    assert cloud.frame == 7
    assert cloud.view_names == ("A", "B")
    assert not cloud.problems
    # Semi-global matching prefers whole disparities: 0.2 px, 28 mm here.
    tolerance = 0.015 if matcher == "bm" else 0.035
    for i in range(2):
        assert_is_the_box(cloud.points[cloud.view == i], shift=0.1, tolerance=tolerance)


def test_each_point_is_its_pixels_range():
    recording = stereo_recording()
    cloud = chain_with_background(recording).process(frame_set(recording, 0))
    for i, name in enumerate(cloud.view_names):
        depth = cloud.depths[name]
        g, own = depth.geometry, cloud.view == i
        u, v = cloud.pixels[own].T
        z = depth.range_z[v, u].astype(float)
        assert depth.foreground[v, u].all()
        rays = np.stack([(u - g.c_x) / g.focal, (v - g.c_y) / g.focal, np.ones(len(u))], axis=1)
        assert np.allclose(g.world_from_depth.apply(rays * z[:, None]), cloud.points[own])
        parallax = depth.disparity[v, u] - g.disparity_offset
        assert np.allclose(g.focal * g.baseline / parallax, z, rtol=1e-5)


def test_matching_only_what_changed_gives_the_same_inside():
    recording = stereo_recording()
    whole, changed = (
        chain_with_background(recording, match_region=r, low_pass=0.3).process(
            frame_set(recording, 0)
        )
        for r in ("whole", "changed")
    )
    for name in whole.view_names:
        a, b = whole.depths[name], changed.depths[name]
        on_box = a.foreground & b.foreground
        assert on_box.sum() > 0.98 * a.foreground.sum()
        off = np.abs(a.disparity[on_box] - b.disparity[on_box])
        # The light around the person is estimated with slightly other pixels.
        assert off.max() < 0.05
        assert (off > 0).mean() < 0.01
        # Elsewhere the empty scene's disparity stands, so that free space is still known.
        known = np.isfinite(b.disparity) & ~b.foreground
        assert known.sum() > 0.5 * (np.isfinite(a.disparity) & ~a.foreground).sum()


def test_nothing_is_matched_where_nothing_has_changed():
    recording = stereo_recording()
    chain = chain_with_background(recording)
    cloud = chain.process(frame_set(recording, 0, box=False))
    assert len(cloud.points) == 0
    assert not cloud.problems
    for name, depth in cloud.depths.items():
        known = np.isfinite(depth.disparity)
        assert np.allclose(depth.disparity[known], chain.background[name].disparity[known])
        assert cloud.counts[name].measured == known.sum() > 0.5 * known.size
        assert depth.extent is None
        assert depth.edges is None


@pytest.mark.parametrize("mode", ["percentile", "average"])
def test_the_background_is_learned_from_passing_boxes(mode):
    recording = stereo_recording()
    places = np.linspace(-0.7, 0.7, 12)
    sets = [frame_set(recording, k, shift=s) for k, s in enumerate(places)]
    chain = chain_with_background(recording, empty=False, sets=sets, background_mode=mode)
    assert set(chain.background) == {"A", "B"}
    cloud = chain.process(sets[6])
    assert abs(np.median(cloud.points[:, 1]) - FRONT_Y) < 0.02
    assert (cloud.points[:, 1] < FRONT_Y + 0.2).mean() > 0.9


def test_the_cloud_does_not_depend_on_the_number_of_threads():
    recording = stereo_recording()
    before = cv2.getNumThreads()
    clouds = []
    try:
        for threads in (1, 2, 3):
            cv2.setNumThreads(threads)
            chain = chain_with_background(recording)
            clouds += [chain.process(frame_set(recording, 0)) for _ in range(2)]
    finally:
        cv2.setNumThreads(before)
    for other in clouds[1:]:
        assert np.array_equal(other.points, clouds[0].points)
        assert np.array_equal(other.pixels, clouds[0].pixels)


def test_a_dark_view_is_named_and_the_others_go_on():
    recording = stereo_recording()
    chain = chain_with_background(recording)
    good = frame_set(recording, 0)
    black = np.zeros((240, 320), dtype=np.uint8)
    views = dict(good.views) | {"B": ViewImages(image=black, left=black)}
    cloud = chain.process(FrameSet(3, views))
    assert cloud.problems == {"B": "View B provides no depth: the left image is dark."}
    assert set(cloud.depths) == {"A"}
    assert_is_the_box(cloud.points)


def test_depth_views_enter_at_the_points():
    recording = depth_recording(mask=True)
    chain = chain_with_background(recording, empty=False)
    cloud = chain.process(frame_set(recording, 0))
    assert cloud.depths["K"].disparity is None
    assert cloud.depths["K"].geometry.baseline == 0
    assert_is_the_box(cloud.points)
    assert np.abs(cloud.points[:, 1] - FRONT_Y).max() < 1e-3


def test_depth_views_without_mask_learn_their_background():
    recording = depth_recording()
    sets = [frame_set(recording, k, shift=s) for k, s in enumerate(np.linspace(-0.9, 0.9, 15))]
    chain = chain_with_background(recording, empty=False, sets=sets, volume_y=6.0)
    assert_is_the_box(chain.process(sets[7]).points, shift=0.0)
    unlearned = DepthChain(recording, DepthParameters().replaced(volume_y=6.0))
    assert (unlearned.process(sets[7]).points[:, 1] > 2.0).any()


def test_unknown_and_single_cameras_are_refused():
    recording = stereo_recording()
    with pytest.raises(InputError, match="unknown view with depth: X"):
        DepthChain(recording, DepthParameters(), views=["X"])
    mono = View("M", "mono", Stream("C", "-"))
    cameras = {"C": camera("C", (0, 0, 1))}
    alone = Recording(recording.folder, "mono", 10.0, (mono,), cameras)
    with pytest.raises(InputError, match="no view provides depth"):
        DepthChain(alone, DepthParameters())
    both = replace(recording, views=(*recording.views, mono), cameras=recording.cameras | cameras)
    with pytest.raises(InputError, match="unknown view with depth: M"):
        DepthChain(both, DepthParameters(), views=["M"])


def test_exchanged_cameras_are_refused_by_name():
    recording = stereo_recording()
    view = recording.views[0]
    swapped = View("A", "stereo", view.left, left=view.image)
    wrong = Recording(recording.folder, "s", 10.0, (swapped,), recording.cameras)
    with pytest.raises(InputError, match=r"view A: .*to the right"):
        DepthChain(wrong, DepthParameters())


RECORDING = stereo_recording()


def lowered(rows, frame=0, *, box=True):
    """A frame set whose left images are too low, those of view B twice as much."""
    seen = frame_set(RECORDING, frame, box=box)
    views = {
        name: replace(one, left=moved_up(one.left, -rows * (1 + (name == "B"))))
        for name, one in seen.views.items()
    }
    return replace(seen, views=views)


def offsets(seen):
    """What is measured on a frame set, by view."""
    sources = {v.name: source_of(RECORDING, v, DepthParameters()) for v in RECORDING.views}
    return [row_offset(partial(sources[name].opened, one)) for name, one in seen.views.items()]


def test_the_offset_of_each_view_is_measured_and_taken_off():
    rows = -0.6
    np.testing.assert_allclose(offsets(lowered(rows)), [rows, 2 * rows], atol=0.11)
    chain = chain_with_background(RECORDING, sets=[lowered(rows, k) for k in range(3)])
    cloud, kept = chain.process(lowered(rows)), chain_with_background(RECORDING, align_rows=False)
    for i in range(2):
        assert_is_the_box(cloud.points[cloud.view == i])
    assert len(cloud.points) > 1.02 * len(kept.process(lowered(rows)).points)


def test_what_is_hardly_off_stays_as_it_is():
    rows = 0.05
    aligned, kept = (
        chain_with_background(RECORDING, sets=[lowered(rows)], align_rows=on).process(lowered(rows))
        for on in (True, False)
    )
    np.testing.assert_array_equal(aligned.points, kept.points)
