"""Recordings that are damaged in part: tracked where possible, and never without a sign."""

import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.program import main
from tests.conftest import FAST, QUICK, SMALL
from tests.end_to_end.conftest import DENSE, FRAMES
from tests.end_to_end.damage import pictures_of, substitute, write_pictures

PAIR = ("N_left", "N_right")
CAMERAS = (*PAIR, "S_left", "S_right")
DARK = range(5, 9)


def _darken(folder: Path, cameras: tuple[str, ...], frames: range) -> None:
    for camera in cameras:
        path = folder / f"{camera}.mp4"
        pictures = pictures_of(path)
        write_pictures(path, [p * 0 if k in frames else p for k, p in enumerate(pictures)])


def _as_numbered_images(folder: Path, camera: str) -> Path:
    images = folder / camera
    images.mkdir()
    for k, picture in enumerate(pictures_of(folder / f"{camera}.mp4")):
        cv2.imwrite(str(images / f"{k:06d}.png"), picture)
    substitute(folder / "recording.toml", rf'"{camera}\.mp4"', f'"{camera}/%06d.png"')
    return images


def _stretches(told, view):
    return [(s["first"], s["end"]) for s in told.json["blind_views"] if s["view"] == view]


@pytest.mark.parametrize("preset", ["fast", pytest.param("thesis", marks=pytest.mark.slow)])
def test_a_view_that_goes_dark_is_told_and_the_others_go_on(preset, copy, tmp_path, run):
    _darken(copy, PAIR, DARK)
    quick = (*FAST, *(DENSE if preset == "thesis" else ()), "--preset", preset)
    told = run("track", copy, "-o", tmp_path / "run.npz", *quick, "--json")
    assert told.status == 0
    assert _stretches(told, "N") == [(DARK.start, DARK.stop)]
    assert _stretches(told, "S") == []
    assert read_run(tmp_path / "run.npz").meta["blind"] == told.json["blind_views"]
    assert any("dark" in f["what"] for f in run("info", copy, "--deep", "--json").json["findings"])


@pytest.mark.parametrize("preset", ["fast", "thesis"])
def test_nothing_is_tracked_where_nothing_is_seen(preset, copy, tmp_path, run):
    _darken(copy, CAMERAS, range(FRAMES))
    chosen = ("--preset", preset, "--set", "least_focal=0")
    told = run("track", copy, "-o", tmp_path / "run.npz", *chosen, "--json")
    assert told.status == 1
    assert told.json["tracked"] == 0
    assert f"No person was tracked in any of the {FRAMES} frames." in told.err
    assert "dark" in told.err
    [cause] = told.json["untracked_because"]
    assert cause["views"] == ["N", "S"]
    summary = run("evaluate", tmp_path / "run.npz")
    assert summary.status == 0
    assert "500.0" in summary.out
    cloud = run("cloud", copy, "--frame", 3, "-o", tmp_path / "c.ply", "--json").json
    assert cloud["points"] == 0
    assert set(cloud["problems"]) == {"N", "S"}


@pytest.mark.parametrize(
    ("option", "word"),
    [
        ("disparity_minimum=300", "disparity_minimum=300"),
        ("outlier_distance=0.5", "outlier_distance"),
    ],
)
def test_the_step_that_took_the_points_is_named(option, word, sound, tmp_path, run):
    place = tmp_path / "run.npz"
    quick = (*QUICK, "--frames", "0:4", "--despite-errors")
    told = run("track", sound, "-o", place, *quick, "--set", option)
    assert told.status == 1
    assert "No person was tracked" in told.err
    assert word in told.err.partition("No person was tracked")[2]


def test_a_run_of_nothing_replaces_no_other(sound, whole, tmp_path, run):
    place = Path(shutil.copy(whole, tmp_path / "run.npz"))
    told = run("track", sound, "-o", place, *QUICK, "--set", "volume_centre_x=40")
    assert told.status == 1
    assert "was not changed" in told.err
    assert place.read_bytes() == whole.read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == [place.name]


def test_overwritten_bytes_are_told_by_frame(copy, tmp_path, run):
    path = copy / "N_left.mp4"
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 6000] = np.random.default_rng(4).bytes(6000)
    path.write_bytes(content)
    told = run("track", copy, "-o", tmp_path / "run.npz", *FAST, "--json")
    assert told.status == 0
    assert told.json["frames"] == FRAMES
    blind = _stretches(told, "N")
    assert blind
    assert all(0 < first < end <= FRAMES for first, end in blind)


