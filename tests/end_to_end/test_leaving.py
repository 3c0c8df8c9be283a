"""A person who leaves the volume and comes back."""

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.recording.landmarks import LANDMARKS, read_landmarks
from stereotrack_core.tracking.presets import preset

WHOLE = -0.25  # metres from the side, inside, from which the whole trunk is in the volume
FOUND_WITHIN = 5  # frames after the trunk is in the volume again
AWAY_BY = 0.4  # metres behind the side of the volume, with which no part of the body is in it
TRUNK = [LANDMARKS.index(name) for name in ("left_hip", "right_hip")]


def _outside(points, settings) -> np.ndarray:
    """Metres (F,) by which the hips are out of the working volume; negative inside."""
    hips = points[:, TRUNK].mean(axis=1)[:, :2]
    half = np.array([settings.volume_x, settings.volume_y]) / 2
    return (np.abs(hips - [settings.volume_centre_x, settings.volume_centre_y]) - half).max(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["accurate", "fast"])
def test_away_is_not_tracked_and_back_is_found_again(name, tmp_path, run):
    folder, place = tmp_path / "leaving", tmp_path / "run.npz"
    motion = ("--motion", "leave-and-return+cross-arms", "--frames", 130, "--views", "NS")
    assert run("simulate", folder, *motion).status == 0
    tracked = run("track", folder, "-o", place, "--preset", name, "--init", "tpose")
    assert tracked.status == 0
    stored, truth = read_run(place), read_landmarks(folder / "reference.csv")
    out = _outside(truth.points, preset(name).depth)
    assert (out > AWAY_BY).any()
    assert not stored.tracked[out > AWAY_BY].any()
    hips = [p[:, TRUNK].mean(axis=1) for p in (stored.landmarks, truth.points)]
    off = np.linalg.norm(hips[0] - hips[1], axis=1)
    gone = int(np.flatnonzero(out > 0)[0])
    assert stored.tracked[: int(np.flatnonzero(out > WHOLE)[0]) - 2].mean() > 0.95
    leaving = slice(gone - 8, gone)
    assert not (stored.tracked[leaving] & (off[leaving] > 0.2)).any()
    back = int(np.flatnonzero(out > WHOLE)[-1]) + 1
    coming = slice(int(np.flatnonzero(out > 0)[-1]) + 1, back + FOUND_WITHIN)
    assert not (stored.tracked[coming] & (off[coming] > 0.2)).any()
    assert stored.tracked[back + FOUND_WITHIN :].all()
    assert np.median(off[back + FOUND_WITHIN : back + FOUND_WITHIN + 10]) < 0.12
