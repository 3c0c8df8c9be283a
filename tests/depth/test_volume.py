from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.volume import (
    WorkingSpace,
    check_reach,
    is_changed,
    reach_of,
    settled,
    working_space,
)
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.camera_checks import LikelyUp, up_of_cameras
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import BOX, MemoryReader, depth_recording, frame_set, stereo_recording
from tests.depth.scenes import camera

USUAL = DepthParameters()
AWAY = np.array([12.0, -7.0, 3.0])
ROLL = RigidTransform(np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))


def away(recording):
    """The same recording with the world's origin elsewhere."""
    shift = RigidTransform(np.eye(3), -AWAY)
    cameras = {
        name: replace(one, camera_from_world=one.camera_from_world @ shift)
        for name, one in recording.cameras.items()
    }
    return replace(recording, cameras=cameras)


def passing(recording, empty=False):
    """The box goes from one side to the other."""
    sets = [frame_set(recording, k, shift=s) for k, s in enumerate(np.linspace(-0.6, 0.6, 8))]
    return MemoryReader(recording, sets, empty)


def names(recording):
    return [view.name for view in recording.views]


@pytest.mark.parametrize(
    "recording", [stereo_recording(), depth_recording(), depth_recording(mask=True)]
)
def test_the_volume_is_put_where_somebody_is_seen(recording):
    reader = passing(recording)
    assert settled(recording, USUAL, reader, names(recording)) == USUAL
    found = settled(away(recording), USUAL, reader, names(recording))
    volume = Volume.of(found)
    for shift in (-0.6, 0.6):
        corners = np.array([BOX[:, 0], BOX[:, 1]]) + AWAY + [shift, 0.0, 0.0]
        assert volume.contains(corners).all()
    assert (volume.high - volume.low >= np.array([3.6, 3.6, 2.4]) - 1e-6).all()
    assert (np.abs(volume.corners().mean(axis=0) - AWAY - BOX.mean(axis=1)) < 0.5).all()


def test_the_empty_scene_tells_somebody_who_does_not_move():
    recording = stereo_recording()
    still = MemoryReader(recording, [frame_set(recording, k) for k in range(3)], empty=True)
    volume = Volume.of(settled(away(recording), USUAL, still, names(recording)))
    assert volume.contains(np.array([BOX[:, 0], BOX[:, 1]]) + AWAY).all()
    unknown = MemoryReader(recording, [frame_set(recording, k) for k in range(3)], empty=False)
    volume = Volume.of(settled(away(recording), USUAL, unknown, names(recording)))
    assert volume.contains(np.array([BOX[:, 0], BOX[:, 1]]) + AWAY).all()
    nobody = [frame_set(recording, k, box=False) for k in range(3)]
    alone = MemoryReader(recording, nobody, empty=False)
    assert settled(away(recording), USUAL, alone, names(recording)) == USUAL


def around(baseline):
    """Two stereo cameras that look at each other, 4 m apart."""
    cameras = {}
    for name, turn, y in (("A", 0.0, -2.0), ("B", np.pi, 2.0)):
        for side, x in (("left", -baseline), ("right", 0.0)):
            place = (x if y < 0 else -x, y, 1.2)
            cameras[f"{name}_{side}"] = camera(f"{name}_{side}", place, (0.0, turn, 0.0))
    views = tuple(
        View(v, "stereo", Stream(f"{v}_right", "-"), left=Stream(f"{v}_left", "-")) for v in "AB"
    )
    return Recording(Path(), "around", 10.0, views, cameras)


def test_cameras_around_the_origin_are_not_asked_for_pictures():
    assert settled(around(0.12), USUAL, None, "AB") == USUAL
    found = settled(around(0.4), USUAL, None, "AB")
    assert found.disparity_count >= 400 * 0.4 / 1.1
    assert found == USUAL.replaced(disparity_count=found.disparity_count)
    few = USUAL.replaced(disparity_count=48)
    assert settled(around(0.4), few, None, "AB") == few


def turned(recording, axis):
    """The same recording in a world whose `axis` points up."""
    upright = RigidTransform(Upright(axis).rotation, np.zeros(3))
    cameras = {
        name: replace(one, camera_from_world=one.camera_from_world @ upright)
        for name, one in recording.cameras.items()
    }
    return replace(recording, cameras=cameras)


@pytest.mark.parametrize("axis", [axis for axis in UP_AXES if axis != "-z"])
def test_the_axis_that_is_up_in_the_images_is_up(axis):
    recording = turned(away(depth_recording()), axis)
    found = settled(recording, USUAL, passing(depth_recording()), names(recording))
    assert found.upright.axis == axis
    ends = np.array([BOX[:, 0], BOX[:, 1]]) + AWAY
    assert Volume.of(found).contains(ends @ Upright(axis).rotation).all()
    given = USUAL.replaced(up_axis="z")
    assert settled(recording, given, passing(depth_recording()), names(recording)).up_axis == "z"


