"""TRC files, ours and others'."""

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import Stated, world_from_axes
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


def test_layout_and_axes(tmp_path):
    points = np.full((2, 9, 3), np.nan)
    points[0, LANDMARKS.index("right_hand")] = [0.8, 0.1, 1.4]  # east, north, up
    write_trc(tmp_path / "a.trc", LandmarkTrajectory(np.array([5, 6]), points), 10.0)
    lines = (tmp_path / "a.trc").read_text().split("\n")
    assert lines[0].split("\t") == ["PathFileType", "4", "(X/Y/Z)", "a.trc"]
    facts = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=True))
    assert facts["Units"] == "m"
    assert facts["NumFrames"] == "2"
    assert facts["OrigDataStartFrame"] == "5"
    names, row = lines[3].split("\t"), lines[5].split("\t")
    assert row[:2] == ["5", "0.5"]
    column = names.index("right_hand")
    assert [float(cell) for cell in row[column : column + 3]] == [0.1, 1.4, 0.8]
    assert row.count("NaN") == 3 * 8
    assert len(row) == len(names) == len(lines[6].split("\t"))


def test_millimetres_blank_line_and_foreign_columns(tmp_path, random, body_trajectory):
    trajectory = body_trajectory(random, range(1, 4))
    write_trc(tmp_path / "a.trc", trajectory, 30.0)
    lines = (tmp_path / "a.trc").read_text().split("\n")
    lines[2] = lines[2].replace("\tm\t", "\tmm\t")
    lines[3] = lines[3].replace("head", "sacrum")
    lines.insert(5, "")
    (tmp_path / "b.trc").write_text("\n".join(lines))
    found = read_trajectory(tmp_path / "b.trc")
    assert found.fps == 30.0
    wanted = trajectory.points / 1000.0
    wanted[:, LANDMARKS.index("head")] = np.nan
    np.testing.assert_allclose(found.points, wanted)


@pytest.mark.parametrize(("frame", "words"), [("1", "repeats frame 1"), ("1.5", "'1.5'")])
def test_wrong_frame_numbers_are_refused_by_their_line(
    tmp_path, random, body_trajectory, frame, words
):
    path = tmp_path / "a.trc"
    write_trc(path, body_trajectory(random, range(1, 3)), 30.0)
    lines = path.read_text().splitlines()
    lines[6] = "\t".join([frame, *lines[6].split("\t")[1:]])
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=words) as error:
        read_trajectory(path)
    assert "line 7" in str(error.value)
    assert error.value.remedy


def test_files_that_are_cut_off_or_hold_no_number_are_refused(tmp_path, random, body_trajectory):
    path = tmp_path / "a.trc"
    write_trc(path, body_trajectory(random, range(3)), 30.0)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:-1]))
    with pytest.raises(InputError, match="ends after 2 of its 3 frames"):
        read_trajectory(path)
    lines[6] = "\t".join([*lines[6].split("\t")[:2], "abc", *lines[6].split("\t")[3:]])
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"line 7 .* not a number .*'abc'"):
        read_trajectory(path)
    lines[2] = lines[2].replace("30", "often", 1)
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="'often' is not a frame rate"):
        read_trajectory(path)


def test_gaps_are_empty_frames(tmp_path, random, body_trajectory):
    sparse = body_trajectory(random, [2, 3, 7])
    write_trc(tmp_path / "a.trc", sparse, 25.0)
    lines = (tmp_path / "a.trc").read_text().splitlines()
    assert [line.split("\t")[0] for line in lines[5:]] == ["2", "3", "4", "5", "6", "7"]
    assert lines[7].split("\t")[1] == "0.16"
    assert set(lines[7].split("\t")[2:]) == {"NaN"}
    found = read_trajectory(tmp_path / "a.trc")
    assert found.frame.tolist() == [2, 3, 4, 5, 6, 7]
    assert np.isnan(found.points[2:5]).all()
    np.testing.assert_array_equal(found.points[[0, 1, 5]], sparse.points)
    write_trc(tmp_path / "b.trc", found, 25.0)
    assert (tmp_path / "b.trc").read_text() == "\n".join(lines).replace("a.trc", "b.trc") + "\n"


def test_commas_names_and_axes_of_other_programs(tmp_path, random, body_trajectory):
    trajectory = body_trajectory(random, range(1, 4))
    write_trc(tmp_path / "a.trc", trajectory, 30.0)
    text = (tmp_path / "a.trc").read_text().replace("\t", ",")
    for name in LANDMARKS:
        side, _, part = name.partition("_")
        if part:
            text = text.replace(name, side[0].upper() + part.title().replace("Hand", "Wrist"))
    (tmp_path / "b.trc").write_text(text)
    wrists = {"LWrist": "left_hand", "RWrist": "right_hand"}
    found = read_trajectory(tmp_path / "b.trc", Stated(wrists))
    np.testing.assert_array_equal(found.points, trajectory.points)
    unnamed = read_trajectory(tmp_path / "b.trc").points[:, LANDMARKS.index("left_hand")]
    assert np.isnan(unnamed).all()
    turned = read_trajectory(tmp_path / "b.trc", Stated(wrists, world_from_axes("x,-z,y")))
    east, north, up = np.moveaxis(trajectory.points, -1, 0)
    np.testing.assert_array_equal(turned.points, np.stack([north, -east, up], axis=-1))


@pytest.mark.parametrize(("text", "words"), [("x,x,z", "three axes"), ("y,x,z", "mirror")])
def test_axes_that_are_none(text, words):
    with pytest.raises(InputError, match=words) as error:
        world_from_axes(text)
    assert error.value.remedy


def test_opensim_reads_it(tmp_path, random, body_trajectory, monkeypatch):
    opensim = pytest.importorskip("opensim")
    monkeypatch.chdir(tmp_path)  # where it keeps its log
    trajectory = body_trajectory(random, [3, 4, 6])
    trajectory.points[1, 0] = np.nan
    write_trc(tmp_path / "a.trc", trajectory, 10.0)
    table = opensim.TimeSeriesTableVec3(str(tmp_path / "a.trc"))
    assert table.getTableMetaDataString("Units") == "m"
    np.testing.assert_allclose(table.getIndependentColumn(), [0.3, 0.4, 0.5, 0.6])
    assert list(table.getColumnLabels()) == list(LANDMARKS)
    row = table.getRowAtIndex(1)
    assert np.isnan(row[0].to_numpy()).all()
    np.testing.assert_allclose(row[4].to_numpy(), trajectory.points[1, 4, [1, 2, 0]])
