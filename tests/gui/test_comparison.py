"""Runs beside each other in numbers, in their panel and over a selection."""

from __future__ import annotations

import numpy as np
import pytest

from app.presenters.comparison import compared
from app.presenters.judgement import MEASURED_LIMBS, Judgement
from app.presenters.runs import RunEntry
from app.theme import apply_theme
from app.views.comparison_panel import ComparisonPanel
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of


def entry(name):
    return RunEntry(name, "accurate", None, body_model(proportions_of(None)), range(10))


def judgement(first, count, degrees):
    frame = np.arange(first, first + count)
    limbs = dict.fromkeys(MEASURED_LIMBS, frame + degrees)
    return Judgement("sigma", frame, limbs, np.ones(count, bool), np.full(count, 0.25), errors=None)


def test_medians_are_taken_over_the_frames_that_all_runs_have():
    a, b = entry("a"), entry("b")
    judgements = {id(a): judgement(0, 10, 1.0), id(b): judgement(4, 10, 3.0)}
    found = compared((b, a), a, judgements, None)
    assert found.runs == ("a", "b")
    assert "6 frames" in found.words
    rows = {label: values for _, label, values in found.rows}
    assert rows["torso [°]"] == (7.5, 9.5)
    assert rows["unexplained [%]"] == (25.0, 25.0)
    assert "arms lost [%]" not in rows


def test_a_selection_and_hidden_runs_are_left_out():
    a, b = entry("a"), entry("b")
    b.visible = False
    judgements = {id(a): judgement(0, 10, 1.0), id(b): judgement(4, 10, 3.0)}
    found = compared((a, b), a, judgements, range(2, 5))
    assert found.runs == ("a",)
    assert {label: v for _, label, v in found.rows}["torso [°]"] == (4.0,)
    assert compared((a, b), a, {}, None) is None


def test_runs_without_a_common_frame_say_so():
    a, b = entry("a"), entry("b")
    judgements = {id(a): judgement(0, 4, 1.0), id(b): judgement(4, 4, 3.0)}
    found = compared((a, b), a, judgements, None)
    assert found.words == "These runs have no frame in common."
    assert all(np.isnan(values[0]) for limb, _, values in found.rows if limb)


@pytest.mark.window
def test_the_panel_says_differences_and_nothing_where_nothing_is(qtbot, qapp):
    apply_theme(qapp, "dark")
    panel = ComparisonPanel()
    qtbot.addWidget(panel)
    panel.show_numbers("words", ("a", "b"), (("torso", "torso [°]", (7.5, 6.0)),))
    assert panel.table.item(0, 2).text() == "6.0   (-1.5)"
    assert panel.table.item(0, 1).text() == "7.5"
    panel.show_numbers("words", ("a", "b"), (("", "arms lost [%]", (np.nan, 6.0)),))
    assert panel.table.item(0, 1).text() == "not known"
    assert panel.table.item(0, 2).text() == "6.0"
    panel.show_numbers("", (), ())
    assert panel.table.isHidden()