def test_a_camera_on_its_side_makes_no_other_world():
    recording = depth_recording()
    one = recording.cameras["K"]
    on_side = replace(one, camera_from_world=ROLL @ one.camera_from_world)
    lying = replace(recording, cameras={"K": on_side})
    assert up_of_cameras(lying).axis != "z"
    assert not up_of_cameras(lying).sure
    tall = BOX + [[0.0, 0.0], [0.0, 0.0], [-0.2, 0.4]]
    points = np.random.default_rng(0).uniform(tall[:, 0], tall[:, 1], (2000, 3))
    assert settled(lying, USUAL, seeing(lying, points), names(lying)).up_axis == "auto"
    view = replace(lying.views[0], display_rotation=90)
    assert up_of_cameras(replace(lying, views=(view,))) == LikelyUp("z", True)


def seeing(recording, points):
    """Three frames of a depth view that sees points of a person before a wall."""
    (view,) = recording.views
    cam = recording.reference_camera(view)
    sets = []
    for k, shift in enumerate((-0.3, 0.0, 0.3)):
        depth = np.full((cam.height, cam.width), 4.0, dtype=np.float32)
        place = cam.camera_from_world.apply(points + [shift, 0.0, 0.0])
        u, v = np.rint(cam.project(points + [shift, 0.0, 0.0])).astype(int).T
        inside = (u >= 1) & (u < cam.width - 1) & (v >= 1) & (v < cam.height - 1)
        for du in (-1, 0, 1):
            for dv in (-1, 0, 1):
                depth[v[inside] + dv, u[inside] + du] = place[inside, 2]
        image = np.full(depth.shape, 100, dtype=np.uint8)
        sets.append(FrameSet(k, {view.name: ViewImages(image=image, depth=depth)}))
    return MemoryReader(recording, sets, empty=False)


def test_the_volume_reaches_beyond_what_was_seen_by_the_same_margin_on_both_sides():
    recording = depth_recording()
    points = np.random.default_rng(0).uniform([-0.2, 1.4, 0.1], [0.2, 1.5, 1.9], (4000, 3))
    volume = Volume.of(settled(away(recording), USUAL, seeing(recording, points), names(recording)))
    ends = np.array([volume.low[2], volume.high[2]]) - AWAY[2]
    np.testing.assert_allclose(ends, [0.1 - 0.6, 1.9 + 0.6], atol=0.08)


def test_the_working_space_is_told():
    recording = away(stereo_recording())
    told = working_space(recording, USUAL, passing(stereo_recording()), names(recording))
    assert told.up_axis == "z"
    assert np.all(np.array(told.low_m) < AWAY)
    assert "person" in told.volume_from
    for name in "AB":
        low, high = told.disparities_px[name]
        assert low == 1
        assert told.searched_m[name][0] == pytest.approx(400 * 0.12 / high, rel=0.02)


def test_a_view_needs_the_ranges_at_which_it_shows_the_volume():
    recording = stereo_recording()
    told = working_space(recording, USUAL, passing(recording), names(recording))
    points = np.random.default_rng(0).uniform(told.low_m, told.high_m, (200_000, 3))
    for view in recording.views:
        cam = recording.reference_camera(view)
        shown = cam.camera_from_world.apply(points)
        u, v = (cam.matrix @ shown.T)[:2] / shown[:, 2]
        seen = (shown[:, 2] > 0.3) & (u >= 0) & (u < cam.width) & (v >= 0) & (v < cam.height)
        far = np.percentile(shown[seen, 2], 95)
        assert told.needed_m[view.name][1] == pytest.approx(far, abs=0.15)


SCALE = 400 * 0.12
"""Focal length times base line: pixels of disparity at 1 m."""


def space(low, high, near=1.0, far=3.0):
    """What is searched from one disparity to another, and the ranges at which the person is."""
    reached = SCALE / high, SCALE / low if low else float("inf")
    corner = (0.0, 0.0, 0.0)
    return WorkingSpace(
        "z", corner, corner, "", {"N": (low, high)}, {"N": reached}, {"N": (near, far)}
    )


@pytest.mark.parametrize(("low", "high"), [(0, 64), (1, 48), (15, 47), (16, 47)])
def test_what_reaches_the_person_is_not_told(low, high):
    assert not list(check_reach(space(low, high)))


def test_too_few_disparities_begin_too_far_away():
    [found] = check_reach(space(1, 32))
    assert (found.severity, found.where) == ("warning", "view N, disparities")
    assert "of 1 to 32 px show what is 1.50 to 48.00 m, but" in found.what
    assert "from 1.00 to 3.00 m" in found.what
    assert "Set disparity_count to 48 or more." in found.remedy
    assert not list(check_reach(space(1, 48)))
    for high, misses in ((24, False), (23, True)):  # 2 m, or 9 cm more
        assert bool(list(check_reach(space(1, high, near=2.0)))) is misses


@pytest.mark.parametrize(("low", "high"), [(1, 15), (60, 123)])
def test_where_nothing_is_reached_it_is_an_error(low, high):
    assert [one.severity for one in check_reach(space(low, high))] == ["error"]


def test_what_is_searched_of_a_recording():
    recording = stereo_recording()
    few = USUAL.replaced(disparity_count=16)
    found = reach_of(recording, few, passing(recording), names(recording))
    assert found
    assert "Set disparity_count to 32 or more." in found[0].remedy
    assert is_changed(few)
    assert not is_changed(USUAL.replaced(volume_x=3.0))
