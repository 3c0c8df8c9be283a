"""Files that are none, have no end or are nested without one: a sentence at once, and no memory."""

import io
import json
import os
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.reading import parsed_json
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.images import DamagedFrame, read_image, read_metres
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.recording.video import open_container
from stereotrack_core.recording.writing import write_png
from tests.reading.samples import FRAMES, made_video

NO_FILES: dict[str, Callable[[Path], object]] = {
    "named pipe": lambda path: os.mkfifo(path),
    "device": lambda path: path.symlink_to("/dev/zero"),
    "sparse file of 4 TB": lambda path: (path.touch(), os.truncate(path, 1 << 42)),
    "folder": Path.mkdir,
    "link to itself": lambda path: path.symlink_to(path),
    "nothing": lambda path: None,
}


@pytest.mark.skipif(sys.platform == "win32", reason="needs named pipes and devices")
@pytest.mark.parametrize("kind", NO_FILES)
def test_what_is_no_file_is_refused_at_once(kind, catalogue, tmp_path, little_memory):
    for name, reader in catalogue.items():
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        NO_FILES[kind](folder / reader.file)
        try:
            with little_memory():
                reader.read(folder / reader.file)
        except InputError as refusal:
            assert "memory" not in str(refusal), name  # noqa: PT017 - others need not refuse it


@pytest.mark.skipif(sys.platform == "win32", reason="needs named pipes and devices")
@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("named pipe", "this is a named pipe"),
        ("device", "this is a device"),
        ("sparse file of 4 TB", "more than 4 MB"),
        ("link to itself", "cannot be read"),
        ("nothing", "no such file"),
    ],
)
def test_the_sentence_says_what_it_is(kind, words, tmp_path):
    NO_FILES[kind](tmp_path / "s.toml")
    with pytest.raises(InputError, match=words) as refusal:
        load_toml(tmp_path / "s.toml")
    assert refusal.value.where == str(tmp_path / "s.toml")
    assert refusal.value.remedy


DEEP = 3000


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"a = {'[' * DEEP}{']' * DEEP}", "nested too deeply"),
        (f"{'a.' * DEEP}b = 1", "nested too deeply"),
        ("\n".join(f"{'a.' * 30}b{i} = {{c.d.e.f = 1}}" for i in range(2)), "nested too deeply"),
        (f"[view]\nfps = {'9' * 400}", r"view\.fps: a number of about 400 digits is too large"),
        (f"fps = {'9' * 5000}", "a number is too large"),
    ],
)
def test_toml_without_end(tmp_path, text, words):
    path = tmp_path / "recording.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as refusal:
        load_toml(path)
    assert refusal.value.where.startswith(str(path))
    complaints: list[InputError] = []
    assert describe(tmp_path, complaints) is None
    assert len(complaints) == 1


def test_what_people_write_is_not_without_end(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(
        "a.b.c = [[1.5, 2.5, -3.0], [1e300, nan, inf]]\n"
        + f"text = '{'a.' * DEEP}'\nmany = [{'1.5, ' * DEEP}]\nlong = [{'[1, 2], ' * DEEP}]\n"
    )
    assert len(load_toml(path)["many"]) == DEEP


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * DEEP * 100, "nested too deeply"),
        ('{"a": [1, ' + "9" * 400 + "]}", r"a\[1\]: a number of about 400 digits"),
        ("9" * 5000, "a number is too large"),
        ("{", "not valid JSON"),
        (r'{"a": ["x", "\ud800"]}', r"a\[1\]: a text contains invalid characters"),
    ],
)
def test_json_without_end(text, words):
    with pytest.raises(InputError, match=words):
        parsed_json(text, "x.json")


