"""C3D files, also as ezc3d sees them."""

import struct

import ezc3d
import numpy as np
import pytest

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.c3d import write_c3d
from stereotrack_core.interop.landmark_file import Stated, world_from_axes
from stereotrack_core.interop.run_file import read_trajectory, write_run
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


def test_what_other_tools_see(tmp_path, random, make_run):
    run = make_run(random, range(17, 21))
    write_run(tmp_path / "a.c3d", run)
    file = ezc3d.c3d(str(tmp_path / "a.c3d"))
    point = file["parameters"]["POINT"]
    assert point["LABELS"]["value"] == list(LANDMARKS)
    assert point["UNITS"]["value"] == ["mm"]
    assert point["RATE"]["value"][0] == 10.0
    assert (point["X_SCREEN"]["value"], point["Y_SCREEN"]["value"]) == (["+X"], ["+Z"])
    assert file["header"]["points"]["first_frame"] == 17
    residuals = file["data"]["meta_points"]["residuals"][0]
    assert (residuals[:, 1] == -1).all()
    np.testing.assert_allclose(residuals[0, [0, 2, 3]], 1000 * run.residual[[0, 2, 3]], atol=1.0)
    hand = 1000 * run.landmarks[0, LANDMARKS.index("left_hand")]
    np.testing.assert_allclose(file["data"]["points"][:3, 4, 0], hand, atol=1e-3)


def test_gaps_are_missing(tmp_path, random, body_trajectory):
    sparse = body_trajectory(random, [2, 3, 7])
    write_c3d(tmp_path / "a.c3d", sparse, 25.0)
    found = read_trajectory(tmp_path / "a.c3d")
    assert found.fps == 25.0
    assert found.frame.tolist() == [2, 3, 4, 5, 6, 7]
    assert np.isnan(found.points[2:5]).all()
    np.testing.assert_allclose(found.points[[0, 1, 5]], sparse.points, atol=2e-7)


def _heads(path, frames, *, first=0, trial=False, long_frames=False):
    """Write a file in which the head rises by a millimetre a frame; the header as ezc3d has it."""
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [100.0], ["mm"]
    point["LABELS"]["value"] = ["head"]
    points = np.ones((4, 1, frames))
    points[2] = np.arange(frames)
    file["data"]["points"] = points
    file["header"]["points"]["first_frame"] = first
    if trial:
        for name, number in (("START", first + 1), ("END", first + frames)):
            words = [number & 0xFFFF, number >> 16]
            file.add_parameter("TRIAL", f"ACTUAL_{name}_FIELD", words)
    if long_frames:
        file.add_parameter("POINT", "LONG_FRAMES", [float(frames)])
    file.write(str(path))
    return path


def _set_words(path, **words):
    """Change numbers of 16 bits: those of the header and ``POINT:FRAMES``."""
    data = bytearray(path.read_bytes())
    places = {"first": 6, "last": 8, "FRAMES": data.index(b"FRAMES") + len("FRAMES") + 4}
    for name, value in words.items():
        data[places[name] : places[name] + 2] = value.to_bytes(2, "little")
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"trial": True}, {}),
        ({"long_frames": True}, {}),
        ({"trial": True}, {"last": 70_000 - 65_536, "FRAMES": 70_000 - 65_536}),
    ],
    ids=["TRIAL", "LONG_FRAMES", "TRIAL with wrapped header"],
)
def test_more_frames_than_16_bits_count(tmp_path, stated, words):
    path = _heads(tmp_path / "a.c3d", 70_000, **stated)
    _set_words(path, **words)
    found = read_trajectory(path)
    assert found.frame[[0, -1]].tolist() == [0, 69_999]
    height = found.points[:, LANDMARKS.index("head"), 2]
    np.testing.assert_allclose(height, 0.001 * np.arange(70_000), rtol=1e-6)
    assert found.notes[0].what.startswith(f"{counted(70_000, 'frame')} by ")


@pytest.mark.parametrize("last", [65_535, 70_000 - 65_536], ids=["stopped", "wrapped"])
def test_a_file_that_is_longer_than_it_counts_is_refused(tmp_path, last):
    path = _heads(tmp_path / "a.c3d", 70_000)
    _set_words(path, last=last, FRAMES=last)
    with pytest.raises(InputError, match="longer than the frames that it counts"):
        read_trajectory(path)


