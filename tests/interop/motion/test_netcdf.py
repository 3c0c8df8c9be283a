"""Poses in netCDF, read back by xarray and h5py, and by movement where it is installed."""

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.motion.netcdf import write_netcdf
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.landmarks import LANDMARKS


@pytest.fixture
def written(tmp_path, random, body_trajectory):
    """A file, and its trajectory: frames 7, 8 and 10, one landmark of frame 8 not known."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    trajectory = body_trajectory(random, [7, 8, 10])
    trajectory.points[1, 4] = np.nan
    write_netcdf(tmp_path / "a.nc", trajectory, 20.0)
    return xarray.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), trajectory, tmp_path / "a.nc"


def test_layout_units_and_gaps(written):
    dataset, trajectory, path = written
    assert dict(dataset.sizes) == {"time": 4, "space": 3, "keypoints": 9, "individuals": 1}
    assert dataset.position.dims == ("time", "space", "keypoints", "individuals")
    assert dataset.confidence.dims == ("time", "keypoints", "individuals")
    np.testing.assert_allclose(dataset.time, np.array([7, 8, 9, 10]) / 20.0)
    assert dataset.frame.values.tolist() == [7, 8, 9, 10]
    found = dataset.position.sel(keypoints="left_hand", individuals="person").values
    expected = trajectory.points[:, LANDMARKS.index("left_hand")]
    np.testing.assert_array_equal(found[[0, 1, 3]], expected)
    assert np.isnan(found[2]).all()
    sure = dataset.confidence.sel(individuals="person").values
    np.testing.assert_array_equal(sure, np.isfinite(dataset.position.values).all(axis=1)[..., 0])
    assert (dataset.attrs["fps"], dataset.attrs["space_unit"]) == (20.0, "m")
    h5py = pytest.importorskip("h5py")
    with h5py.File(path) as file:
        assert file["position"].shape == (4, 3, 9, 1)


def test_movement_takes_it(written):
    datasets = pytest.importorskip("movement.validators.datasets")
    kinematics = pytest.importorskip("movement.kinematics")
    dataset, trajectory, _ = written
    datasets.ValidPosesInputs.validate(dataset)
    filtering = pytest.importorskip("movement.filtering")
    kept = filtering.filter_by_confidence(dataset.position, dataset.confidence)
    np.testing.assert_array_equal(kept.values, dataset.position.values)
    speed = kinematics.compute_velocity(dataset.position).sel(keypoints="head", space="x")
    head = trajectory.points[:, LANDMARKS.index("head"), 0]
    assert speed.values[0, 0] == pytest.approx((head[1] - head[0]) * 20.0)


def test_what_was_written_is_read(written):
    _, trajectory, path = written
    found = read_trajectory(path)
    assert (found.fps, found.frame.tolist()) == (20.0, [7, 8, 9, 10])
    np.testing.assert_array_equal(found.points[[0, 1, 3]], trajectory.points)
    assert np.isnan(found.points[2]).all()
    assert "as stated in axes" in found.notes[0].what


def test_what_other_programs_wrote_is_read_or_refused_in_a_sentence(written, tmp_path):
    dataset, trajectory, _ = written
    other = tmp_path / "other.nc"

    def save(changed):
        changed.to_netcdf(other, engine="h5netcdf")
        return other

    plain = dataset.drop_vars("frame")
    plain.attrs = {"ds_type": "poses", "fps": 20.0, "time_unit": "seconds"}
    with pytest.raises(InputError, match="space_unit: unknown unit ''"):
        read_trajectory(save(plain))
    plain = plain.assign(position=1000.0 * plain.position.transpose("individuals", ...))
    plain.attrs["space_unit"] = "mm"
    stated = Stated({"left_hand": "right_hand", "right_hand": "left_hand"}, np.eye(3))
    found = read_trajectory(save(plain), stated)
    hand = found.points[[0, 1, 3], LANDMARKS.index("right_hand")]
    np.testing.assert_allclose(hand, trajectory.points[:, LANDMARKS.index("left_hand")])
    two = plain.reindex(individuals=["person", "p2"])
    with pytest.raises(InputError, match=r"2 individuals \(person, p2\)"):
        read_trajectory(save(two))
