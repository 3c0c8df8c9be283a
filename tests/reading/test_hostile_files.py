"""Files that are none, have no end or are nested without one: a sentence at once, and no memory."""

from __future__ import annotations

import io
import json
import os
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.reading import parsed_json
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.images import DamagedFrame, read_image, read_metres
from stereotrack_core.recording.importing.ros import picture_in
from stereotrack_core.recording.importing.source import METRIC_UNIT
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.recording.video import open_container
from stereotrack_core.recording.writing import write_png
from tests.reading.samples import FRAMES, made_video


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _endless(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 42)


def _loop(path: Path) -> None:
    path.symlink_to(path)


NO_FILES: dict[str, Callable[[Path], None]] = {
    "named pipe": _pipe,
    "device": _device,
    "sparse file of 4 TB": _endless,
    "folder": Path.mkdir,
    "link to itself": _loop,
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
    program = (
        "import stereotrack_core, cv2, numpy as np, zlib\n"
        "def chunk(kind, data):\n"
        "    sum = zlib.crc32(kind + data).to_bytes(4, 'big')\n"
        "    return len(data).to_bytes(4, 'big') + kind + data + sum\n"
        "size = 2 * (30_000).to_bytes(4, 'big') + bytes([8, 0, 0, 0, 0])\n"
        "png = b'\\x89PNG\\r\\n\\x1a\\n' + chunk(b'IHDR', size)\n"
        "png += chunk(b'IDAT', zlib.compress(bytes(100_000))) + chunk(b'IEND', b'')\n"
        "try:\n"
        "    cv2.imdecode(np.frombuffer(png, np.uint8), 0)\n"
        "except cv2.error as error:\n"
        "    print(error)\n"
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
        message = SimpleNamespace(data=np.frombuffer(content, np.uint8), format="png")
        with pytest.raises(DamagedFrame, match="compressed image is damaged"):
            picture_in(message, "grey", METRIC_UNIT)


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


def _array(values) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def _mmpose(**frame) -> bytes:
    places = {"keypoints": [[3.0, 4.0]] * 17, "keypoint_scores": [0.5] * 17}
    frame = {"instances": [places], **frame}
    return json.dumps({"meta_info": {}, "instance_info": [frame]}).encode()


def _coco(values) -> bytes:
    content = {
        "images": [{"id": 5, "file_name": "S/000002.png"}],
        "annotations": [{"id": 1, "image_id": 5, "category_id": 1, "keypoints": values}],
        "categories": [{"id": 1, "keypoints": ["nose"]}],
    }
    return json.dumps(content).encode()


def _result(values) -> bytes:
    return json.dumps([{"image_id": 2, "keypoints": values, "score": 1.0}]).encode()


DEEPLABCUT = b"scorer,a,a\nbodyparts,head,head\ncoords,x,y\n0,1.5,2.5\n"

REFUSED = {
    "no frame_id": ("keypoints, MMPose", _mmpose(), "has no frame_id"),
    "a list in a list of COCO": ("keypoints, COCO", _coco([[1, 2, [3]]]), "not a finite number"),
    "a list in a result": ("keypoints, COCO results", _result([[1, 2, []]]), "not a finite number"),
    "a short line": (
        "keypoints, DeepLabCut",
        DEEPLABCUT.replace(b"coords,x,y", b"coords,x"),
        "not equally long",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_a_sentence(case, catalogue, tmp_path):
    name, content, words = REFUSED[case]
    reader = catalogue[name]
    (tmp_path / reader.file).write_bytes(content)
    with pytest.raises(InputError, match=words) as refused:
        reader.read(tmp_path / reader.file)
    assert refused.value.remedy


def test_a_point_without_a_name_is_one_that_is_not_known(catalogue, tmp_path):
    reader = catalogue["keypoints, MMPose"]
    content = json.loads(_mmpose(frame_id=1))
    content["meta_info"]["keypoint_id2name"] = {"0": "nose", "1": None}
    (tmp_path / reader.file).write_text(json.dumps(content))
    told, count = reader.read(tmp_path / reader.file)
    assert count == 1
    assert told.startswith("16 of keypoints that are no part")