def test_long_and_late_stretches_are_written_whole(tmp_path, random, body_trajectory):
    some = body_trajectory(random, range(3))
    for frames in (range(65_530, 65_600), range(66_000)):
        frame = np.array(frames)
        written = LandmarkTrajectory(frame, some.points[frame % 3] + 1e-5 * frame[:, None, None])
        write_c3d(tmp_path / "a.c3d", written, 10.0)
        found = read_trajectory(tmp_path / "a.c3d")
        np.testing.assert_array_equal(found.frame, frame)
        np.testing.assert_allclose(found.points, written.points, atol=1e-6)


def test_a_header_that_the_file_contradicts(tmp_path):
    """As Optotrak's, which states 1149 frames and ends behind the 29th."""
    path = _heads(tmp_path / "a.c3d", 29)
    _set_words(path, last=1149)
    found = read_trajectory(path)
    assert found.frame.tolist() == list(range(29))
    assert found.notes[0].what == "29 frames by POINT:FRAMES; the header states 1149"
    _set_words(path, FRAMES=1149)
    with pytest.raises(InputError, match="ends before its last frame"):
        read_trajectory(path)


def test_a_start_and_a_rate_that_the_header_contradicts(tmp_path):
    path = _heads(tmp_path / "a.c3d", 20, first=500, trial=True)
    found = read_trajectory(path)
    assert (found.frame[0], found.fps) == (500, 100.0)
    assert not any("header" in note.what for note in found.notes)
    _set_words(path, first=1, last=20)  # frames of the file, not of the trial
    data = bytearray(path.read_bytes())
    data[20:24] = np.float32(50.0).tobytes()
    path.write_bytes(data)
    found = read_trajectory(path)
    assert found.frame.tolist() == list(range(500, 520))
    assert found.fps == 100.0
    rate, start = (note.what for note in found.notes[:2])
    assert rate == "100 frames per second by POINT:RATE; the header states 50"
    assert start == "begins at frame 501 by TRIAL:ACTUAL_START_FIELD; the header states 1"


def test_more_than_255_labels_and_points_without_one(tmp_path):
    names = [f"marker {k}" for k in range(300)]
    names[290], names[3] = "left_hip", "head"
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [50.0], ["m"]
    point["LABELS"]["value"] = names
    file["data"]["points"] = np.ones((4, 300, 2)) * np.arange(300)[None, :, None]
    file.write(str(tmp_path / "a.c3d"))
    found = read_trajectory(tmp_path / "a.c3d")
    assert (found.points[:, LANDMARKS.index("left_hip")] == 290.0).all()
    assert (found.points[:, LANDMARKS.index("head")] == 3.0).all()
    data = (tmp_path / "a.c3d").read_bytes().replace(b"LABELS2", b"LABELZ2")
    (tmp_path / "b.c3d").write_bytes(data)
    fewer = read_trajectory(tmp_path / "b.c3d")
    assert (fewer.points[:, LANDMARKS.index("head")] == 3.0).all()
    assert np.isnan(fewer.points[:, LANDMARKS.index("left_hip")]).all()
    assert fewer.notes[0].what == "45 points of 300 without a label left out"


def test_same_points_as_another_reader(tmp_path, random):
    """Other labels, analog channels, missing points: ezc3d writes and reads, we read."""
    file = ezc3d.c3d()
    names = ["ankle", *LANDMARKS[:4], "knee"]
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"], point["LABELS"]["value"] = [50.0], ["m"], names
    analog = file["parameters"]["ANALOG"]
    analog["RATE"]["value"], analog["LABELS"]["value"] = [200.0], ["force", "emg"]
    points = np.ones((4, 6, 12))
    points[:3] = random.normal(size=(3, 6, 12))
    points[:3, 2, 5] = np.nan
    file["data"]["points"] = points
    file["data"]["analogs"] = random.normal(size=(1, 2, 48))
    file["header"]["points"]["first_frame"] = 30
    file.write(str(tmp_path / "a.c3d"))
    found = read_trajectory(tmp_path / "a.c3d")
    assert found.fps == 50.0
    assert found.frame.tolist() == list(range(30, 42))
    np.testing.assert_allclose(found.points[:, :4], points[:3, 1:5].transpose(2, 1, 0), atol=1e-6)
    assert np.isnan(found.points[:, 4:]).all()


