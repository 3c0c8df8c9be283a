"""Runs made of numbers, in which the tracker loses limbs where it is told to."""

from dataclasses import replace

import numpy as np

from stereotrack_core.body.angles import ALL_JOINTS, pose_of_state, state_names, state_of_pose
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run
from tests.tracking.recordings import write_depth_recording

NAMES = state_names(ALL_JOINTS)
FPS = 10.0


def made(frames=60, wrong=(), lost=(), fps=FPS, **changes) -> tuple[Run, LandmarkTrajectory]:
    """A run beside its truth: arms hang stretched out a little, and nothing moves.

    Parameters
    ----------
    wrong : sequence of (limb, first, last, radians)
        Stretches in which a limb is turned away from the truth.
    lost : sequence of (limb, first, last, chance)
        Stretches in which the run itself takes a limb for lost.
    changes
        Replace fields of the run.
    """
    body = body_model(AVERAGE)
    right = state_of_pose(hanging_pose(np.array([0.0, 0.0, 0.9])), ALL_JOINTS)
    for side in ("left", "right"):
        right[NAMES.index(f"{side}_upper_arm_alpha")] += 0.9
    x = np.tile(right, (frames, 1))
    truth = landmarks(body, pose_of_state(x, ALL_JOINTS))
    for limb, first, last, angle in wrong:
        x[first : last + 1, NAMES.index(f"{limb}_alpha")] += angle
    chance = np.full((frames, len(LIMBS)), 0.02)
    chance[:, :2] = np.nan
    for limb, first, last, value in lost:
        chance[first : last + 1, LIMBS.index(limb)] = value
    fields = {
        "frame": np.arange(frames), "x": x,
        "landmarks": landmarks(body, pose_of_state(x, ALL_JOINTS)),
        "P": np.tile(1e-4 * np.eye(len(NAMES)), (frames, 1, 1)), "state_names": NAMES,
        "tracked": np.ones(frames, dtype=bool), "unexplained_fraction": np.full(frames, 0.1),
        "residual": np.full(frames, 0.01), "innovation": np.ones(frames),
        "limb_sigma_deg": np.full((frames, len(LIMBS)), 3.0), "limb_lost": chance,
        "seconds": np.zeros((frames, 0)), "stage_names": (), "meta": {"fps": fps},
    }  # fmt: skip
    return Run(**(fields | changes)), LandmarkTrajectory(np.arange(frames), truth)


def untracked(run: Run, first: int, last: int) -> Run:
    gone = (run.frame >= first) & (run.frame <= last)

    def blanked(values):
        result = np.array(values, dtype=np.float64)
        result[gone] = np.nan
        return result

    names = ("landmarks", "x", "P", "unexplained_fraction", "residual", "innovation", "limb_lost")
    return replace(run, tracked=~gone, **{name: blanked(getattr(run, name)) for name in names})


def recorded(folder, frames=12, wrong=(("left_forearm", 4, 9, 1.4),), **changes):
    """A tiny recording of depth views and a run of it that fails; both know each other."""
    run, truth = made(frames, wrong)
    right, _ = made(frames)
    poses = [pose_of_state(row, ALL_JOINTS) for row in right.x]
    recording = write_depth_recording(folder, body_model(AVERAGE), poses, **changes)
    subject = {"name": "P", **vars(AVERAGE)}
    meta = {
        "recording": recording.name, "recording_folder": str(folder), "fps": recording.fps,
        "views": [view.name for view in recording.views], "subject": subject, "blind": [],
        "parameters": {"pixel_step": 1, "speckle_size": 0},
    }  # fmt: skip
    return recording, replace(run, meta=meta), truth