def test_images_that_are_missing_or_damaged_are_told_by_frame(copy, tmp_path, run):
    for camera in PAIR:
        images = _as_numbered_images(copy, camera)
    for k in (3, 4):
        (copy / "N_left" / f"{k:06d}.png").unlink()
    (images / "000007.png").write_bytes(b"garbage")
    cv2.imwrite(str(images / "000009.png"), np.zeros((10, 10), np.uint8))
    told = run("track", copy, "-o", tmp_path / "run.npz", *FAST, "--json")
    assert _stretches(told, "N") == [(3, 5), (7, 8), (9, 10)]
    assert "warning" in told.err
    assert "missing" in told.err


def test_a_shorter_stream_is_told_and_the_common_frames_are_used(copy, tmp_path, run):
    write_pictures(copy / "N_left.mp4", pictures_of(copy / "N_left.mp4")[:7])
    told = run("track", copy, "-o", tmp_path / "run.npz", *FAST, "--json")
    assert told.json["frames"] == 7
    assert "different lengths" in told.err
    scored = run("evaluate", tmp_path / "run.npz", "--json")
    assert f"lacks {FRAMES - 7} of the {FRAMES} frames" in scored.err


@pytest.mark.parametrize(
    ("file", "pattern", "text", "word"),
    [
        ("calibration.toml", r"distortions = \[[^]]*\]", "distortions = [50, -900, 0, 0]", "fold"),
        ("subject.toml", r"hip_width = .*", "hip_width = 220.0", "not a body length"),
        ("segments.csv", r",10", ",400", "400"),
        ("calibration.toml", r'units = "m"', 'units = "mm"', "mm tall"),
    ],
)
def test_what_looks_wrong_is_said_before_tracking(file, pattern, text, word, copy, tmp_path, run):
    substitute(copy / file, pattern, text)
    assert word in run("info", copy).out.replace("\n", " ")
    place = tmp_path / "run.npz"
    told = run("track", copy, "-o", place, *FAST, "--frames", "0:2")
    assert word in told.err or told.status == 2


def _spoilt(place: Path, **changes) -> None:
    with np.load(place) as stored:
        content = {name: stored[name] for name in stored.files}
    np.savez(place, **(content | changes))


@pytest.mark.parametrize("damage", ["cut", "foreign", "empty", "meta", "frames"])
def test_runs_that_are_damaged_are_refused(damage, sound, whole, tmp_path, run):
    place = shutil.copy(whole, tmp_path / "run.npz")
    content = place.read_bytes()
    match damage:
        case "cut":
            place.write_bytes(content[: len(content) // 2])
        case "foreign":
            place.write_text("hello")
        case "empty":
            place.write_bytes(b"")
        case "meta":
            _spoilt(place, meta=np.array("{"))
        case "frames":
            _spoilt(place, frame=np.arange(FRAMES)[::-1])
    assert str(place) in run("evaluate", place).sentence
    assert str(place) in run("track", sound, "-o", tmp_path / "b.npz", "--init", place).sentence


@pytest.fixture(scope="module")
def four_views(tmp_path_factory) -> Path:
    """A rendered recording of four stereo views."""
    folder = tmp_path_factory.mktemp("misfit") / "sound"
    assert main(["simulate", str(folder), "--frames", "6", "--motion", "t-pose", *SMALL]) == 0
    return folder


@pytest.fixture(scope="module")
def exchanged(four_views) -> Path:
    """The same with the cameras of two views exchanged."""
    folder = shutil.copytree(four_views, four_views.with_name("exchanged"))
    description, other = folder / "recording.toml", {"N": "O", "O": "N"}
    description.write_text(
        re.sub('(?<=camera = ")[NO]', lambda found: other[found[0]], description.read_text())
    )
    return folder


def tracked(run, folder, place):
    told = run("track", folder, "-o", place, *FAST, "--json")
    assert told.status == 0
    assert read_run(place).meta["warnings"] == told.json["warnings"]
    return told


def test_two_views_that_are_exchanged_are_warned_of(exchanged, tmp_path, run):
    told = tracked(run, exchanged, tmp_path / "run.npz")
    [warning] = [one for one in told.json["warnings"] if "the views are inconsistent" in one]
    assert f"warning: {warning}. Look for the cause" in told.err
    assert "stereotrack info --deep" in told.err


def test_sound_views_are_not(four_views, tmp_path, run):
    told = tracked(run, four_views, tmp_path / "run.npz")
    assert told.json["warnings"] == []
    assert "warning" not in told.err