@pytest.mark.parametrize(
    ("right", "vertical", "axes"),
    [("+X", "+Z", "x,y,z"), ("+Z", "+Y", "z,x,y"), ("-X", "+Z", "-x,-y,z")],
)
def test_axes_follow_the_screen(tmp_path, random, body_trajectory, right, vertical, axes):
    trajectory = body_trajectory(random, range(3))
    path = tmp_path / "a.c3d"
    write_c3d(path, trajectory, 10.0)
    file = ezc3d.c3d(str(path))
    del file["data"]["meta_points"]
    turned = np.einsum("ji,jnf->inf", world_from_axes(axes), file["data"]["points"][:3])
    file["data"]["points"][:3] = turned
    file["parameters"]["POINT"]["X_SCREEN"]["value"] = [right]
    file["parameters"]["POINT"]["Y_SCREEN"]["value"] = [vertical]
    file.write(str(path))
    np.testing.assert_allclose(read_trajectory(path).points, trajectory.points, atol=1e-6)
    as_stated = read_trajectory(path, Stated(world_from_file=np.eye(3)))
    np.testing.assert_allclose(as_stated.points, turned.transpose(2, 1, 0) / 1000.0, atol=1e-6)


@pytest.mark.parametrize("floating", [True, False], ids=["floats", "integers"])
@pytest.mark.parametrize("processor", [85, 86], ids=["DEC", "MIPS"])
def test_files_of_other_processors(tmp_path, processor, floating):
    """Of DEC as ezc3d sees them, too; it reads none of MIPS."""
    path = tmp_path / "a.c3d"
    path.write_bytes(_file_of(processor, floating=floating))
    found = read_trajectory(path)
    assert found.fps == 50.0
    assert found.frame.tolist() == [6, 7]
    np.testing.assert_allclose(found.points[0, 0], [1.0, -0.25, 1.5], rtol=1e-6)
    np.testing.assert_allclose(found.points[1, 6], [0.0185, 0.02, 1.7], atol=3e-4)
    if processor != 85:
        return
    seen = ezc3d.c3d(str(path))["data"]["points"][:3] / 1000.0
    np.testing.assert_allclose(found.points[:, [0, 6]], seen.transpose(2, 1, 0), rtol=1e-6)


def _file_of(processor: int, *, floating: bool) -> bytes:
    """Two frames of two points, as an old system writes them: header, parameters, data."""
    order = ">" if processor == 86 else "<"

    def real(*values):
        if processor == 86:
            return struct.pack(f">{len(values)}f", *values)
        halves = np.array(values, "<f4") * np.float32(4.0)
        return halves.view("<u2").reshape(-1, 2)[:, ::-1].tobytes()

    def whole(*values):
        return struct.pack(f"{order}{len(values)}h", *values)

    def parameter(name, kind, sizes, content):
        body = bytes([kind & 255, len(sizes), *sizes]) + content + b"\0"
        head = struct.pack("bb", len(name), 1) + name.encode()
        return head + struct.pack(f"{order}H", 2 + len(body)) + body

    scale = -0.5 if floating else 0.5
    header = bytes([2, 0x50]) + whole(2, 0, 7, 8, 0) + real(scale) + whole(3, 0) + real(50.0)
    group = struct.pack("bb", 5, -1) + b"POINT" + struct.pack(f"{order}H", 3) + b"\0"
    parameters = bytes([1, 0x50, 1, processor]) + group
    parameters += parameter("USED", 2, (), whole(2))
    parameters += parameter("SCALE", 4, (), real(scale))
    parameters += parameter("RATE", 4, (), real(50.0))
    parameters += parameter("DATA_START", 2, (), whole(3))
    parameters += parameter("FRAMES", 2, (), whole(2))
    parameters += parameter("LABELS", -1, (14, 2), b"left_shoulder head          ")
    parameters += parameter("UNITS", -1, (4, 1), b"mm  ")
    points = [(1000.0, -250.0, 1500.0), (10.5, 20.0, 1700.0)]
    points += [(x + 8, y, z) for x, y, z in points]
    data = b""
    for point in points:
        data += real(*point, 0.0) if floating else whole(*(round(v / scale) for v in point), 0)
    return header.ljust(512, b"\0") + parameters.ljust(512, b"\0") + data.ljust(512, b"\0")
