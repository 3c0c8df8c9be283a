"""A run as the window's process does it."""

import math

import numpy as np
import pytest

from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments import run_process
from stereotrack_core.experiments.run_process import Allow, Prepared, Preparing, RunTask, Tracked
from stereotrack_core.tracking import detecting
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth


class Asker:
    """Hears what is told, and may stop the work while a stage is told."""

    def __init__(self, stop_at=""):
        self.told, self._stop_at = [], stop_at

    def tell(self, word):
        self.told.append(word)

    def orders(self, _seconds=0.0):
        if any(isinstance(w, Preparing) and w.stage == self._stop_at for w in self.told):
            raise Cancelled
        return []

    def of(self, kind):
        return [word for word in self.told if isinstance(word, kind)]


@pytest.fixture
def task(tmp_path, monkeypatch):
    recording = mono_recording(tmp_path)
    seen = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3), seed=3)

    def detect(_recording, _detector, frames, *, on_frame):
        for done, _frame in enumerate(frames, start=1):
            on_frame(done)
        return seen

    monkeypatch.setattr(detecting, "is_installed", lambda: True)
    monkeypatch.setattr(run_process, "required_detector", lambda: None)
    monkeypatch.setattr(run_process, "detect_keypoints", detect)
    spec = RunSpec(preset("accurate"), frames=range(FRAMES))
    return RunTask(recording, spec, None, Allow(math.inf, 1))


def test_mono_views_without_keypoints_are_detected_before_they_are_tracked(task):
    asker = Asker()
    task(asker)
    assert asker.of(Preparing)[0].stage == "detecting keypoints"
    assert len(asker.of(Prepared)[0].origin.spec.keypoints) > 0
    found = np.array([word.frame.landmarks for word in asker.of(Tracked)])
    assert np.median(np.linalg.norm(found - truth().points, axis=2)) < 0.015


def test_a_detection_can_be_stopped(task):
    asker = Asker(stop_at="detecting keypoints")
    with pytest.raises(Cancelled):
        task(asker)
    assert not asker.of(Prepared)
