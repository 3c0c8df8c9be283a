"""Limbs that lie elsewhere than what was seen are called lost, and the others are not."""

import functools

import numpy as np
import pytest

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, LIMB_OF_PART, UPPER_ARMS
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    arm_of_pose,
    arm_shape,
    with_arm,
)
from stereotrack_core.tracking.arm_search.picture import outline_cones, seen_pictures
from stereotrack_core.tracking.arm_search.score import anatomy_cost
from stereotrack_core.tracking.estimate import Prior
from stereotrack_core.tracking.failure.alternatives import elsewhere
from stereotrack_core.tracking.failure.features import (
    FEATURES,
    carried_on,
    disagreement,
    failure_probability,
    limb_features,
    unexpected,
    with_neighbours,
)
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from tests.tracking.keypoints.test_reprojection import seen as keypoints_seen
from tests.tracking.scenes import POSES, pose_with_arms
from tests.tracking.views import cloud_of_body

BODY = body_model(AVERAGE)
ARMS = [*UPPER_ARMS, *FOREARMS]
DOWN = np.array([0.0, 0.0, -1.0])
NOTHING = np.zeros((len(LIMBS), 2))


@functools.cache
def cloud_of(name):
    return cloud_of_body(BODY, POSES[name])


def signs_of(pose, true, seen=NOTHING):
    """Signs (6,) of each limb by their names, and their probabilities."""
    signs = limb_features(cloud_of(true), BODY, pose, np.ones(6), seen)
    assert signs is not None
    assert np.isfinite(signs).all()
    return dict(zip(FEATURES, signs.T, strict=True)), failure_probability(signs, "several")


@pytest.mark.parametrize("name", POSES)
def test_arms_where_they_were_seen_are_not_lost(name):
    signs, lost = signs_of(POSES[name], name)
    assert (lost[ARMS] < 0.2).all()
    assert (signs["through"][ARMS] < 0.05).all()
    assert (signs["behind"][ARMS] < 0.1).all()
    assert (signs["better"][ARMS] < 0.0).all()


@pytest.mark.parametrize("name", POSES)
@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_an_arm_beside_what_was_seen_is_lost(name, side):
    true = POSES[name]
    out = np.array([-1.0 if side == LEFT else 1.0, 0.0, 0.0])
    along = DOWN + 0.15 * out if name == "t" else DOWN - 0.6 * np.array([0, 1, 0]) + 0.4 * out
    along /= np.linalg.norm(along)
    signs, lost = signs_of(with_arm(true, side, along, along), name)
    wrong = [UPPER_ARMS[side], FOREARMS[side]]
    other = [UPPER_ARMS[1 - side], FOREARMS[1 - side]]
    assert (lost[wrong] > 0.1).all()
    assert (lost[other] < 0.1 * lost[wrong].min()).all()
    contradicted = np.tile([0.5, 0.5], (6, 1))
    _, lost = signs_of(with_arm(true, side, along, along), name, contradicted)
    assert (lost[wrong] > 0.8).all()
    assert (signs["through"] + signs["behind"])[wrong].min() > 0.4
    assert (signs["better"][wrong] > 0.0).any()
    unexplained = signs["unexplained"][list(FOREARMS)]
    assert unexplained[side] > 2.0 * unexplained[1 - side]


@pytest.mark.parametrize(
    ("upper", "fore", "buried"),
    [
        pytest.param((0.2, 0.1, -1), (-1, 0, 0), 1.0, id="through the trunk"),
        pytest.param((0.3, 0.8, -0.5), (-1, -0.7, -0.3), 0.6, id="the hand alone"),
        pytest.param((0.3, 0.8, -0.5), (-1, -0.2, -0.6), 0.0, id="before it"),
    ],
)
def test_a_forearm_is_buried_by_the_decimetres_that_it_lies_in_the_trunk(upper, fore, buried):
    pose = pose_with_arms(upper, fore, (-1, 0, 0), (-1, 0, 0))
    signs, _ = signs_of(pose, "t")
    np.testing.assert_allclose(signs["buried"][list(FOREARMS)], [0.0, buried], atol=0.15)


@pytest.mark.parametrize("views", ["one", "two", "several"])
def test_keypoints_that_agree_make_surer_and_those_that_do_not_doubtful(views):
    pose, doubtful = POSES["t"], with_arm(POSES["t"], LEFT, DOWN, DOWN)
    cloud = cloud_of("t")
    for here, limbs in ((pose, ARMS), (doubtful, [UPPER_ARMS[LEFT], FOREARMS[LEFT]])):
        said = {}
        for name, off in (("agree", 0.1), ("contradict", 1.2)):
            seen = np.tile([off * 0.5, 0.5], (6, 1))
            signs = limb_features(cloud, BODY, here, np.ones(6), seen)
            said[name] = failure_probability(signs, views)[limbs]
        assert (said["agree"] < said["contradict"]).all()


