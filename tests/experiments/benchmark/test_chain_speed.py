"""The benchmark of the whole chain, on a tiny rendered recording."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.benchmark.speed import chain_speed
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking.presets import preset


def test_chain_and_matching_are_timed(tmp_path):
    options = SceneOptions(width=160, height=120, focal=100.0)
    simulate(tmp_path / "r", Simulation(frames=5, views="NS", motion="t-pose", options=options))
    told = []
    speeds = chain_speed(
        open_recording(tmp_path / "r"),
        {name: preset(name) for name in ("fast", "thesis")},
        frames=4,
        rounds=2,
        on_progress=told.append,
    )
    assert [speed.preset for speed in speeds] == ["fast", "thesis"]
    for speed in speeds:
        assert speed.frames == 4
        assert speed.ratio == pytest.approx(speed.seconds / speed.matching_seconds)
        assert speed.seconds > 0
        assert {"read", "views"} <= set(speed.stage_ms)
        assert speed.matching_seconds > 0
    assert told == [1, 2, 3, 4]


def test_recording_without_stereo(shared_recording):
    recording = open_recording(shared_recording("seated-4cam"))
    with pytest.raises(InputError, match="stereo"):
        chain_speed(recording, {"fast": preset("fast")})
