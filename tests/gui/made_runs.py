"""Runs that are made of a recording's reference instead of being tracked."""

from pathlib import Path

import numpy as np

from app.session.runs import RunEntry, entry_of_run
from stereotrack_core.body.angles import ALL_JOINTS, pose_of_state, state_names, state_of_pose
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.posing import pose_of_landmarks
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run

NAMES = state_names(ALL_JOINTS)


def made_run(recording: Recording, off=0.0, frames=None, wild=()) -> Run:
    """A run beside the truth: arms turned by `off` radians, in `wild` frames by a right angle."""
    truth = recording.reference
    numbers = truth.frame if frames is None else truth.frame[frames]
    body = body_model(proportions_of(recording.subject))
    columns = [i for i, name in enumerate(NAMES) if "arm_alpha" in name]
    x = []
    for frame in numbers:
        state = state_of_pose(pose_of_landmarks(truth.points[frame]), ALL_JOINTS)
        state[columns] += np.pi / 2 if frame in wild else off
        x.append(state)
    x = np.array(x)
    n, count = len(NAMES), len(numbers)
    return Run(
        frame=numbers, landmarks=landmarks(body, pose_of_state(x, ALL_JOINTS)), x=x,
        P=np.tile(1e-4 * np.eye(n), (count, 1, 1)), state_names=NAMES,
        tracked=np.ones(count, dtype=bool), unexplained_fraction=np.full(count, 0.1),
        residual=np.full(count, 0.01), innovation=np.ones(count),
        limb_sigma_deg=np.full((count, 6), 3.0), limb_lost=np.full((count, 6), 0.1),
        seconds=np.zeros((count, 0)), stage_names=(),
        meta={"fps": recording.fps},
    )  # fmt: skip


def add_run(window, name, **wanted) -> RunEntry:
    """Put a made run into the window's list."""
    run = made_run(window.context.session.document.recording, **wanted)
    entry = entry_of_run(run, Path(f"{name}.npz"))
    window.context.session.runs.add(entry)
    return entry
