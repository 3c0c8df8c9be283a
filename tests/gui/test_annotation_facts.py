"""From clicks to hints, marks and rows; edits of a second reading. No window."""

from dataclasses import replace

import numpy as np
import pytest

from app.features.annotate.clicking import marks
from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.frame_clicks import (
    FitQuestion,
    HintQuestion,
    fitted_body,
    hints_of,
)
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import AVERAGE, proportions_of
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS

N, S = "N_right", "S_right"


@pytest.fixture
def recording(small_recording):
    return open_recording(small_recording)


def true_clicks(recording, cameras=(N, S, "N_left"), landmarks=NINE.names):
    points = recording.reference.points[0]
    found = []
    for camera in cameras:
        for name in landmarks:
            x, y = recording.cameras[camera].project(points[LANDMARKS.index(name)])
            found.append(Click(0, camera, name, (float(x), float(y))))
    return tuple(found)


def question(recording, clicks, landmark="left_elbow", shown=(N, S)):
    volume = Volume.of(DepthParameters())
    return HintQuestion(0, clicks, recording.cameras, NINE, AVERAGE, {}, landmark, shown, volume)


def test_without_a_calibration_no_fit_is_announced(recording):
    facts = marks.FrameMarks(0, true_clicks(recording, (N, S)), NINE, "head")
    assert marks.fit_words(facts) == ("Fitting the body to the clicks …",)
    (words,) = marks.fit_words(replace(facts, calibrated=False))
    assert words == "No calibration: clicks are kept, and no body is fitted to them."


def test_a_body_of_other_lengths_is_off_the_clicks_by_more_than_is_wanted(recording):
    clicks = true_clicks(recording, (N, S))
    hints, own = hints_of(question(recording, clicks)), proportions_of(recording.subject)
    off = []
    for lengths in (own, replace(own, torso_length=own.torso_length - 0.08)):
        asked = FitQuestion(0, clicks, recording.cameras, NINE, lengths, {}, {}, 10.0, None)
        off.append(marks.body_off_mm(hints, fitted_body(asked)))
    assert off[0] < 8.0
    assert off[1] > 20.0


def test_what_is_drawn_of_a_fit_is_what_is_known(recording):
    clicks = true_clicks(recording, (N, S))
    views = {N: "N", S: "S"}
    fit = fitted_body(
        FitQuestion(0, clicks, recording.cameras, NINE, AVERAGE, {}, views, 10.0, None)
    )
    facts, camera = marks.FrameMarks(0, clicks, NINE, "head", fit=fit), recording.cameras[N]
    assert {mark.limb for mark in marks.marks_of(facts, [camera])[N].model} == set(LIMBS)
    sigma = np.array([2.0, 25.0, 44.0, 2.0, 131.5, np.nan])
    rough = replace(facts, fit=replace(fit, fit=replace(fit.fit, limb_sigma_deg=sigma)))
    opacity = {mark.limb: mark.opacity for mark in marks.marks_of(rough, [camera])[N].model}
    assert opacity[LIMBS[0]] == opacity[LIMBS[3]] == 1.0
    assert 1.0 > opacity[LIMBS[1]] > opacity[LIMBS[2]] > 0.0
    assert [value.text for _, value, _ in marks.limb_rows(rough)] == [
        *("± 2.0°", "± 25.0°", "± 44.0°", "± 2.0°", "unknown", "unknown")
    ]
    assert not facts.fit_is_old
    later = replace(facts, clicks=(*clicks, Click(0, "N_left", "head", (3.0, 4.0))))
    assert later.fit_is_old
    assert marks.marks_of(later, [camera])[N].model_is_old
    assert {words.text for _, _, words in marks.limb_rows(later)} == {"before the last click"}
    two = tuple(one for one in clicks if one.landmark in ("left_hand", "head", "right_hip"))
    one_view = tuple(one for one in two if one.camera == N)
    asked = FitQuestion(0, one_view, recording.cameras, NINE, AVERAGE, {}, views, 10.0, None)
    unsure = fitted_body(asked)
    known = {limb for limb, s in zip(LIMBS, unsure.fit.limb_sigma_deg, strict=True) if s <= 45.0}
    assert {mesh.limb for mesh in unsure.meshes} == known != set(LIMBS)
    assert any("unknown" in words for words in unsure.fit.words)
