"""``stereotrack import recording``: from videos to a recording that opens."""

from __future__ import annotations

import pytest

from stereotrack_core.recording.folder import open_recording
from tests.recording.importing.clips import clip, flashing, images


@pytest.fixture
def videos(tmp_path):
    for name in ("N_left", "N_right", "S"):
        clip(tmp_path / "videos" / f"{name}.mp4", frames=4)
    return tmp_path / "videos"


def test_a_folder_of_videos_becomes_a_recording(run, videos):
    ended = run("import", "recording", videos, "--json")
    assert ended.status == 0, ended.err
    assert ended.json["guessed"] is True
    assert "need a calibration" in ended.err
    recording = open_recording(videos)
    assert [(view.name, view.kind) for view in recording.views] == [("N", "stereo"), ("S", "mono")]
    assert recording.name == "videos"
    shown = run("info", videos)
    assert shown.status == 0
    assert "guessed from the size" in shown.out.replace("\n", " ") or "guessed" in shown.out


def test_a_dry_run_writes_nothing(run, videos):
    before = sorted(videos.iterdir())
    ended = run("import", "recording", videos, "--dry-run")
    assert ended.status == 0
    assert "left image of a stereo camera" in ended.out
    assert sorted(videos.iterdir()) == before


def test_what_sources_show_can_be_said(run, videos, tmp_path):
    out = tmp_path / "new"
    roles = ("--as", "N_left=mono:A", "--as", "N_right=unused", "--mirrored", "S")
    ended = run("import", "recording", videos, "-o", out, *roles, "--fps", "50", "--title", "t")
    assert ended.status == 0, ended.err
    recording = open_recording(out)
    assert [(view.name, view.kind) for view in recording.views] == [("A", "mono"), ("S", "mono")]
    assert (recording.name, recording.fps) == ("t", 50.0)


def test_the_unit_of_depth_is_said(run, tmp_path):
    images(tmp_path / "in" / "O_depth", depth=True)
    ended = run("import", "recording", tmp_path / "in", "--fps", "30", "--json")
    assert ended.status == 0, ended.err
    assert ended.json["depth_unit"] == 0.001
    assert "0.001 metres per count" in ended.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--as", "N_left=dancer"), "unknown role 'dancer'"),
        (("--as", "M=mono"), "there is no 'M'"),
        (("--as", "N_left"), "two names joined by ="),
        (("--mirrored", "Q"), "there is no 'Q'"),
        (("--camera", "Q=x"), "there is no 'Q'"),
        (("--as", "N_left=mono"), "the left image is missing"),
        (("--calibration", "nowhere.toml"), "nowhere.toml"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(run, videos, arguments, words):
    before = sorted(videos.iterdir())
    ended = run("import", "recording", videos, *arguments)
    assert ended.status == 2
    assert words in ended.err
    assert "Traceback" not in ended.err
    assert sorted(videos.iterdir()) == before


def test_offsets_are_estimated_or_given(run, tmp_path):
    for name, at in (("A", 9.0), ("B", 12.0)):
        clip(tmp_path / "in" / f"{name}.mp4", flashing(at), frames=20)
    ended = run("import", "recording", tmp_path / "in", "--synchronise", "flash", "--json")
    assert ended.status == 0, ended.err
    assert "synchronised by flash: B: +3" in ended.err
    assert [one["frames"] for one in ended.json["synchronised"]] == pytest.approx([0, 3], abs=0.1)
    streams = [view.image.first_frame for view in open_recording(tmp_path / "in").views]
    assert streams == [0, 3]
    by_hand = ("--first", "A=2", "-o", tmp_path / "out")
    assert run("import", "recording", tmp_path / "in" / "A.mp4", *by_hand).status == 0
    ended = run("import", "recording", tmp_path / "in", "--first", "A=x", "-o", tmp_path / "no")
    assert (ended.status, "'x' is no frame" in ended.err) == (2, True)


@pytest.mark.parametrize("kind", ["labels", "recording"])
def test_each_kind_of_import_has_its_help(run, kind):
    assert kind in run("import", "--help").out
    assert "--json" in run("import", kind, "--help").out
    assert run("import", "tracks").status == 2


def test_views_are_named_and_the_rest_is_not_used(run, videos):
    ended = run(
        "import", "recording", videos, "--view", "front=N_right,N_left", "--dry-run", "--json"
    )
    assert ended.status == 0, ended.err
    assert [(one["source"], one["role"]) for one in ended.json["sources"]] == [
        ("N_left", "right"),
        ("N_right", "left"),
        ("S", "unused"),
    ]
    ended = run("import", "recording", videos, "--view", "front=N_left,N_right,S")
    assert (ended.status, "the view front has 3 sources" in ended.err) == (2, True)


def test_a_bag_is_read_by_its_topics(run, tmp_path):
    pytest.importorskip("rosbags")
    from tests.recording.importing.bags import stereo_bag

    bag = stereo_bag(tmp_path / "walk.bag")
    listed = run("import", "recording", bag, "--dry-run", "-o", tmp_path / "out")
    assert listed.status == 0, listed.err
    assert "/stereo/left/image_raw" in listed.out
    assert run("import", "recording", bag).status == 2
    view = ("--view", "front=/stereo/left/image_raw,/stereo/right/image_raw")
    ended = run("import", "recording", bag, "-o", tmp_path / "out", *view)
    assert ended.status == 0, ended.err
    recording = open_recording(tmp_path / "out")
    assert ([view.name for view in recording.views], recording.guessed) == (["front"], True)
    calibration = []
    for side, aside in (("left", 0.0), ("right", -7.2)):  # as `topic echo` prints camera_info
        path = tmp_path / f"{side}.yaml"
        path.write_text(
            f"header:\n  frame_id: {side}\nheight: 48\nwidth: 64\ndistortion_model: plumb_bob\n"
            "d: [0.1, 0, 0, 0, 0]\nk: [60, 0, 31.5, 0, 60, 23.5, 0, 0, 1]\n"
            "r: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
            f"p: [60, 0, 31.5, {aside}, 0, 60, 23.5, 0, 0, 0, 1, 0]\n---\n"
        )
        calibration += ["--calibration", path]
    ended = run("import", "recording", bag, "-o", tmp_path / "known", *view, *calibration)
    assert ended.status == 0, ended.err
    recording = open_recording(tmp_path / "known")
    assert not recording.guessed
    assert recording.cameras["right"].position_world == pytest.approx([0.12, 0, 0])


def test_a_calibration_of_another_tool_is_read(run, tmp_path):
    for name in ("left", "right"):
        clip(tmp_path / "in" / f"{name}.mp4", frames=2)
    theirs = tmp_path / "theirs.toml"
    theirs.write_text(
        "".join(
            f'[cam_{k}]\nname = "{name}"\nsize = [64, 48]\n'
            "matrix = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]\n"
            "distortions = [0.0, 0.0, 0.0, 0.0, 0.0]\nrotation = [0.0, 0.0, 0.0]\n"
            f"translation = [{-120.0 * k}, 0.0, 0.0]\n"
            for k, name in enumerate(("left", "right"))
        )
    )
    ask = ("import", "recording", tmp_path / "in", "--calibration", theirs, "-o", tmp_path / "out")
    ended = run(*ask, "--units", "mm")
    assert ended.status == 0, ended.err
    assert "unit mm: given with --units" in ended.err
    recording = open_recording(tmp_path / "out")
    assert not recording.guessed
    right = recording.cameras[recording.views[0].image.camera]
    assert right.position_world == pytest.approx([0.12, 0, 0])
