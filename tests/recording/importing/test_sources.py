"""What is found in folders and files that are no recording."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.readers import first_picture
from stereotrack_core.recording.importing.sources import is_unmade, look_at
from tests.recording.importing.clips import FRAMES, HEIGHT, WIDTH, clip, images, numbered


def roles(folder):
    return {use.source.name: (use.role, use.view) for use in propose(look_at([folder])).uses}


def test_videos_are_described(tmp_path):
    clip(tmp_path / "a.mp4")
    found = look_at([tmp_path])
    (source,) = found.sources
    assert (source.name, source.kind, source.size) == ("a", "video", (WIDTH, HEIGHT))
    assert (source.frames, source.fps, source.sound) == (FRAMES, 25.0, False)
    assert found.fps == 25.0
    assert found.folder == tmp_path
    assert first_picture(source).shape[:2] == (HEIGHT, WIDTH)


def test_images_are_grouped_by_folder_and_name(tmp_path):
    images(tmp_path / "N")
    images(tmp_path / "S", "frame-{}-grey.png".format)
    images(tmp_path / "depth", depth=True)
    clip(tmp_path / "inner" / "cam.mp4")
    (tmp_path / "notes.txt").write_text("no image")
    found = {one.name: one for one in look_at([tmp_path]).sources}
    assert {name: (one.kind, one.pattern) for name, one in found.items()} == {
        "N": ("images", "%04d.png"),
        "frame": ("images", "frame-%d-grey.png"),
        "depth": ("depth", "%04d.png"),
        "cam": ("video", ""),
    }
    assert [path.name for path in found["frame"].images][-1] == "frame-11-grey.png"


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("N_left", "N_right"), {"N_left": ("left", "N"), "N_right": ("right", "N")}),
        (("left", "right"), {"left": ("left", "stereo"), "right": ("right", "stereo")}),
        (("a_l", "a_r"), {"a_l": ("left", "a"), "a_r": ("right", "a")}),
        (("cam0", "cam1"), {"cam0": ("left", "stereo"), "cam1": ("right", "stereo")}),
        (("cam0", "cam1", "cam2"), {f"cam{k}": ("mono", f"cam{k}") for k in range(3)}),
        (("left", "S"), {"left": ("mono", "left"), "S": ("mono", "S")}),
    ],
)
def test_pairs_are_proposed_by_their_names(tmp_path, names, expected):
    for name in names:
        clip(tmp_path / f"{name}.mp4", frames=2)
    assert roles(tmp_path) == expected


def test_a_wide_video_is_taken_for_two(tmp_path):
    clip(tmp_path / "zed.mp4", lambda k: numbered(k, 2 * WIDTH), frames=2)
    assert roles(tmp_path) == {"zed": ("side by side", "zed")}


def test_depth_is_proposed_with_its_image(tmp_path):
    images(tmp_path / "O_depth", depth=True)
    images(tmp_path / "O_rgb")
    images(tmp_path / "O_mask")
    expected = {"O_depth": "depth", "O_rgb": "image", "O_mask": "mask"}
    assert roles(tmp_path) == {name: (role, "O") for name, role in expected.items()}


def test_what_cannot_be_read_is_said_and_the_rest_is_found(tmp_path):
    clip(tmp_path / "a.mp4")
    (tmp_path / "b.mp4").write_bytes(b"no video at all")
    found = look_at([tmp_path])
    assert [one.name for one in found.sources] == ["a"]
    assert found.problems[0].where.endswith("b.mp4")


def test_a_folder_without_videos_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "notes.txt").write_text("nothing")
    assert not is_unmade(tmp_path)
    with pytest.raises(InputError, match="no videos and no numbered images"):
        look_at([tmp_path])
    with pytest.raises(InputError, match="no such file or folder"):
        look_at([tmp_path / "nowhere"])