def over_limbs(pose, areas):
    """Square metres (V, 6), mean of the views, over those of the limbs seen from the side."""
    cones = BODY.cones
    sides = (cones["r1"] + cones["r2"]) * cones["height"]
    own = [sides[LIMB_OF_PART[cones["part"]] == limb].sum() for limb in range(6)]
    return np.mean(areas, axis=0) / own


WRONG = with_arm(POSES["t"], LEFT, DOWN, DOWN)


def test_looks_of_limbs_are_counted_pixel_by_pixel():
    signs, _ = signs_of(WRONG, "t")
    counted = np.zeros((4, 6, 3))
    for v, seen in enumerate(seen_pictures(cloud_of("t"), 3)):
        model, owner = seen.drawn(outline_cones(BODY, BODY.frames(WRONG)))
        e2 = np.maximum(seen.scale * (model - seen.measured), 0.0) ** 2
        behind = e2 / (e2 + 0.8**2) * (seen.measured > 0.0) * seen.person
        for limb in range(6):
            on = (owner >= 0) & (LIMB_OF_PART[owner] == limb)
            looks = (1 - seen.person[on]).sum(), behind[on].sum(), on.sum()
            counted[v, limb] = np.array(looks) * seen.area(WRONG.position)
    share = counted.sum(axis=0) / counted.sum(axis=0)[:, 2:]
    np.testing.assert_allclose(signs["through"], share[:, 0])
    np.testing.assert_allclose(signs["behind"], share[:, 1], atol=1e-4)
    visible = over_limbs(WRONG, counted[..., 2])
    np.testing.assert_allclose(signs["visible"], np.log(visible + 0.05))
    np.testing.assert_allclose(signs["jump"], np.log(2.0))


def test_what_is_not_explained_is_counted_in_the_reach_of_each_limb():
    signs, _ = signs_of(WRONG, "t")
    frames, reach, counted = BODY.frames(WRONG), 1.2 * BODY.skeleton.lengths[:6], []
    reach[list(UPPER_ARMS)] += BODY.skeleton.lengths[list(FOREARMS)]
    for seen in seen_pictures(cloud_of("t"), 3):
        model, _ = seen.drawn(outline_cones(BODY, frames))
        explained = (model > 0.0) & (seen.scale * (seen.measured - model) <= 2.0)
        free = (seen.person == 1) & ~explained
        pixels = np.argwhere(free)[:, ::-1] * seen.step + [seen.left, seen.top]
        rays = np.c_[(pixels - seen.pinhole[1:]) / seen.pinhole[0], np.ones(len(pixels))]
        place = rays / seen.measured[free][:, None]  # known everywhere in a cast picture
        joints = frames.origins[:6] @ seen.camera_from_world[:, :3].T + seen.camera_from_world[:, 3]
        near = np.linalg.norm(place[:, None] - joints, axis=2) < reach
        counted.append(near.sum(axis=0) * seen.area(WRONG.position))
    unexplained = over_limbs(WRONG, counted)
    assert unexplained[4] > 0.1
    np.testing.assert_allclose(signs["unexplained"] ** 2, unexplained, atol=0.01)


def test_features_of_many_frames_stand_beside_those_of_each_limb_s_neighbour(rng):
    many = rng.normal(size=(3, 6, 9))
    for one, found in zip(many, with_neighbours(many), strict=True):
        np.testing.assert_array_equal(found, np.hstack([one, one[[0, 0, 4, 5, 2, 3]]]))


def _turned_from(direction):
    """The vectors 60 and 110 degrees off a unit vector, four each, from one side of it round."""
    aside = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    aside /= np.linalg.norm(aside)
    for off, first in ((60.0, 0.0), (110.0, 45.0)):
        for turn in np.radians(first + 90.0 * np.arange(4)):
            out = np.cos(turn) * aside + np.sin(turn) * np.cross(direction, aside)
            yield np.cos(np.radians(off)) * direction + np.sin(np.radians(off)) * out


