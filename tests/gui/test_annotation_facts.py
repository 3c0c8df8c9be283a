"""From clicks to hints, marks and rows; edits of a second reading. No window."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.features.annotate.clicking.controller import SwapOffers
from app.features.annotate.clicking.landmark_rows import (
    fit_words,
    landmark_rows,
    limb_rows,
)
from app.features.annotate.clicking.marks import FrameMarks, marks_of, predictions_in
from stereotrack_core.annotation.click import UNCERTAIN, Click, Prediction, Visibility
from stereotrack_core.annotation.frame_clicks import (
    FitQuestion,
    Fitter,
    HintQuestion,
    hints_of,
)
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import AVERAGE
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


def test_hints_without_two_views_are_curves_alone(recording):
    clicks = true_clicks(recording, (N,), ("left_elbow",))
    hints = hints_of(question(recording, clicks))
    assert hints.points == {}
    assert hints.curves[N] == ()
    (curve,) = hints.curves[S]
    truth = true_clicks(recording, (S,), ("left_elbow",))[0].position
    assert np.linalg.norm(curve.pixels - truth, axis=1).min() < 4.0


def test_marks_say_how_a_click_is_meant(recording):
    clicks = (
        Click(0, N, "head", (3.0, 4.0), Visibility.GUESSED),
        Click(0, N, "left_hand", (5.0, 4.0), flag=UNCERTAIN),
        Click(0, N, "right_hand", None, Visibility.OUTSIDE),
        Click(0, S, "left_hip", (9.0, 9.0), origin="accepted"),
    )
    facts = FrameMarks(0, clicks, NINE, "head", at_hand=clicks[1].key, held=clicks[1].key)
    marks = marks_of(facts, [recording.cameras[N], recording.cameras[S]])
    head, hand = marks[N].clicks
    assert (head.guessed, head.chosen, head.at_hand) == (True, True, False)
    assert (hand.doubted, hand.at_hand, hand.held) == (True, True, True)
    assert marks[N].outside == ("right hand",)
    assert marks[S].clicks[0].accepted


def test_triangulated_predictions_go_before_kept_ones(recording):
    clicks = true_clicks(recording, (N, "N_left"))
    hints = hints_of(question(recording, clicks))
    kept = (
        Prediction(0, S, "head", "following", (1.0, 2.0)),
        Prediction(0, S, "left_knee", "following", (1.0, 2.0)),
    )
    facts = FrameMarks(0, clicks, NINE, "head", predictions=kept, hints=hints)
    found = {one.landmark: one for one in predictions_in(facts, S)}
    assert found["head"].source == "other views"
    assert "left_knee" not in found
    assert predictions_in(replace(facts, hints=None), S) == kept[:1]
    marks = marks_of(facts, [recording.cameras[S]])[S]
    assert {mark.landmark for mark in marks.predictions} == set(NINE.names)
    rows = landmark_rows(facts, (N, S))
    assert [row.cells for row in rows] == [("clicked", "predicted")] * 9


def test_the_fit_says_everything_the_panels_need(recording):
    clicks = true_clicks(recording, (N, S))
    far = replace(clicks[4], position=(clicks[4].position[0] + 60, clicks[4].position[1] + 40))
    clicks = (*clicks[:4], far, *clicks[5:])
    fit = Fitter()(
        FitQuestion(0, clicks, recording.cameras, NINE, AVERAGE, {}, {N: "N"}, 10.0, None)
    )
    hints = hints_of(question(recording, clicks))
    facts = FrameMarks(0, clicks, NINE, far.landmark, hints=hints, fit=fit)
    rows = {row.landmark: row for row in landmark_rows(facts, (N, S))}
    assert float(rows[far.landmark].residual) > 10.0
    assert rows["head"].distance
    assert limb_rows(facts)[0][0].text == "torso"
    assert all(math.isfinite(float(value.text.strip("± °"))) for _, value, _ in limb_rows(facts))
    assert "does not fit" not in fit_words(facts)[0]
    wrong = {key: np.array([90.0, 20.0]) for key in fit.residuals}
    off = replace(facts, fit=replace(fit, residuals=wrong))
    assert fit_words(off)[0].startswith("The body does not fit these clicks: median distance 92 px")
    marks = marks_of(facts, [recording.cameras[N]])[N]
    (end,) = [r.end for r in marks.residuals if r.start == far.position]
    assert end == pytest.approx(tuple(recording.cameras[N].project(fit.places[far.landmark])))
    moved = marks.with_moved(far.landmark, 1.0, 2.0)
    assert len(moved.residuals) == len(marks.residuals) - 1
    assert fit_words(replace(facts, fit=None)) == ("Fitting the body to the clicks …",)
    few = replace(facts, fit=None, clicks=clicks[:2])
    assert "at least three landmarks" in fit_words(few)[0]
    assert "Keys 1 to 9" in fit_words(FrameMarks(0, (), NINE, "head"))[0]


def test_what_is_drawn_of_a_fit_is_what_is_known(recording):
    clicks = true_clicks(recording, (N, S))
    views = {N: "N", S: "S"}
    fit = Fitter()(FitQuestion(0, clicks, recording.cameras, NINE, AVERAGE, {}, views, 10.0, None))
    facts, camera = FrameMarks(0, clicks, NINE, "head", fit=fit), recording.cameras[N]
    assert {mark.limb for mark in marks_of(facts, [camera])[N].model} == set(LIMBS)
    sigma = np.array([2.0, 25.0, 44.0, 2.0, 131.5, np.nan])
    rough = replace(facts, fit=replace(fit, fit=replace(fit.fit, limb_sigma_deg=sigma)))
    opacity = {mark.limb: mark.opacity for mark in marks_of(rough, [camera])[N].model}
    assert opacity[LIMBS[0]] == opacity[LIMBS[3]] == 1.0
    assert 1.0 > opacity[LIMBS[1]] > opacity[LIMBS[2]] > 0.0
    assert [value.text for _, value, _ in limb_rows(rough)] == [
        *("± 2.0°", "± 25.0°", "± 44.0°", "± 2.0°", "unknown", "unknown")
    ]
    assert not facts.fit_is_old
    later = replace(facts, clicks=(*clicks, Click(0, "N_left", "head", (3.0, 4.0))))
    assert later.fit_is_old
    assert marks_of(later, [camera])[N].model_is_old
    assert {words.text for _, _, words in limb_rows(later)} == {"before the last click"}
    two = tuple(one for one in clicks if one.landmark in ("left_hand", "head", "right_hip"))
    one_view = tuple(one for one in two if one.camera == N)
    asked = FitQuestion(0, one_view, recording.cameras, NINE, AVERAGE, {}, views, 10.0, None)
    unsure = Fitter()(asked)
    known = {limb for limb, s in zip(LIMBS, unsure.fit.limb_sigma_deg, strict=True) if s <= 45.0}
    assert {mesh.limb for mesh in unsure.meshes} == known != set(LIMBS)
    assert any("unknown" in words for words in unsure.fit.words)


def test_an_offer_is_made_once_and_not_again_when_declined(recording):
    clicks = true_clicks(recording)
    swapped = {"left_elbow": "right_elbow", "right_elbow": "left_elbow"}
    mixed = tuple(
        replace(one, landmark=swapped.get(one.landmark, one.landmark)) if one.camera == S else one
        for one in clicks
    )
    hints = hints_of(question(recording, mixed))
    done = []
    offers = SwapOffers(done.append)
    gone, (message,) = offers.update(hints, {S: "S"})
    assert gone == ()
    assert "left elbow and right elbow" in message.what
    assert message.where == "S, frame 0"
    assert offers.update(hints, {S: "S"}) == ((), ())
    message.do()
    assert done == list(hints.swaps)
    assert offers.update(hints_of(question(recording, clicks)), {})[0] == (message,)
    (again,) = offers.update(hints, {S: "S"})[1]
    swap = offers.swap_of(again)
    offers.decline(swap)
    assert offers.update(hints, {S: "S"}) == ((), ()), "it was declined"
