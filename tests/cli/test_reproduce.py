"""``stereotrack reproduce``: what is kept, what is refused, and the short form as a whole."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.experiments.reproduction.pictures import shown_frames
from stereotrack_core.experiments.reproduction.plan import Places, PlannedRun, kept_run
from stereotrack_core.experiments.reproduction.runs import reference_poses
from stereotrack_core.experiments.reproduction.thesis import MOTIONS
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.folder import open_recording


@pytest.mark.parametrize(
    "words", [("--presets", "none-such"), ("--presets", ","), ("--seeds", "0"), ("--workers", "0")]
)
def test_what_cannot_be_is_said_before_anything_is_made(run, tmp_path, words):
    ended = run("reproduce", tmp_path / "new", *words)
    assert ended.status == 2
    assert ended.err.startswith("stereotrack: ")
    assert not (tmp_path / "new").exists()


@pytest.fixture
def kept(recording, tracked, tmp_path):
    """A run in its place, as the reproduction would have written it."""
    entry, places, opened = PlannedRun("fast"), Places(tmp_path), open_recording(recording)
    made = read_npz(tracked)
    stored = replace(made, meta={**made.meta, "way": entry.way})
    path = places.run(opened.name, entry)
    path.parent.mkdir(parents=True)
    write_npz(path, stored)
    return entry, places, opened, stored, path


def test_a_run_that_was_made_so_is_kept(kept):
    entry, places, opened, stored, path = kept
    print_ = stored.meta["fingerprint"]
    assert kept_run(places, opened, print_, entry) is not None
    assert kept_run(places, opened, "another recording", entry) is None
    assert kept_run(places, opened, print_, PlannedRun("fast", seed=1)) is None
    path.write_bytes(path.read_bytes()[:500])
    assert kept_run(places, opened, print_, entry) is None


def test_a_run_with_other_parameters_or_fewer_frames_is_made_anew(kept):
    entry, places, opened, stored, path = kept
    print_ = stored.meta["fingerprint"]
    parameters = {**stored.meta["parameters"], "data_points": 7}
    write_npz(path, replace(stored, meta={**stored.meta, "parameters": parameters}))
    assert kept_run(places, opened, print_, entry) is None
    fewer = replace(opened, reference=replace(opened.reference, frame=np.arange(9),
                                              points=opened.reference.points[:9]))  # fmt: skip
    write_npz(path, stored)
    assert kept_run(places, fewer, print_, entry) is None


def test_strips_show_the_moments_of_the_thesis():
    whip = MOTIONS[0]
    assert shown_frames(whip, Segment("whip", 1479, 1754)) == whip.frames
    short = shown_frames(whip, Segment("whip", 10, 21))
    assert (short[0], short[-1]) == (10, 20)
    assert list(short) == sorted(short)


def test_poses_to_begin_with_stand_where_segments_begin(recording):
    opened = open_recording(recording)
    poses = reference_poses(opened)
    assert set(poses) == {0, *(segment.first for segment in opened.segments)}
    hips = opened.reference.points[0, -2:].mean(axis=0)
    assert np.allclose(poses[0].position, hips)
    assert reference_poses(replace(opened, reference=None)) == {}


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_short_form_from_beginning_to_end(run, tmp_path):
    folder = tmp_path / "short"
    words = ("reproduce", folder, "--short", "--seeds", "1")
    ended = run(*words, "--json")
    assert ended.status == 0, ended.err
    tables = {table["table"]: table for table in ended.json["tables"]}
    assert list(tables) == ["4.1", "4.2", "4.3", "4.4", "fast", "motions"]
    for key in ("4.1", "4.2", "4.3", "4.4"):
        for row in tables[key]["rows"]:
            assert all(value is not None and np.isfinite(value) for value in row["mean"])
    sources = {row["source"] for row in tables["4.1"]["rows"]}
    assert sources == {
        *("the thesis", "preset thesis", "preset thesis, re-initialised", "accurate"),
    }
    page = (folder / "index.html").read_text("utf-8")
    assert "<script" not in page
    assert all(s.startswith(("data:", "#")) for s in re.findall(r'(?:src|href)="([^"]{0,9})', page))
    assert page.count("data:image/jpeg") == 8  # four motions, two presets
    assert {"table-4.1.csv", "tables.md", "figure-4.4.csv", "figure-4.12.svg"} <= {
        path.name for path in folder.iterdir()
    }
    made = json.loads((folder / "made.json").read_text("utf-8"))
    assert made["runs"] == made["wanted"] == 38
    _nothing_is_made_twice(run, folder, words)


def _nothing_is_made_twice(run, folder, words):
    runs = sorted(folder.glob("runs/*/*.npz"))
    before = {path: path.stat().st_mtime_ns for path in runs}
    anew = next(path for path in runs if "anew" in path.name)
    plain = next(path for path in runs if path.name == "thesis-seed0.npz")
    assert read_npz(anew).meta["started_at_reference"]
    assert read_npz(plain).meta["started_at_reference"] == []
    landmarks = read_npz(plain).landmarks
    plain.unlink()
    ended = run(*words, "--workers", "2")
    assert ended.status == 0, ended.err
    again = {path: path.stat().st_mtime_ns for path in sorted(folder.glob("runs/*/*.npz"))}
    assert [path for path in before if again[path] != before[path]] == [plain]
    assert np.array_equal(read_npz(plain).landmarks, landmarks, equal_nan=True)
