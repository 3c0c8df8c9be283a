"""Trackers and runs for tests: the one place that knows how they are stepped."""

from dataclasses import replace

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.inspection import explain
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.thesis import ThesisModel
from tests.tracking.scenes import CAMERAS


class Stepping:
    """A model with its state, which every step replaces."""

    def __init__(self, model):
        self.model, self.setup = model, model.setup
        alone = isinstance(model, Follower)
        self.state = model.first(t_pose(np.zeros(3))) if alone else model.absent()

    @property
    def pose(self):
        return self.state.pose

    @property
    def P(self):
        return self.state.P

    def start(self, pose, time=None, *, P=None):
        self.state = self.model.first(pose, time, P=P)

    def step(self, cloud, recorder=None):
        self.state, estimate = self.model.step(self.state, cloud, recorder)
        return estimate

    def explain(self, cloud, truth=None):
        return explain(self.model, self.state, cloud, truth)


def tracker_of(name, *, fps=10.0, seed=0, cameras=CAMERAS, **changes):
    """A tracker of an average body, ``thesis`` or ``manifold``; parameters by name."""
    if name == "manifold":
        changes = {"search_arms": False, "data_points": 400, "iterations": 4} | changes
    settings = preset("thesis" if name == "thesis" else "accurate").replaced(**changes)
    body = body_model(AVERAGE, settings.body)
    setup = Setup(body, settings.tracking, cameras, fps, seed)
    if name == "thesis":
        return Stepping(ThesisModel(setup))
    return Stepping(Follower(setup))


def go_on(run, frames):
    """Track further frames; those that are there at the end, and the run after them."""
    found = []
    for advance in advances(run, frames):
        run = advance.run
        found = [one for one in found if one.frame < advance.gained.first]
        found += advance.gained.frames
    return found, run


def tracked_frames(recording, spec, frames=None, source=None):
    """Track a recording; its frames, with clouds, and the run after them."""
    spec = spec if frames is None else replace(spec, frames=frames)
    with Clouds(recording, spec, source) as clouds:
        return go_on(prepare(clouds), clouds.frames)
