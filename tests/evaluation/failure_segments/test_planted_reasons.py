"""Planted failures of known cause in single steps: how often the arm search's verdict is right."""

import zlib
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import pytest

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.posing import pose_showing
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking.arm_search import search as arm_search
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, directions, with_arm
from stereotrack_core.tracking.inspection import explain
from stereotrack_core.tracking.model import cameras_of, model_for
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore
from tests.evaluation.failure_segments.test_planted import arms_without_texture, blacked_out

pytestmark = pytest.mark.slow

SCENES = {
    "cross": Simulation("P1", "cross-arms", 14, "NS", 43),
    "travolta": Simulation("P3", "travolta", 10, "NO", 42),
    "whip": Simulation("P3", "whip", 10, "NO", 51),
    "point": Simulation("P4", "point", 12, "NO", 44),
}
OPTIONS = SceneOptions().replaced(fps=5.0, pace=2.0, t_pose_first=False)
SETTINGS = preset("fast").replaced(detector="off", search_proposals=220, search_refined=3)
RIGHT_DEG, WRONG_DEG = 20.0, 35.0  # without and with what is planted


@dataclass(frozen=True)
class Plant:
    """What is planted, and what the verdict should be."""

    why: str
    changes: dict = field(default_factory=dict)
    change_times: float = 1.0  # factor on the cost of change
    picture: object = None


PLANTS = {
    "few candidates": Plant("search", {"search_proposals": 20, "search_refined": 1}),
    "no views": Plant("cost", {"picture_cost": 0.0}),
    "views alone": Plant("cost", {"picture_cost": 20000.0}),
    "arms apart": Plant("cost", {"arms_apart": 0.2}),
    "change": Plant("cost", change_times=15.0),
    "covered": Plant("data", picture=blacked_out),
    "blank": Plant("data", picture=arms_without_texture),
}


def clouds_of(folder, simulation, picture=None):
    """The recording, with its pictures changed, and clouds of its frames."""
    simulate(folder, simulation)
    if picture is not None:
        picture(open_recording(folder), range(simulation.frames))
    recording = open_recording(folder)
    with FrameReader(recording, views=usable_views(recording, None), colour=False) as reader:
        store = CloudStore(recording, reader)
        kept = store.clouds(CloudKey(SETTINGS.depth, range(reader.frame_count)))
        clouds = [kept.take(k)[0] for k in range(1, reader.frame_count - 1)]
        store.close()
    return recording, clouds


def with_wrong_arms(pose, rng):
    """The pose with one or both arms somewhere else."""
    for side in ((LEFT,), (RIGHT,), (LEFT, RIGHT))[rng.integers(3)]:
        upper = directions(rng.normal(size=3) + np.array([(0.5, -0.5)[side], 0.4, -0.5]))
        fore = directions(rng.normal(size=3) + np.array([0.0, 1.0, 0.0]))
        pose = with_arm(pose, side, upper, fore)
    return pose


def searches(name, recording, clouds, changes):
    """Recorded searches by frame and start; each step begins with wrong arms."""
    settings = SETTINGS.replaced(**changes)
    body = body_of_subject(recording.subject, settings.body)
    cameras = cameras_of(recording, usable_views(recording, None))
    model, found = model_for(body, settings, cameras, recording.fps, 0), {}
    for cloud in clouds:
        truth = recording.reference.points[cloud.frame]
        known = dict(zip(LANDMARKS, truth, strict=True))
        true = pose_showing(known, body, hanging_pose(np.zeros(3)))
        for start in range(2):
            rng = np.random.default_rng((cloud.frame, start, zlib.crc32(name.encode())))
            trace = explain(model, model.first(with_wrong_arms(true, rng)), cloud, truth)
            found[cloud.frame, start] = trace.search
    return found


def off(search):
    return np.degrees(search.truth.off.max())


@pytest.mark.timeout(3600)
def test_nine_of_ten_verdicts_are_those_that_were_planted(tmp_path, monkeypatch, record_property):
    told: Counter[tuple[str, str]] = Counter()
    usual = arm_search.change_cost
    for name, simulation in SCENES.items():
        scene = Simulation(
            *(simulation.person, simulation.motion, simulation.frames),
            *(simulation.views, simulation.seed, OPTIONS),
        )
        plain = clouds_of(tmp_path / name, scene)
        before = searches(name, *plain, {})
        for what, plant in PLANTS.items():
            seen = plain
            if plant.picture is not None:
                seen = clouds_of(tmp_path / f"{name}-{what}", scene, plant.picture)
            times = plant.change_times
            monkeypatch.setattr(
                arm_search, "change_cost", lambda *a, times=times: times * usual(*a)
            )
            after = searches(name, *seen, plant.changes)
            monkeypatch.undo()
            for key, search in after.items():
                if search is None or before[key] is None:
                    continue
                if off(before[key]) < RIGHT_DEG and off(search) > WRONG_DEG:
                    told[plant.why, reason_of(search).why] += 1
    for pair, count in sorted(told.items()):
        record_property(" told as ".join(pair), count)
    right = sum(count for (planted, said), count in told.items() if planted == said)
    assert told.total() >= 40, told
    assert right / told.total() >= 0.88, told
