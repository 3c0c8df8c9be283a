"""Frames by stated times, and trajectories at the frames of another rate."""

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.recording.frame_times import on_frames, row_times
from stereotrack_core.recording.landmarks import LandmarkTrajectory, read_landmarks


def straight(frames, fps, notes=()):
    """All landmarks at x = time in seconds."""
    time = np.asarray(frames) / fps
    points = np.zeros((len(time), 9, 3))
    points[..., 0] = time[:, None]
    return LandmarkTrajectory(np.asarray(frames, dtype=np.int64), points, fps, notes)


def placed(number, time, fps):
    """Frames, rate, and what is said."""
    number, time = np.asarray(number), np.asarray(time, dtype=float)
    points = np.zeros((len(number), 9, 3))
    points[..., 0] = time[:, None]
    rows = row_times(number, time, fps, "a.trc")
    frame, points = on_frames(rows, points, "a.trc")
    return frame.tolist(), rows.fps, [f"{one.what}. {one.remedy}" for one in rows.notes], points


@pytest.mark.parametrize(
    ("number", "time", "fps", "frames", "rate", "said"),
    [
        ([5, 6, 7], [0.5, 0.6, 0.7], 10.0, [5, 6, 7], 10.0, None),
        ([1, 2, 3], [0.0, 0.1, 0.2], 10.0, [0, 1, 2], 10.0, "row of frame 1 has the time 0 s"),
        ([1, 2, 3], [0.0, 0.1, 0.2], 100.0, [0, 1, 2], 10.0, "its times have 10"),
        ([1, 11, 21], [0.0, 0.1, 0.2], 100.0, [0, 10, 20], 100.0, "frame 0 counted from 0"),
        ([0, 1, 2, 3], [0.0, 0.1, 5.0, 5.1], 10.0, [0, 1, 50, 51], 10.0, "frame 50"),
        ([3, 4], [0.3, np.nan], 10.0, [3, 4], 10.0, None),
        ([3, 4], [0.0, 0.0], 10.0, [3, 4], 10.0, "do not ascend"),
        ([3, 4], [1.7e9, 1.7e9 + 0.1], 10.0, [3, 4], 10.0, "those of a clock"),
        ([1, 2, 3], [0.1, 0.2, 0.3], None, [1, 2, 3], 10.0, None),
        ([], [], 10.0, [], 10.0, None),
    ],
)
def test_times_go_before_numbers_and_rates(number, time, fps, frames, rate, said):
    found, found_rate, notes, _ = placed(number, time, fps)
    assert (found, found_rate) == (frames, rate)
    assert bool(notes) == (said is not None)
    assert not said or said in notes[-1] or said in notes[0]


def test_rows_between_two_frames_are_interpolated():
    frames, fps, notes, points = placed([0, 1, 2, 3], [0.04, 0.14, 0.24, 0.34], 10.0)
    assert (frames, fps) == ([1, 2, 3], 10.0)
    np.testing.assert_allclose(points[:, 0, 0], [0.1, 0.2, 0.3])
    assert "time 0.04 s, which is frame 0.4" in notes[0]


@pytest.mark.parametrize(("own", "fps", "wanted"), [(100, 10, 100), (25, 10, 100), (10, 30, 298)])
def test_another_rate_is_resampled_by_time_and_says_so(own, fps, wanted):
    found = straight(range(10 * own), own).at_rate(fps, "mocap.trc")
    assert (len(found.frame), found.fps) == (wanted, fps)
    np.testing.assert_allclose(found.points[:, 3, 0], found.frame / fps, atol=1e-12)
    assert f"it has {own} frames per second, the recording {fps}" in found.notes[0].what


def test_gaps_are_not_bridged_and_ends_not_extended():
    own = straight(range(5, 205), 100.0)
    own.points[40:80, 2] = np.nan  # 0.45 to 0.84 s
    own.points[105, 4] = np.nan  # one sample, at 1.1 s
    found = own.at_rate(10.0, "mocap.trc")
    assert found.frame.tolist() == list(range(1, 21))
    known = np.isfinite(found.points[..., 0])
    assert found.frame[~known[:, 2]].tolist() == [5, 6, 7, 8]
    assert known[:, [0, 1, 3, 4, 5]].all()
    np.testing.assert_allclose(found.points[10, 4, 0], 1.1)


def test_a_reference_keeps_its_uncertainty_at_another_rate():
    own = straight(range(41), 20.0)
    covariance = np.tile(1e-4 * np.eye(3), (41, 9, 1, 1))
    covariance[:, :, 0, 0] += 1e-6 * np.arange(41)[:, None]
    filled = np.arange(41) >= 20
    sure, meta = np.full((41, 6), 2.0), {"fps": 20.0}
    reference = Reference(own.frame, own.points, covariance, sure, filled, meta=meta)
    found = reference.at_rate(10.0, "r.npz").in_recording(15, "r.npz")
    assert (found.fps, found.frame.tolist()) == (10.0, list(range(15)))
    np.testing.assert_allclose(found.covariance[:, 4, 0, 0], 1e-4 + 2e-6 * np.arange(15))
    assert found.filled.tolist() == [False] * 10 + [True] * 5
    assert (found.limb_sigma_deg == 2.0).all()
    assert len(found.notes) == 2


def test_a_table_with_times_is_read_by_them(tmp_path):
    path = tmp_path / "truth.csv"
    rows = [f"{k + 1},head,{k / 50},0,1,{k / 50}" for k in range(100)]
    path.write_text("\n".join(["frame,landmark,x,y,z,time", *rows]) + "\n")
    found = read_landmarks(path)
    assert (found.fps, found.frame.tolist()) == (50.0, list(range(100)))
    assert "row of frame 1 has the time 0 s" in found.notes[0].what
    path.write_text(path.read_text().replace("0.02\n", "soon\n", 1))
    with pytest.raises(InputError, match="'soon' as time"):
        read_landmarks(path)
