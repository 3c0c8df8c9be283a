"""What to click next is ranked beside the window's thread, and gone to by a key or a click."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.features.annotate import next_clicks
from app.features.annotate.next_clicks import NextPresenter
from app.widgets.tables.landmarks_panel import NextPanel
from stereotrack_core.annotation.doubts import Doubt
from stereotrack_core.annotation.fit.results import CLICKED, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.next_clicks import StopSign, Suggestion
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.marks import FrameFlag, flag_frames, use_camera
from tests.annotation.fits import limb_sigma_deg

LEFT = Qt.MouseButton.LeftButton
FRAMES = 40


def fit_between(make, clicked, *, unsure=0.05) -> TrajectoryFit:
    points = np.stack([make.places_at(frame) for frame in range(FRAMES)])
    away = np.abs(np.arange(FRAMES)[:, None] - np.array(clicked)).min(axis=1)
    spread = 0.005 + unsure * away / away.max()
    covariance = np.square(spread)[:, None, None, None] * np.eye(3)
    covariance = np.broadcast_to(covariance, (FRAMES, 9, 3, 3)).copy()
    return TrajectoryFit(
        names=NINE.names,
        frame=np.arange(FRAMES),
        landmarks=points,
        covariance=covariance,
        limb_sigma_deg=limb_sigma_deg(points, covariance, NINE),
        kind=np.where(away == 0, CLICKED, INTERPOLATED),
        nine=points,
        residual_px={},
        outlier_probability={},
    )


@pytest.fixture
def presenter(qtbot, project, make, tasks):
    project.apply(place_clicks(make.clicks_at([0, 39])))
    heard = []
    made = NextPresenter(tasks, heard.append)
    made.problems, made.heard = [], heard
    tasks.failed = made.problems.append
    made.set_project(project, make.CAMERAS)
    project.on_change(made.follow)
    yield made
    made.set_project(None, {})
    assert not made.problems


def ranking_after(qtbot, presenter, do):
    before = len(presenter.heard)
    do()
    qtbot.waitUntil(lambda: len(presenter.heard) > before and presenter.idle)
    return presenter.heard[-1]


def test_the_middle_between_clicks_comes_first_and_a_click_there_is_taken_in(
    qtbot, project, presenter, make
):
    fit = fit_between(make, [0, 39])
    first = ranking_after(qtbot, presenter, lambda: presenter.set_fit(fit))
    assert not first.sign.reached
    best = first.suggestions[0]
    assert 15 < best.frame < 25
    assert best.reason
    there = make.clicks_at([best.frame])
    after = ranking_after(qtbot, presenter, lambda: project.apply(place_clicks(there)))
    assert all(one.frame != best.frame for one in after.suggestions)


def test_gaps_are_not_asked_for(qtbot, project, presenter, make):
    fit = fit_between(make, [0, 39])
    ranking_after(qtbot, presenter, lambda: presenter.set_fit(fit))
    gap = flag_frames(tuple(FrameFlag(frame, "", "gap") for frame in range(10, 30)))
    after = ranking_after(qtbot, presenter, lambda: project.apply(gap))
    assert after.suggestions
    assert all(one.frame not in range(10, 30) for one in after.suggestions)
    assert after.sign.frames == 20


def test_the_wanted_accuracy_is_kept_and_stops(qtbot, project, presenter, make, tasks):
    fit = fit_between(make, [0, 39])
    ranking_after(qtbot, presenter, lambda: presenter.set_fit(fit))
    after = ranking_after(qtbot, presenter, lambda: presenter.set_wanted(40.0))
    assert after.sign.reached
    again = NextPresenter(tasks, lambda _ranking: None)
    again.set_project(project, make.CAMERAS)
    assert again.wanted_deg == 40.0


def test_doubts_of_the_images_join_and_go_with_an_edit(
    qtbot, project, presenter, make, monkeypatch
):
    assert presenter.why_not_check().startswith("Fit the whole recording first")
    ranking_after(qtbot, presenter, lambda: presenter.set_fit(fit_between(make, [0, 39])))
    key, said = make.clicks_at([39])[0].key, []
    doubt = Doubt(0.7, 5.0, "the clicks before and after lead to another place", "appearance")
    monkeypatch.setattr(next_clicks, "unlike_the_others", lambda *_: {key: doubt})
    after = ranking_after(qtbot, presenter, lambda: presenter.check(None, said.append))
    assert said == ["1 click may be wrong by the images; see Suggested clicks."]
    assert [one.key for one in after.suggestions if one.kind == "appearance"] == [key]
    again = tuple(replace(one, position=(30.0, 30.0)) for one in make.clicks_at([39])[:1])
    after = ranking_after(qtbot, presenter, lambda: project.apply(place_clicks(again)))
    assert not [one for one in after.suggestions if one.kind == "appearance"]
    fit = fit_between(make, [0, 39])
    after = ranking_after(qtbot, presenter, lambda: presenter.set_fit(fit))
    assert not [one for one in after.suggestions if one.kind == "appearance"], "nor after a fit"
    leave_out = use_camera(key.camera, used=False)
    after = ranking_after(qtbot, presenter, lambda: project.apply(leave_out))
    assert key.camera not in {one.camera for one in after.suggestions}


ROWS = (
    Suggestion(17, "N", "left_hand", 3.2, "left forearm uncertain (6.1 deg)", over_frames_deg=14.3),
    Suggestion(30, "W", "head", 1.2, "probable outlier, 40 px", click_there=True),
    Suggestion(5, "S", "left_elbow", 0.4, "left upper arm uncertain (2.1 deg)"),
)
SIGN = StopSign(3.0, 40, 12, {"left_forearm": 12, "torso": 0})
COLOURS = {one.name: one.colour for one in NINE.landmarks}


@pytest.fixture
def panel(shown):
    went = []
    made = shown(NextPanel(lambda *where: went.append(where), lambda: went.append(())), 560, 300)
    made.went = went
    made.show_ranking(ROWS, SIGN, COLOURS)
    return made


def test_the_best_comes_first_and_each_is_visited_once(qtbot, panel):
    went = panel.went
    for _ in range(4):
        qtbot.mouseClick(panel.next_button, LEFT)
    assert [where[0] for where in went] == [17, 30, 5, 17]
    area = panel.tree.visualRect(panel.tree.cells.index(1, 4))
    qtbot.mouseClick(panel.tree.viewport(), LEFT, pos=area.center())
    assert went[-1] == (30, "W", "head")
    qtbot.keyClick(panel.tree, Qt.Key.Key_Down)
    qtbot.keyClick(panel.tree, Qt.Key.Key_Return)
    assert went[-1] == (5, "S", "left_elbow")


def test_enough_is_said_with_a_doubt_where_clicks_lie_far_off(panel):
    reached = replace(SIGN, frames_missing=0)
    panel.show_ranking(ROWS, reached, COLOURS)
    assert panel.sign.text().endswith("target reached, once the outlying clicks are corrected.")
    panel.show_ranking([one for one in ROWS if not one.click_there], reached, COLOURS)
    assert panel.sign.text().endswith("target reached.")


def test_the_wanted_accuracy_is_typed(qtbot, panel):
    panel.wanted.selectAll()
    with qtbot.waitSignal(panel.wanted.valueChanged) as caught:
        qtbot.keyClicks(panel.wanted, "2")
        qtbot.keyClick(panel.wanted, Qt.Key.Key_Return)
    assert caught.args == [2.0]


def test_nothing_fitted_offers_to_fit(qtbot, panel):
    panel.show_ranking((), None, {})
    assert panel.fit_button.isVisible()
    with qtbot.waitSignal(panel.fit_button.clicked):
        qtbot.mouseClick(panel.fit_button, LEFT)
    with qtbot.waitSignal(panel.fit_button.clicked):
        panel.go_to_next()
    panel.show_ranking(ROWS, SIGN, COLOURS)
    panel.show_ranking(ROWS, SIGN, COLOURS)
    assert panel.went == [(17, "N", "left_hand")], "as soon as there is one, and once"
    panel.show_ranking((), SIGN, COLOURS)
    panel.go_to_next()
    assert panel.went[1:] == [()], "nothing is left to go to"


def test_one_kind_of_suggestion_is_shown_alone(qtbot, panel):
    places = [replace(one, kind="swapped") for one in ROWS[:2]]
    panel.show_ranking((*places, ROWS[2]), SIGN, COLOURS)
    kinds = [panel.kinds.itemText(k) for k in range(panel.kinds.count())]
    assert kinds == ["All kinds", "Would help most (1)", "Sides exchanged (2)"]
    panel.kinds.setFocus()
    for _ in range(2):
        qtbot.keyClick(panel.kinds, Qt.Key.Key_Down)
    assert [one.frame for one in panel.tree.cells.rows] == [17, 30]
    panel.show_ranking((places[1], ROWS[2]), SIGN, COLOURS)
    assert panel.kinds.currentText() == "Sides exchanged (1)"
    assert [one.frame for one in panel.tree.cells.rows] == [30]
    panel.show_ranking(ROWS, SIGN, COLOURS)
    assert panel.kinds.currentText() == "All kinds"
    assert len(panel.tree.cells.rows) == 3
