"""Archives of arrays that promise what they do not hold, and runs that state nonsense."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import is_reference, read_reference, write_reference
from stereotrack_core.interop.run_file import read_run, write_trajectory
from stereotrack_core.interop.run_npz import run_bytes, run_of_bytes, write_npz
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from tests.reading.mutations import archived, member, with_meta


@pytest.fixture(params=[read_run, read_reference])
def stored(request, samples, tmp_path):
    """Path of a file of either kind, and what reads it."""
    path, read = tmp_path / "file.npz", request.param
    if read is read_run:
        write_npz(path, samples.run)
    else:
        write_reference(path, samples.reference)
    return path, read


def replaced(path: Path, **members: bytes) -> None:
    """Write an archive again with other members."""
    with zipfile.ZipFile(path) as archive:
        content = {info.filename: archive.read(info) for info in archive.infolist()}
    path.write_bytes(archived(content | {f"{key}.npy": data for key, data in members.items()}))


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"frame": member("<i8", (10**18,))}, "damaged"),
        ({"frame": member("|O", (6,), bytes(48))}, "wrong data type"),
        ({"frame": member("<i8", (7,), bytes(56))}, "length"),
        ({"frame": member("<i8", (6,), bytes(40))}, "damaged"),
        ({"meta": member("<U1000000000", ())}, "damaged"),
        ({"meta": member("<U1", (), b"\xff\xff\xff\x7f")}, "damaged"),
    ],
)
def test_headers_that_lie(stored, members, words, little_memory):
    path, read = stored
    replaced(path, **members)
    with pytest.raises(InputError, match=words) as refusal, little_memory():
        read(path)
    assert refusal.value.where.startswith(str(path))
    assert "memory" not in str(refusal.value)


def test_an_archive_that_unfolds_without_end(stored, little_memory):
    path, read = stored
    replaced(path, meta=member("<U70000000", (), bytes(280_000_000)))
    assert path.stat().st_size < 1_000_000
    with pytest.raises(InputError, match="claims to contain 267 MB"), little_memory():
        read(path)


def test_other_arrays_do_no_harm(stored):
    path, read = stored
    before = read(path).frame
    replaced(path, more=b"no array", other=member("|O", (10**18,)))
    assert np.array_equal(read(path).frame, before)
    assert is_reference(path) == (read is read_reference)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frame": lambda a: a + 2**40}, "between 0 and"),
        ({"x": lambda a: a * np.inf}, "too large"),
        ({"x": lambda a: np.full_like(a, np.nan)}, "has no pose"),
    ],
)
def test_numbers_that_no_run_has(samples, tmp_path, changes, words):
    path = tmp_path / "run.npz"
    write_npz(path, samples.run)
    arrays = dict(np.load(path))
    with np.errstate(invalid="ignore"):
        np.savez(path, **arrays | {name: change(arrays[name]) for name, change in changes.items()})
    with pytest.raises(InputError, match=words):
        read_run(path)


WRONG = {
    **dict.fromkeys(("preset", "made", "recording_folder", "fingerprint"), (3,)),
    **dict.fromkeys(("fps", "wall_seconds"), ("10", float("nan"))),
    **dict.fromkeys(("smoothed", "started_at_reference"), ("no",)),
    "seed": (1.5,),
    "views": ([3],),
    "parameters": ({"iterations": [3]}, {"legs": {}}),
    "body": ({"legs": []},),
    "subject": ({"shoulder_width": "0.4"}, {"torso_length": -1.0}),
    "frames": ([1, 2, 3],),
    "first_pose": ({"position": [0, 0, None]}, {"rotations": [1.0]}),
    "detections": ({"count": "3"},),
    "blind": ([{"view": "N", "first": "a", "end": 3}],),
}
"""Keys of a run's meta with values of another kind."""


@pytest.mark.parametrize(("key", "value"), [(k, v) for k, many in WRONG.items() for v in many])
def test_a_run_states_a_value_of_another_kind(samples, tmp_path, key, value):
    path = tmp_path / "run.npz"
    path.write_bytes(with_meta(run_bytes(samples.run), lambda meta: {**meta, key: value}))
    with pytest.raises(InputError, match=key) as refusal:
        read_run(path)
    assert refusal.value.where.startswith(f"{path}, meta, {key}")
    assert refusal.value.remedy


def _with_own_meta(run, meta):
    return with_meta(run_bytes(run), lambda _: meta)


def test_what_a_run_does_not_state_is_not_missed(samples):
    for key in samples.run.meta:
        kept = {name: one for name, one in samples.run.meta.items() if name != key}
        assert run_of_bytes(_with_own_meta(samples.run, kept), "a run").meta == kept


def test_a_value_left_out_is_refused_unless_it_may_be_unknown(samples):
    for key in samples.run.meta:
        meta = {**samples.run.meta, key: None}
        data = _with_own_meta(samples.run, meta)
        if key in ("subject", "first_pose", "detections", "frames", "wall_seconds"):
            assert run_of_bytes(data, "a run").meta == meta
        else:
            with pytest.raises(InputError, match=f"{key}: the value is missing"):
                run_of_bytes(data, "a run")


@pytest.mark.parametrize("suffix", [".c3d", ".bvh", ".trc"])
def test_few_frames_in_a_long_stretch(tmp_path, suffix, samples, little_memory):
    """Formats without gaps would need a row for each of thirty million frames."""
    far = np.array([0, 30_000_000])
    trajectory = LandmarkTrajectory(far, samples.run.landmarks[:2])
    with (
        pytest.raises(InputError, match=r"30000000|frame numbers are limited to") as refusal,
        little_memory(),
    ):
        write_trajectory(tmp_path / f"a{suffix}", trajectory, 10.0)
    assert refusal.value.where == str(tmp_path / f"a{suffix}")
    write_trajectory(tmp_path / "a.csv", trajectory, 10.0)
    near = LandmarkTrajectory(np.array([0, 9000]), samples.run.landmarks[:2])
    write_trajectory(tmp_path / f"b{suffix}", near, 10.0)
