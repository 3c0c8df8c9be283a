"""Recordings that cannot be used: every command says the same one sentence and ends with 2."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import FAST
from tests.end_to_end.damage import substitute

LEFT, CALIBRATION, DESCRIPTION = "N_left.mp4", "calibration.toml", "recording.toml"
WIDTH_AND_HEIGHT = r"320,\s*240"
MATRIX = r"matrix = \[[^=]*?\]\s*,\s*\]"
TRANSPOSED = "matrix = [[200.0, 0.0, 0.0], [0.0, 200.0, 0.0], [159.5, 119.5, 1.0]]"


def _cut(folder: Path) -> None:
    os.truncate(folder / LEFT, (folder / LEFT).stat().st_size // 2)


def _loop(folder: Path) -> None:
    (folder / LEFT).unlink()
    (folder / LEFT).symlink_to(folder / LEFT)


def _in_toml(file: str, pattern: str, text: str) -> Callable[[Path], None]:
    return lambda folder: substitute(folder / file, pattern, text)


def _decimal_commas(folder: Path) -> None:
    text = (folder / "reference.csv").read_text()
    (folder / "reference.csv").write_text(text.replace(".", ","))


DAMAGES: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "truncated video": (_cut, (LEFT, "left.frames", "Copy it again")),
    "missing video": (lambda f: (f / LEFT).unlink(), (LEFT, "left.frames", "not found")),
    "links in a circle": (_loop, (LEFT, "circle")),
    "not a video": (lambda f: (f / LEFT).write_text("hello"), (LEFT, "cannot be opened")),
    "wrong size": (
        _in_toml(CALIBRATION, WIDTH_AND_HEIGHT, "640, 480"),
        (LEFT, "320 x 240", "640 x 480"),
    ),
    "focal length NaN": (_in_toml(CALIBRATION, r"200\.0", "nan"), ("matrix", "not finite")),
    "singular matrix": (_in_toml(CALIBRATION, r"200\.0", "0.0"), ("matrix", "singular")),
    "transposed matrix": (_in_toml(CALIBRATION, MATRIX, TRANSPOSED), ("matrix", "transposed")),
    "no units": (_in_toml(CALIBRATION, r"units = .*\n", ""), ("units", 'units = "m"')),
    "broken TOML": (_in_toml(DESCRIPTION, r"fps = .*", "fps ="), (DESCRIPTION, "line")),
    "no rate": (_in_toml(DESCRIPTION, r"fps = .*", "fps = 0"), ("fps", "fps > 0")),
    "lengths as texts": (
        _in_toml("subject.toml", r"hip_width = .*", 'hip_width = "0.3"'),
        ("subject.toml", "hip_width"),
    ),
    "decimal commas": (_decimal_commas, ("reference.csv", "line 2", "decimal points")),
    "pattern without files": (
        _in_toml(DESCRIPTION, rf'frames = "{LEFT}"', 'frames = "N/%06d.png"'),
        ("left.frames", "'N'"),
    ),
    "outside of the folder": (
        _in_toml(DESCRIPTION, rf'frames = "{LEFT}"', f'frames = "../{LEFT}"'),
        ("left.frames", "leaves the recording folder"),
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_one_sentence_names_file_key_and_remedy(damage, copy, tmp_path, run):
    harm, words = DAMAGES[damage]
    harm(copy)
    tracked = run("track", copy, "-o", tmp_path / "run.npz", "--preset", "fast")
    sentence = tracked.sentence
    assert all(word in sentence for word in words), sentence
    assert run("cloud", copy, "--frame", 0, "-o", tmp_path / "c.ply").sentence == sentence
    assert not (tmp_path / "run.npz").exists()
    assert not (tmp_path / "c.ply").exists()
    told = run("info", copy, "--json")
    assert told.status == 2
    errors = [f for f in told.json["findings"] if f["severity"] == "error"]
    assert any(error["what"] in sentence for error in errors)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="everything may be read here")
def test_files_that_may_not_be_read(copy, tmp_path, run):
    (copy / CALIBRATION).chmod(0)
    assert "may read it" in run("info", copy, "--json").json["findings"][0]["remedy"]
    assert "Permission denied" in run("track", copy, "-o", tmp_path / "run.npz").sentence


def test_places_that_cannot_be_written(sound, tmp_path, run):
    link = tmp_path / "link"
    link.symlink_to(sound)
    places = {
        tmp_path / "no" / "run.npz": "no such folder",
        sound / "run.npz": "never written to",
        link / "run.npz": "never written to",
        tmp_path: "this is a folder",
        tmp_path / "run.txt": ".npz",
    }
    for place, word in places.items():
        assert word in run("track", sound, "-o", place).sentence


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--frames=5:400",), "0:10"),
        (("--frames=4:4",), "--frames"),
        (("--frames=a:b",), "--frames"),
        (("--views", "NX"), "N, S"),
        (("--views", ""), "N, S"),
        (("--preset", "quick"), "accurate"),
        (("--set", "model_points=many"), "model_points"),
        (("--seed", "-1"), "--seed"),
        (("--init", "elsewhere.npz"), "elsewhere.npz"),
    ],
)
def test_options_that_cannot_be_used(arguments, word, sound, tmp_path, run):
    assert word in run("track", sound, "-o", tmp_path / "run.npz", *arguments).sentence
    assert not (tmp_path / "run.npz").exists()


def test_a_recording_is_left_as_it_was(sound, tmp_path, run):
    before = {path.name: path.stat().st_mtime_ns for path in sound.iterdir()}
    awkward = tmp_path / "mit Leerzeichen und Ümläuten"
    shutil.copytree(sound, awkward)
    place = awkward.parent / "ä ö.npz"
    assert run("track", awkward, "-o", place, *FAST, "--frames=:3").status == 0
    assert run("evaluate", place, "--frames=:3").status == 0
    assert {path.name: path.stat().st_mtime_ns for path in sound.iterdir()} == before
    assert {path.name for path in awkward.iterdir()} == set(before)
