"""Every example runs on a small recording and says what it promises."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import stereotrack_core as stereotrack
from stereotrack_core.annotation.click import Click
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.recording.landmarks import LANDMARKS, read_landmarks
from stereotrack_core.simulation.rig import SceneOptions

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A rendered recording of two views and four frames."""
    folder = tmp_path_factory.mktemp("examples") / "tiny"
    options = SceneOptions(width=320, height=240, focal=200.0)
    stereotrack.simulate(
        folder, stereotrack.Simulation(motion="t-pose", frames=4, views="NS", options=options)
    )
    return folder


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_example_is_run_here():
    here = Path(__file__).read_text("utf-8")
    for path in EXAMPLES.glob("*.py"):
        assert f'example("{path.stem}")' in here


def test_open_and_look(folder, capsys):
    example("open_and_look").main(folder)
    said = capsys.readouterr().out
    assert "tiny: " in said
    assert "N (stereo), S (stereo)" in said
    height = float(re.search(r"([\d.]+) m from foot", said).group(1))
    assert 1.3 < height < 2.1


def test_track_and_evaluate(folder, tmp_path, capsys):
    example("track_and_evaluate").main(folder, tmp_path / "run.npz", "fast")
    forearms = float(re.search(r"forearms: ([\d.]+) deg", capsys.readouterr().out).group(1))
    run = stereotrack.read_run(tmp_path / "run.npz")
    summary = stereotrack.evaluate(run, stereotrack.open_recording(folder).reference)
    assert forearms == pytest.approx(summary.measure("forearms").statistics.mean, abs=0.051)


def test_fit_clicks(folder, tmp_path, capsys):
    recording = stereotrack.open_recording(folder)
    cameras = [recording.reference_camera(view) for view in recording.views]
    clicks = [
        Click(frame, camera.name, name, tuple(map(float, pixel)))
        for frame in (0, 3)
        for camera in cameras
        for name, pixel in zip(
            LANDMARKS, camera.project(recording.reference.points[frame]), strict=True
        )
    ]
    write_clicks(tmp_path / "clicks.csv", clicks, recording)
    example("fit_clicks").main(folder, tmp_path / "clicks.csv", tmp_path / "reference.csv")
    assert capsys.readouterr().out.startswith("4 frames, of which 2 are clicked")
    found = read_landmarks(tmp_path / "reference.csv")
    off = np.linalg.norm(found.points - recording.reference.points, axis=2)
    assert np.nanmax(off) < 0.1


def test_compare_settings(folder, capsys):
    changes = [f"search_arms=no fit_shape=no least_focal=0 iterations={k}" for k in (2, 4)]
    example("compare_settings").main(folder, changes, "fast")
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == changes
    assert all(re.search(r": [34] frames tracked, .* deg off$", line) for line in lines)


def test_inspect_step(folder, capsys):
    example("inspect_step").main(folder, 2, "fast")
    first, *corrections, last = capsys.readouterr().out.splitlines()
    assert first.startswith("2 frames were tracked before; frame 2 by ")
    assert corrections
    off = [float(re.search(r"([\d.]+) mm off", line).group(1)) for line in corrections]
    assert 0.0 < off[-1] < 60.0
    assert "% of the cloud is unexplained" in last


def test_the_public_names_are_there_and_documented():
    for name in stereotrack.__all__:
        found = getattr(stereotrack, name)
        assert name == "__version__" or "Examples\n" in found.__doc__, name
    assert set(stereotrack.__all__) <= set(dir(stereotrack))
    with pytest.raises(AttributeError, match="nothing_like_it"):
        _ = stereotrack.nothing_like_it
