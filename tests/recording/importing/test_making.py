"""Recordings that are made of videos and images: right frames, right sides, sources untouched."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.importing.choices import problems_of
from stereotrack_core.recording.importing.making import cameras_for, make_recording
from stereotrack_core.recording.importing.proposing import possible_units
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.work import Work
from tests.recording.importing import clips


def content(folder):
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_folder_of_videos_becomes_a_recording_where_it_is(tmp_path):
    clips.clip(tmp_path / "N_left.mp4")
    clips.clip(tmp_path / "N_right.mp4", lambda k: clips.numbered(k) + 5)
    before = content(tmp_path)
    recording = make_recording(clips.chosen(tmp_path), tmp_path)
    after = content(tmp_path)
    assert {path: after[path] for path in before} == before
    new = {path.name for path in set(after) - set(before)}
    assert new == {"recording.toml", "calibration.toml"}
    assert recording.fps == 25.0
    (view,) = recording.views
    assert view.kind == "stereo"
    assert (view.image.frames, view.left.frames) == ("N_right.mp4", "N_left.mp4")
    shown = clips.frames_of(recording)[3]["N"]
    assert shown.left[0, 0] == clips.numbered(3)[0, 0]
    assert shown.image[0, 0] == clips.numbered(3)[0, 0] + 5


def test_a_guessed_calibration_says_so_and_nothing_is_computed_with_it(tmp_path):
    clips.clip(tmp_path / "N_left.mp4")
    clips.clip(tmp_path / "N_right.mp4")
    recording = make_recording(clips.chosen(tmp_path), tmp_path)
    assert recording.guessed
    guess = [one for one in examine(tmp_path) if "guessed" in one.what]
    assert [one.severity for one in guess] == ["warning"]
    with pytest.raises(InputError, match="calibration is a guess"):
        usable_views(recording, None)


def test_files_from_elsewhere_are_copied(tmp_path):
    video = clips.clip(tmp_path / "videos" / "cam.mp4")
    clips.images(tmp_path / "pictures" / "S")
    before = content(tmp_path)
    choices = clips.chosen(video, tmp_path / "pictures")
    recording = make_recording(choices, tmp_path / "new")
    assert {path: path.read_bytes() for path in before} == before
    assert (tmp_path / "new" / "cam.mp4").read_bytes() == video.read_bytes()
    shown = clips.frames_of(recording)[7]
    assert shown["cam"].image[0, 0] == shown["S"].image[0, 0] == clips.numbered(7)[0, 0]


@pytest.mark.parametrize(("role", "left_first"), [("side by side", True),
                                                  ("side by side, swapped", False)])  # fmt: skip
def test_side_by_side_videos_are_split(tmp_path, role, left_first):
    clips.clip(tmp_path / "zed.mp4", lambda k: clips.numbered(k, 2 * clips.WIDTH))
    choices = clips.chosen(tmp_path)
    choices = replace(choices, uses=(replace(choices.uses[0], role=role),))
    recording = make_recording(choices, tmp_path)
    shown = clips.frames_of(recording)[clips.FRAMES - 1]["zed"]
    assert shown.left.shape[:2] == shown.image.shape[:2] == (clips.HEIGHT, clips.WIDTH)
    assert (shown.left.mean() < shown.image.mean()) == left_first


def test_mirror_images_are_turned_back(tmp_path):
    clips.clip(tmp_path / "kinect.mp4")
    choices = clips.chosen(tmp_path)
    choices = replace(choices, uses=(replace(choices.uses[0], mirrored=True),))
    recording = make_recording(choices, tmp_path / "new")
    shown = clips.frames_of(recording)[4]["kinect"].image.astype(int)
    assert abs(shown - clips.numbered(4)[:, ::-1]).max() <= 3, "but for the coding"


def test_depth_alone_gets_a_picture_of_itself(tmp_path):
    clips.images(tmp_path / "O_depth", depth=True)
    choices = clips.chosen(tmp_path, fps=30.0)
    unit = possible_units(choices.uses[0].source)[0][0]
    assert unit == 0.001
    recording = make_recording(replace(choices, depth_unit=unit), tmp_path)
    shown = clips.frames_of(recording)[2]["O"]
    assert np.allclose(shown.depth[:, 8:-8], 2.98)
    assert np.isnan(shown.depth[:, :8]).all()
    assert (shown.image[:, :8] == 0).all(), "no value is black"
    assert shown.image[0, -1] > shown.image[0, 20] > 0, "near is bright"


def test_later_starts_are_written_as_first_frames_with_the_rest_as_an_offset(tmp_path):
    for name in "AB":
        clips.clip(tmp_path / f"{name}.mp4")
    choices = clips.chosen(tmp_path)
    first, second = choices.uses
    choices = replace(choices, uses=(replace(first, lead=-1.25), replace(second, lead=2.0)))
    recording = make_recording(choices, tmp_path)
    starts = {view.name: (view.image.first_frame, view.image.time_offset)
              for view in recording.views}  # fmt: skip
    assert starts == {"A": (0, 0.0), "B": (3, 0.01)}
    shown = clips.frames_of(recording)[0]
    assert shown["A"].image[0, 0] == clips.numbered(0)[0, 0]
    assert shown["B"].image[0, 0] == clips.numbered(3)[0, 0]


def test_a_calibration_is_taken_by_the_names_of_its_cameras(tmp_path):
    clips.clip(tmp_path / "A.mp4")
    choices = clips.chosen(tmp_path)
    camera = cameras_for(choices)["A"]
    path = tmp_path / "calibration.toml"
    write_calibration(path, {"basler": replace(camera, name="basler")})
    choices = clips.chosen(tmp_path)
    assert choices.calibration == path
    with pytest.raises(InputError, match="'A' is not in the calibration"):
        make_recording(choices, tmp_path)
    before = path.read_bytes()
    recording = make_recording(replace(choices, cameras={"A": "basler"}), tmp_path)
    assert path.read_bytes() == before
    assert not recording.guessed
    assert recording.views[0].image.camera == "basler"


def test_nothing_is_overwritten(tmp_path):
    video = clips.clip(tmp_path / "videos" / "A.mp4")
    choices = clips.chosen(video)
    there = tmp_path / "there"
    there.mkdir()
    (there / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match="the folder is not empty"):
        make_recording(choices, there)
    (tmp_path / "videos" / "calibration.toml").write_text("mine")
    with pytest.raises(InputError, match=r"already a calibration\.toml"):
        make_recording(replace(choices, calibration=None), tmp_path / "videos")
    new = tmp_path / "new"
    make_recording(choices, new)
    before = content(new)
    with pytest.raises(InputError, match="a recording already"):
        make_recording(choices, new)
    assert content(new) == before


def test_work_that_is_stopped_leaves_nothing(tmp_path):
    clips.clip(tmp_path / "videos" / "zed.mp4", lambda k: clips.numbered(k, 2 * clips.WIDTH))
    seen = []
    work = Work(lambda *_: seen.append(1), lambda: len(seen) >= 3)
    with pytest.raises(Cancelled):
        make_recording(clips.chosen(tmp_path / "videos"), tmp_path / "new", work)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["videos"]


def test_choices_that_do_not_fit_together_are_explained(tmp_path):
    clips.clip(tmp_path / "A.mp4")
    clips.clip(tmp_path / "B.mp4")
    choices = clips.chosen(tmp_path)
    first, second = choices.uses
    assert not list(problems_of(choices))

    def problem(*uses):
        return " ".join(str(one) for one in problems_of(replace(choices, uses=uses)))

    assert "the right image is missing" in problem(replace(first, role="left"))
    assert "no source is used" in problem(replace(first, role="unused"))
    assert "is no depth map" in problem(replace(first, role="depth"))
    assert "show the same part" in problem(first, replace(second, view="A"))
    assert "needs a name" in problem(replace(first, view="a/b"))
    assert "frame rate" in " ".join(str(one) for one in problems_of(replace(choices, fps=None)))
