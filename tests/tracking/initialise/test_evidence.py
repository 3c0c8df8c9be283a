"""Evidence for a heading in one frame, and over frames, against the same sums in plain NumPy."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.cloud import DepthGeometry, ViewDepth
from stereotrack_core.geometry.upright import Z_UP
from stereotrack_core.tracking.frame import FirstFrame
from stereotrack_core.tracking.initialise import heading
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.heading import HeadingWatch, ahead, evidence
from stereotrack_core.tracking.initialise.trunk import (
    away_cost,
    feet_ahead,
    lean_cost,
    legs_cost,
    turned_round,
)
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.residuals.clicks import missed
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.state import Setup
from tests.tracking.initialise.test_trunk import random_pose
from tests.tracking.keypoints.cases import VIEWS
from tests.tracking.keypoints.cases import seen as clicked
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, turned
from tests.tracking.views import looking

BODY = body_model(AVERAGE)
MOST = {"toes": 3, "feet": 3, "legs": 3, "arms": 4, "cameras": 1, "keypoints": 3, "clicks": 2}


def _finder(cameras=CAMERAS):
    return PoseFinder(Setup(BODY, preset("accurate").tracking, cameras, 10.0, 0))


def _is_person(view, points):
    """0 or 1 of points (..., 3): whether they appear on the person."""
    u, v, z = view.geometry.project(points.reshape(-1, 3))
    height, width = view.outline.shape
    row, column = np.rint(v), np.rint(u)
    inside = (
        (z > 0.0) & (row == np.clip(row, 0, height - 1)) & (column == np.clip(column, 0, width - 1))
    )
    found = np.zeros(len(u))
    found[inside] = view.outline[row[inside].astype(int), column[inside].astype(int)]
    return found.reshape(points.shape[:-1])


def _toes(frames, view, forward):
    up, found = np.array([0.0, 0.0, 1.0]), []
    for shank in (8, 9):
        length = BODY.skeleton.lengths[shank]
        ankle = frames.apply(np.array([shank]), np.array([[0.0, 0.0, length]]))[0]
        sight = (ankle - view.geometry.world_from_depth.translation) * [1.0, 1.0, 0.0]
        if np.linalg.norm(np.cross(sight / np.linalg.norm(sight), forward)) < 0.64:
            continue
        aside = np.linspace(-0.12, 0.12, 25)
        leg = _is_person(
            view,
            ankle + np.linspace(0.12, 0.20, 5)[:, None, None] * up + aside[:, None] * forward,
        )
        if (leg.sum(axis=1) == 0).any():
            continue
        ankle = ankle + np.average(np.tile(aside, (5, 1)), weights=leg) * forward
        heights = np.linspace(0.10, -0.25, 36)
        below = _is_person(view, ankle + heights[:, None] * up)
        if below[0] == 0 or below.all():
            continue
        sole = ankle + (heights[below == 0][0] + 0.03) * up
        along = np.array([0.10, 0.12, 0.14])[:, None] * forward
        found.append(_is_person(view, sole + along).mean() - _is_person(view, sole - along).mean())
    return found


def _outlined(rng, eye):
    """View of patches of a person as wide as feet."""
    patches = cv2.GaussianBlur(rng.normal(size=(240, 320)), (0, 0), 5.0) > -0.01
    geometry = DepthGeometry(260.0, 160.0, 60.0, 0.1, 0.0, 320, 240, looking(eye))
    return ViewDepth(geometry, np.ones((240, 320), np.float32), patches, None, patches)


def test_toes_are_looked_for_where_outlines_show_feet_from_the_side(rng):
    found, expected, up = [], [], np.array([0.0, 0.0, 1.0])
    for _ in range(80):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        view = _outlined(rng, (2.5 * np.cos(angle), 2.5 * np.sin(angle), rng.uniform(0.5, 1.6)))
        pose = random_pose(rng, 0.3)
        frames = BODY.frames(pose)
        forward = ahead(frames, Z_UP)
        np.testing.assert_allclose(forward, [*(y := pose.torso[:2, 1]) / np.hypot(*y), 0.0])
        found.append(list(heading._toes_in(BODY, frames, view, forward, up)))
        expected.append(_toes(frames, view, forward))
    assert sum(map(len, expected)) > 30
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def _beyond(value, dead, full):
    return np.sign(value) * np.clip((abs(value) - dead) / full, 0.0, 1.0)


def test_evidence_of_a_frame_is_weighed_piece_by_piece(rng):
    whole = set()
    for _ in range(25):
        cameras = rng.normal(0.0, 3.0, (2, 3))
        finder, pose = _finder(cameras), random_pose(rng, rng.uniform(0.1, 0.5))
        back, shown = turned_round(pose), random_pose(rng, 0.2)
        here, there = (BODY.frames(one) for one in (pose, back))
        ankles = here.apply(np.array([8, 9]), BODY.skeleton.lengths[[8, 9], None] * [[0, 0, 1.0]])
        feet = np.repeat(ankles, 15, axis=0) + rng.normal(0.0, [0.06, 0.06, 0.01], (30, 3))
        view = _outlined(rng, (2.5, rng.normal(), 1.0))
        clicks = [
            clicked(n, shown, camera=VIEWS["N"]) for n in ("left_hand", "right_elbow", "head")
        ]
        keypoints = seen(pose, {(v, "left_wrist"): rng.normal(0, 30, 2) for v in "NOSW"})
        some = replace(
            keypoints, confidence=keypoints.confidence * np.r_[True, rng.random(3) < 0.5]
        )
        cloud = replace(cloud_of(feet), clicks=tuple(clicks), depths={"N": view}, keypoints=some)
        fits = [
            KeypointObservation(some, finder.setup.parameters.keypoint_sigma).fitted(BODY, one)
            for one in (back, pose)
        ]
        bend = legs_cost(there) + lean_cost(there) - legs_cost(here) - lean_cost(here)
        fore = np.mean([here.rotations[p, :, 2] for p in (4, 5)], axis=0) @ here.rotations[0, :, 1]
        reach = AVERAGE.forearm_length + 0.5 * AVERAGE.hand_length
        arms = finder.arms_cost(back) - finder.arms_cost(pose)
        expected = {
            "legs": 0.7 * _beyond(bend, 5.0, 20.0),
            "arms": 1.5 * _beyond(arms, 3.0, 9.0) + _beyond(reach * fore, 0.05, 0.10),
            "cameras": 1.5 * (away_cost(there, cameras) - away_cost(here, cameras)) / 20.0,
        }
        if toes := _toes(here, view, ahead(here, Z_UP)):
            expected["toes"] = 2.0 * np.mean(toes)
        if before := feet_ahead(BODY, here, feet):
            expected["feet"] = 0.7 * np.clip(np.mean(before) / 0.05, -1.0, 1.0)
        off = missed(BODY, back, clicks) - missed(BODY, pose, clicks)
        expected["clicks"] = 4.0 * np.clip(off / 20.0, -1.0, 1.0)
        gain = np.clip((fits[0].cost() - fits[1].cost()) / 0.3, -1.0, 1.0)
        expected["keypoints"] = 3.0 * fits[0].independence * gain
        assert evidence(finder, pose, cloud) == pytest.approx(expected, abs=1e-9)
        whole |= expected.keys()
    assert whole == MOST.keys()


class _Plain:
    """What :class:`HeadingWatch` adds up, as its documentation says."""

    def __init__(self, fps):
        self.fps, self.sums, self.looks = fps, dict.fromkeys(MOST, 0.0), dict.fromkeys(MOST, 0.0)
        self.walked, self.seen, self.turned, self.last = 0.0, 0, 1.0, None
        self.active, self.against = True, None

    def probability(self):
        kinds = (k for k in MOST if self.looks[k])
        ratio = sum(self.sums[k] / self.looks[k] * min(self.looks[k], MOST[k]) for k in kinds)
        return 1.0 / (1.0 + np.exp(-ratio - np.clip(5.0 * self.walked, -6.0, 6.0)))

    def take(self, frame, pose, found, is_last):
        if not self.active:
            return
        if pose is not None:
            self._follow(frame, pose, found)
        settled, self.active = not self.active, self.active and not is_last and self.seen < 100
        doubtful = not self.active and self.against is None and self.seen >= 20
        if doubtful and self.probability() < 0.4:
            self.against = frame
        assert not settled or not self.active

    def _follow(self, frame, pose, found):
        forward, seconds, last = pose.torso[:, 1], 0.5, self.last
        self.last = frame, pose.position, forward
        if last is not None:
            seconds, same = (frame - last[0]) / self.fps, forward @ last[2]
            self.turned *= -1.0 if same < -0.5 else 1.0
            way = pose.position - last[1]
            if np.linalg.norm(way) > 0.3 * seconds and same > 0.5:
                self.walked += self.turned * (way @ (forward + last[2])) / 2.0
            if seconds > 1.0 / self.fps + 0.5:
                self.active = False
                return
        for kind, value in found.items():
            partly = kind in ("legs", "arms") and self.seen > 0
            look = min(1.0, seconds / 0.5) if partly else 1.0
            self.sums[kind] += look * self.turned * value
            self.looks[kind] += look
        self.seen += 1
        right = self.probability()
        if self.seen >= 3 and max(right, 1.0 - right) >= 0.99:
            self.active, self.against = False, frame if right < 0.5 else None


@pytest.mark.parametrize("seed", range(40))
def test_evidence_and_ways_are_added_up_over_frames(seed, monkeypatch):
    rng, finder = np.random.default_rng(seed), _finder()
    count = int(rng.integers(10, 110))
    bias, walk = rng.normal(0.0, 0.12), rng.choice([0.0, 0.03, 0.06]) * rng.normal(size=2)
    watch, plain = HeadingWatch(10.0, first=FirstFrame(0, POSES["t"])), _Plain(10.0)
    frame, degrees, place, found = 0, 0.0, np.zeros(3), {}
    monkeypatch.setattr(heading, "evidence", lambda *_: found)
    for k in range(count):
        frame += 1 if rng.random() < 0.95 else int(rng.choice([2, 6, 8], p=[0.8, 0.15, 0.05]))
        degrees += rng.normal(0.0, 12.0) + rng.choice([0.0, 70.0, 180.0], p=[0.95, 0.03, 0.02])
        place = place + np.append(walk + rng.normal(0.0, 0.015, 2), 0.0)
        pose = (
            None
            if rng.random() < 0.05
            else turned(Pose(np.zeros(3), POSES["t"].rotations), degrees, place)
        )
        kinds = [kind for kind in MOST if rng.random() < 0.6]
        found = {kind: bias + rng.normal(0.0, 0.3) for kind in kinds}
        watch = watch.updated(
            finder, pose, cloud_of(np.zeros((0, 3)), frame), is_last=k == count - 1
        )
        plain.take(frame, pose, found, k == count - 1)
        assert watch.probability == pytest.approx(plain.probability())
        assert (watch.active, watch.against) == (plain.active, plain.against)
        assert (watch.seen, watch.turned) == (plain.seen, plain.turned)
        assert watch.faced_away == (plain.against is not None)
        sure = plain.seen >= 3 and plain.probability() >= 0.99
        assert watch.state == ("decided" if sure else "undecided")
    other = watch.turned_round()
    assert other.probability == pytest.approx(1.0 - watch.probability)
    assert other.state == (
        "corrected" if other.probability >= 0.99 and watch.seen >= 3 else "undecided"
    )
    assert not other.faced_away
    assert watch.to_dict()["probability"] == round(watch.probability, 4)
