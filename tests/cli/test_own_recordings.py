"""Every command of the page about one's own recordings does what the page says."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.folder import open_recording
from tests.recording.importing.clips import HEIGHT, WIDTH, clip, flashing, images, numbered

PAGE = Path(__file__).resolve().parents[2] / "docs" / "own-recordings.md"
MADE = {
    "walk": "stereo", "zed-walk": "stereo", "front": "stereo", "kinect-walk": "depth",
    "mirrored-walk": "depth", "phones-walk": "mono", "phones-25": "mono",
    "pictures-walk": "mono",
}  # fmt: skip


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The files that the page speaks of, small."""
    monkeypatch.chdir(tmp_path)
    matrix = np.array([[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]])
    rig = {}
    for k, name in enumerate(("N_left", "N_right")):
        clip(tmp_path / "lab" / f"{name}.mp4", frames=3)
        place = RigidTransform(np.eye(3), np.array([-0.12 * k, 0.0, 0.0]))
        rig[name] = Camera(name, WIDTH, HEIGHT, matrix, np.zeros(5), False, place)
    write_calibration(tmp_path / "lab" / "rig.toml", rig)
    clip(tmp_path / "zed.mp4", lambda k: numbered(k, 2 * WIDTH), frames=3)
    images(tmp_path / "kinect" / "O_depth", depth=True)
    images(tmp_path / "kinect" / "O_rgb")
    clip(tmp_path / "phones" / "A.mp4", flashing(9.0), frames=20, fps=30.0)
    clip(tmp_path / "phones" / "B.mp4", flashing(14.0), frames=30, fps=25.0)
    images(tmp_path / "pictures" / "A")
    images(tmp_path / "pictures" / "B")
    return tmp_path


def test_the_commands_of_the_page(run, files):
    text = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"```\n(.*?)```", text, flags=re.DOTALL)
    commands = [line for block in blocks for line in block.splitlines()]
    assert len(commands) == 9
    for command in commands:
        program, *arguments = shlex.split(command)
        assert program == "stereotrack"
        run(*arguments)
    made = {name: open_recording(files / name).views[0].kind for name in MADE}
    assert made == MADE
    assert not open_recording(files / "walk").guessed
    second = open_recording(files / "phones-walk").views[1].image
    offset = second.first_frame + 25.0 * second.time_offset
    assert offset == pytest.approx(25.0 * (14 / 25 - 9 / 30), abs=0.6)
