"""Simulated clicks are where the truth is seen."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.annotation.fit.scenes import CAMERAS, places
from tests.annotation.simulated_clicks import (
    OUTLIER_PX,
    AnnotationCase,
    seen_landmarks,
    simulated_clicks,
)

TRUTH = np.array([places(k) for k in range(8)])
VIEWS = tuple(View(name, "mono", Stream(name, f"{name}.mp4")) for name in CAMERAS)
REFERENCE = LandmarkTrajectory(np.arange(8), TRUTH)
RECORDING = Recording(Path("nowhere"), "simulated", 10.0, VIEWS, CAMERAS, reference=REFERENCE)


def away(clicks):
    return {
        one.key: np.array(one.position)
        - CAMERAS[one.camera].project(TRUTH[frame, LANDMARKS.index(one.landmark)])
        for frame, own in clicks.by_frame.items()
        for one in own
    }


def test_outliers_and_missing_clicks_are_as_many_as_the_case_says():
    all_of = simulated_clicks(RECORDING, AnnotationCase("a", 0.01, 1, depth=False), 0)
    case = AnnotationCase("b", 0.01, 1, depth=False, missing=0.3, outliers=0.2)
    some = simulated_clicks(RECORDING, case, 0)
    off = away(some)
    share = len(off) / len(away(all_of))
    assert 0.6 < share < 0.8
    assert 0.1 < len(some.outliers) / len(off) < 0.3
    for key, miss in off.items():
        distance = float(np.linalg.norm(miss))
        if key in some.outliers:
            assert OUTLIER_PX[0] - 1 < distance < OUTLIER_PX[1] + 1
        else:
            assert distance < 1


def test_what_is_behind_the_trunk_or_outside_the_image_is_not_clicked():
    seen = seen_landmarks(RECORDING, list(CAMERAS.values()))
    views, names = list(CAMERAS), LANDMARKS
    assert seen[0, views.index("W"), names.index("left_shoulder")]
    assert not seen[0, views.index("W"), names.index("right_hip")]
    assert not seen[0, views.index("O"), names.index("left_hip")]
    assert seen[:, :, names.index("head")].all()
    narrow = replace(CAMERAS["N"], width=200)
    seen = seen_landmarks(RECORDING, [narrow])
    assert not seen[0, 0].all()
