"""``stereotrack import recording``: from videos to a recording that opens."""

import pytest

from stereotrack_core.recording.folder import open_recording
from tests.recording.importing.clips import clip, flashing


@pytest.fixture
def videos(tmp_path):
    for name in ("N_left", "N_right", "S"):
        clip(tmp_path / "videos" / f"{name}.mp4", frames=4)
    return tmp_path / "videos"


def test_a_folder_of_videos_becomes_a_recording(run, videos):
    ended = run("import", "recording", videos, "--json")
    assert ended.json["guessed"] is True
    assert "need a calibration" in ended.err
    recording = open_recording(videos)
    assert [(view.name, view.kind) for view in recording.views] == [("N", "stereo"), ("S", "mono")]
    assert recording.name == "videos"
    shown = run("info", videos)
    assert "guessed from the size" in shown.out.replace("\n", " ") or "guessed" in shown.out


def test_a_dry_run_writes_nothing(run, videos):
    before = sorted(videos.iterdir())
    assert "left image of a stereo camera" in run("import", "recording", videos, "--dry-run").out
    assert sorted(videos.iterdir()) == before


def test_what_sources_show_can_be_said(run, videos, tmp_path):
    out = tmp_path / "new"
    roles = ("--view", "A=N_left", "--view", "S=S", "--mirrored", "S")
    run("import", "recording", videos, "-o", out, *roles, "--fps", "50", "--title", "t")
    recording = open_recording(out)
    assert [(view.name, view.kind) for view in recording.views] == [("A", "mono"), ("S", "mono")]
    assert (recording.name, recording.fps) == ("t", 50.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("--view", "A=M"), "there is no 'M'"), (("--calibration", "nowhere.toml"), "nowhere.toml")],
)
def test_what_does_not_fit_is_refused_in_a_sentence(run, videos, arguments, words):
    before = sorted(videos.iterdir())
    assert words in run("import", "recording", videos, *arguments, status=2).err
    assert sorted(videos.iterdir()) == before


def test_offsets_are_estimated_or_given(run, tmp_path):
    for name, at in (("A", 9.0), ("B", 12.0)):
        clip(tmp_path / "in" / f"{name}.mp4", flashing(at), frames=20)
    ended = run("import", "recording", tmp_path / "in", "--synchronise", "flash", "--json")
    assert "synchronised by flash: B: +3" in ended.err
    assert [one["frames"] for one in ended.json["synchronised"]] == pytest.approx([0, 3], abs=0.1)
    streams = [view.image.first_frame for view in open_recording(tmp_path / "in").views]
    assert streams == [0, 3]
    by_hand = ("--first", "A=2", "-o", tmp_path / "out")
    run("import", "recording", tmp_path / "in" / "A.mp4", *by_hand)
    by_hand = ("--first", "A=x", "-o", tmp_path / "no")
    ended = run("import", "recording", tmp_path / "in", *by_hand, status=2)
    assert "'x' is no frame" in ended.err
