"""References come back bit by bit with what they say about themselves, or are refused in words."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import is_reference, read_reference, write_reference
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.landmarks import LANDMARKS


def reference(frames=5, *, full=True):
    rng = np.random.default_rng(3)
    points = rng.normal(size=(frames, 9, 3))
    points[1, 2] = np.nan
    extra = {}
    if full:
        extra = {
            "covariance": 1e-4 * rng.normal(size=(frames, 9, 3, 3)),
            "limb_sigma_deg": rng.uniform(1, 5, (frames, 6)),
            "filled": rng.uniform(size=frames) > 0.5,
        }
    return Reference(np.arange(3, 3 + frames), points, meta={"annotators": ["Ä"]}, **extra)


@pytest.mark.parametrize("full", [True, False])
def test_round_trip(tmp_path, full):
    path, written = tmp_path / "r.npz", reference(full=full)
    write_reference(path, written)
    read = read_reference(path)
    for name in ("frame", "points", "covariance", "limb_sigma_deg", "filled"):
        one, two = getattr(written, name), getattr(read, name)
        assert (one is None and two is None) or np.array_equal(one, two, equal_nan=True)
    assert (read.landmark_names, read.meta) == (LANDMARKS, {"annotators": ["Ä"]})
    assert is_reference(path)
    assert np.array_equal(read_trajectory(path).points, written.points, equal_nan=True)


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "r.npz"
    with pytest.raises(InputError, match="no such file"):
        read_reference(path)
    path.write_bytes(b"PK no archive")
    with pytest.raises(InputError, match="not a reference of this program"):
        read_reference(path)
    assert not is_reference(path)
    np.savez(path, frame=np.arange(3))
    assert not is_reference(path)
    with pytest.raises(InputError, match="not a reference of this program"):
        read_reference(path)
    write_reference(path, reference())
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="not a reference of this program"):
        read_reference(path)