@pytest.mark.parametrize("pose", [WRONG, POSES["reaching"]])
def test_an_arm_is_better_elsewhere_by_the_area_that_disagrees_less_there(pose):
    cloud, frames, expected = cloud_of("t"), BODY.frames(pose), np.zeros(6)
    own = np.array([1.0, 1.0, 0.11, 0.12, 0.13, 0.14])

    def unlike(placed):
        """Square metres that disagree, mean of the views."""
        areas = [
            seen.area(pose.position) * seen.unlike(placed, placed[None, :0], placed[None, :0], 0.8)
            for seen in seen_pictures(cloud, 5)
        ]
        return np.mean(areas)

    here = outline_cones(BODY, frames)
    for side in (LEFT, RIGHT):
        arm, shape = arm_of_pose(frames, side), arm_shape(BODY, side)
        upper, fore = arm.upper[0], arm.fore[0]
        most = anatomy_cost(BODY, shape, arm)[0] + 4.0
        whole = [(u, _carried(upper, u, fore)) for u in _turned_from(upper)]
        below = [(upper, f) for f in _turned_from(fore)]
        both = own[[2 + side, 4 + side]]
        for limb, area, tried in ((2 + side, both.sum(), whole), (4 + side, both[1], below)):
            gains = [
                unlike(here) - unlike(outline_cones(BODY, BODY.frames(with_arm(pose, side, u, f))))
                for u, f in tried
                if anatomy_cost(BODY, shape, Arms(u[None], f[None]))[0] < most
            ]
            expected[limb] = max(gains, default=0.0) / area
    np.testing.assert_allclose(elsewhere(cloud, BODY, pose, own), expected, atol=1e-5)
    assert expected[:2].tolist() == [0.0, 0.0]


def _carried(one, other, vector):
    """A vector turned by the smallest rotation that turns one unit vector to another."""
    axis = np.cross(one, other)
    angle = np.arctan2(np.linalg.norm(axis), one @ other)
    return rotation_from_vector(axis / np.linalg.norm(axis) * angle) @ vector


@pytest.mark.parametrize("name", POSES)
def test_arms_are_buried_by_the_mean_depth_of_places_along_them(name):
    fore = POSES[name].rotations[4, :, 2]
    pose = pose_with_arms((0.2, 0.1, -1), (-1, 0.02, 0.1), (-0.1, 0.0, -1), fore)
    frames = BODY.frames(pose)
    torso = placed_cones(BODY, frames)[np.isin(BODY.cones["part"], (0, 10, 11))]
    buried = np.zeros(6)
    for limb in range(2, 6):
        along = np.array([0.5, 0.75, 1.0])[:, None] * BODY.skeleton.lengths[limb]
        places = frames.origins[limb] + along * frames.rotations[limb, :, 2]
        off = nearest_on_surface(places, torso, np.inf).distance
        depth = np.where(np.isinf(off), 0.0, -off)
        buried[limb] = 10.0 * np.clip(depth, 0.0, 0.2).mean()
    assert buried.max() > 0.3
    np.testing.assert_allclose(signs_of(pose, "t")[0]["buried"], buried)


def test_limbs_move_unexpectedly_by_the_expected_deviation(rng):
    joints, movement = (2, 3, 4, 5, 1, 8), rng.normal(size=18)
    P = np.diag(rng.uniform(0.5, 2.0, 18))
    ratio = movement**2 / np.diagonal(P)
    means = [ratio[3:6], ratio[14:16], *ratio[6:14].reshape(4, 2)]
    found = unexpected(movement, Prior(P, np.ones(18, dtype=bool)), joints)
    np.testing.assert_allclose(found, np.sqrt([one.mean() for one in means]))
    assert not unexpected(movement, None, joints).any()


def test_keypoints_disagree_by_their_arrows_over_the_limb_s_length(rng):
    off = {(v, f"left_{n}"): rng.normal(0.0, 12.0, 2) for v in "NOS" for n in ("elbow", "wrist")}
    shown, pose = keypoints_seen(POSES["t"], off), POSES["pointing"]
    fit, expected = KeypointObservation(shown, 1.0).fitted(BODY, pose), np.zeros((6, 2))
    for limb, begin, end in ((2, "shoulder", "elbow"), (4, "elbow", "wrist")):
        for side, name in enumerate(("left", "right")):
            a, b = (fit.seen.names.index(f"{name}_{one}") for one in (begin, end))
            sure = np.minimum(fit.sure[a], fit.sure[b])
            arrow = (fit.seen.pixel[b] - fit.seen.pixel[a]) - (fit.predicted[b] - fit.predicted[a])
            length = fit.metre[b] * BODY.skeleton.lengths[limb + side]
            share = np.minimum(np.linalg.norm(arrow, axis=1) / length, 1.5)
            expected[limb + side] = sure.max() * np.average(share, weights=sure), sure.max()
    np.testing.assert_allclose(disagreement(shown, BODY, pose), expected)
    assert 0.0 < expected[2:, 0].min() < expected[2:, 0].max()
    faded = carried_on(expected, 0.6, None, BODY, pose)
    np.testing.assert_allclose(faded, expected / 4.0)
    np.testing.assert_allclose(carried_on(0.0 * expected, 0.6, shown, BODY, pose), expected)
