"""What the arguments mean."""

from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.selection import asked_frames, views_of


def recording_with(*names, folder=Path("nowhere")):
    views = tuple(View(name, "mono", Stream(name, f"{name}.mp4")) for name in names)
    return Recording(folder=folder, name="r", fps=10.0, views=views, cameras={})


@pytest.mark.parametrize(
    ("text", "bounds"),
    [("3:9", (3, 9)), (":9", (0, 9)), ("3:", (3, 99)), (":", (0, 99)), (None, (0, 99))],
)
def test_asked_frames(text, bounds):
    assert asked_frames(text, 99) == range(*bounds)


@pytest.mark.parametrize("text", ["", "3", "a:b", "9:3", "3:3", "-1:4", ":0", "1:2:3", "1.5:3"])
def test_frames_that_make_no_sense(text):
    with pytest.raises(InputError) as caught:
        asked_frames(text)
    assert caught.value.where == "--frames"
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("names", "text", "chosen"),
    [
        ("NOSW", "NS", ("N", "S")),
        ("NOSW", "N", ("N",)),
        ("NOSW", "S+N+S", ("S", "N")),
        (("cam_0", "cam_1", "cam_2"), "cam_0+cam_2", ("cam_0", "cam_2")),
        (("NS", "N", "S"), "NS", ("NS",)),
        ("NOSW", None, None),
    ],
)
def test_views(names, text, chosen):
    assert views_of(recording_with(*names), text) == chosen
