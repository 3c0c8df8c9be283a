"""Rigs that users build are tracked without settings: lenses, distances, people and worlds."""

import dataclasses

import pytest

from stereotrack_core.evaluation.summary import errors_against, summarise
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.end_to_end.rigs import RIGS, make_rig

FRAMES = 14
MOST_LOST = 0.25  # of the arm segments; the arms of people near a camera reach out of its image
MOST_TILTED = 18.0  # degrees of the torso's long axis, mean over all frames; untracked count 90
UPWARDS = {"floor": "z", "away": "z", "y-up": "y", "camera": "-y", "camera-y-up": "y"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["accurate", "fast"])
@pytest.mark.parametrize("rig", RIGS, ids=[rig.name for rig in RIGS])
def test_a_rig_is_tracked_without_settings(rig, name, tmp_path):
    folder = tmp_path / rig.name
    make_rig(folder, rig, FRAMES)
    recording = open_recording(folder)
    unknown = dataclasses.replace(recording, reference=None)
    run = track(unknown, RunSpec(preset(name), preset=name))
    found = summarise(errors_against(run.trajectory(), recording.reference))
    mean = {one.name: one.statistics.mean for one in found.measures}
    print(  # noqa: T201 - the table that `pytest -s` shows
        f"{rig.name:15s} {name:9s} tracked {run.tracked.mean():.2f} lost {100 * found.lost:.1f} %, "
        + ", ".join(f"{measure} {value:.1f}" for measure, value in list(mean.items())[:5])
    )
    assert run.meta["from_recording"].get("up_axis", "z") == UPWARDS[rig.world]
    assert run.tracked.mean() >= 0.8
    assert mean["torso_long"] < MOST_TILTED
    if name == "accurate":  # the other takes front for back where a single near view sees no legs
        assert found.lost <= MOST_LOST