def test_a_picture_may_not_unfold_into_any_number_of_pixels():
    """Asked in a process of its own: OpenCV takes its limit when it is loaded."""
    size = 2 * (30_000).to_bytes(4, "big") + bytes([8, 0, 0, 0, 0])
    parts = {b"IHDR": size, b"IDAT": zlib.compress(bytes(100_000)), b"IEND": b""}
    png = b"\x89PNG\r\n\x1a\n"
    for kind, data in parts.items():
        sum_of_part = zlib.crc32(kind + data).to_bytes(4, "big")
        png += len(data).to_bytes(4, "big") + kind + data + sum_of_part
    program = (
        "import stereotrack_core, cv2, numpy as np\n"
        f"try: cv2.imdecode(np.frombuffer({png!r}, np.uint8), 0)\n"
        "except cv2.error as error: print(error)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert "CV_IO_MAX_IMAGE_PIXELS" in ended.stdout
    assert ended.stderr == ""


def test_a_part_of_a_picture_may_not_be_longer_than_its_file(tmp_path, monkeypatch):
    """OpenCV makes room for what a part claims before it reads it."""
    path, picture = tmp_path / "i.png", np.arange(600, dtype=np.uint8).reshape(20, 30)
    write_png(path, picture)
    whole = path.read_bytes()
    path.write_bytes(whole + b"\xff" * 100)  # what comes after the end is nobody's concern
    assert np.array_equal(read_image(path, "grey"), picture)
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was given to OpenCV"))
    longer = [
        whole[:at] + b"\x60\xff\xff\xff" + whole[at + 4 :]
        for at in (whole.index(b"IDAT") - 4, whole.index(b"IEND") - 4)
    ]
    for content in (*longer, whole[:-12], whole[:20]):
        path.write_bytes(content)
        with pytest.raises(DamagedFrame, match=r"i\.png is damaged"):
            read_image(path, "grey")
        with pytest.raises(DamagedFrame, match="no depth map of 32-bit floats"):
            read_metres(path)


@pytest.mark.skipif(sys.platform == "win32", reason="FFmpeg keeps its own limit there")
def test_a_video_may_not_ask_for_all_memory(tmp_path):
    """FFmpeg makes room for a title before it reads it, and reads on where there is none."""
    path = tmp_path / "v.avi"
    whole = made_video(path, "mjpeg", "yuvj420p")
    most = 0x60000000
    title = struct.pack("<4sI4s4sI", b"LIST", most + 16, b"INFO", b"ISFT", most)
    at = whole.index(b"movi") - 8
    path.write_bytes(whole[:at] + title + whole[at:])
    with open_container(path) as container:
        assert len(list(container.decode(video=0))) == FRAMES


def refusal_of(reader, content: bytes, folder: Path) -> InputError:
    (folder / reader.file).write_bytes(content)
    with pytest.raises(InputError) as refusal:
        reader.read(folder / reader.file)
    assert refusal.value.remedy
    assert refusal.value.where.startswith(str(folder))
    return refusal.value


CHANGES: dict[str, tuple[str, Callable[[Any], object], str]] = {
    "no frame_id": (
        "keypoints, MMPose", lambda tree: tree["instance_info"][0].pop("frame_id"),
        "has no frame_id",
    ),
    "a list in a list of COCO": (
        "keypoints, COCO", lambda tree: tree["annotations"][0].update(keypoints=[[1, 2, [3]]]),
        "not a finite number",
    ),
    "a list in a result": (
        "keypoints, COCO results", lambda tree: tree[0].update(keypoints=[[1, 2, []]]),
        "not a finite number",
    ),
}  # fmt: skip


def changed(reader, change) -> bytes:
    tree = json.loads(reader.content)
    change(tree)
    return json.dumps(tree).encode()


@pytest.mark.parametrize("case", CHANGES)
def test_refused_in_a_sentence(case, catalogue, tmp_path):
    name, change, words = CHANGES[case]
    found = refusal_of(catalogue[name], changed(catalogue[name], change), tmp_path)
    assert words in str(found)


def test_a_short_line_is_refused(catalogue, tmp_path):
    short = b"scorer,a,a\nbodyparts,head,head\ncoords,x\n0,1.5,2.5\n"
    found = refusal_of(catalogue["keypoints, DeepLabCut"], short, tmp_path)
    assert "not equally long" in str(found)


def test_a_point_without_a_name_is_one_that_is_not_known(catalogue, tmp_path):
    reader = catalogue["keypoints, MMPose"]
    names = {"keypoint_id2name": {"0": "nose", "1": None}}
    content = changed(reader, lambda tree: tree.update(meta_info=names))
    (tmp_path / reader.file).write_bytes(content)
    told, count = reader.read(tmp_path / reader.file)
    assert count == 2
    assert told.startswith("32 of keypoints that are no part")


LARGE = 400_000_000  # rows that are stated and have no byte in the file: 20 GB


def changed_hdf5(content: bytes, change) -> bytes:
    import h5py

    file = io.BytesIO(content)
    with h5py.File(file, "r+") as stored:
        change(stored)
    return file.getvalue()


def without_end(stored) -> None:
    """People of SLEAP whose rows are stated only."""
    kind = stored["instances"].dtype
    del stored["instances"]
    stored.create_dataset("instances", shape=(LARGE,), chunks=(1000,), dtype=kind)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is not limited there")
@pytest.mark.parametrize("name", ["SLEAP"])
def test_rows_without_end_do_not_take_the_memory(reader, tmp_path):
    content = changed_hdf5(reader.content, without_end)
    assert len(content) < 200_000
    assert "too large for the memory" in refusal_of(reader, content, tmp_path).what
