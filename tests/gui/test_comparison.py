"""Runs beside each other in numbers, in their panel and over a selection."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.session.comparison import compared
from app.session.judgement import judged, recorded_truth
from app.session.runs import RunEntry, frames_of_run
from app.widgets.style.theme import apply_theme
from app.widgets.tables.runs_panel import ComparedCell, ComparedRow, ComparisonPanel
from stereotrack_core.body.angles import ALL_JOINTS, state_names
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.evaluation.compare import Candidate, compare
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run

STANDING = np.array(
    [
        *([-0.2, 0, 1.4], [0.2, 0, 1.4], [-0.5, 0, 1.4], [0.5, 0, 1.4], [-0.8, 0, 1.4]),
        *([0.8, 0, 1.4], [0, 0, 1.6], [-0.1, 0, 0.95], [0.1, 0, 0.95]),
    ]
)


def stored(sigma, first=0, end=160):
    """A run whose landmarks are off by `sigma` metres in every direction."""
    rng = np.random.default_rng(round(1000 * sigma) + first)
    names = state_names(ALL_JOINTS)
    frames, n = end - first, len(names)
    landmarks = STANDING + sigma * rng.normal(size=(frames, 9, 3))
    return Run(
        frame=np.arange(first, end),
        landmarks=landmarks,
        x=np.zeros((frames, n)),
        P=np.tile(np.eye(n), (frames, 1, 1)),
        state_names=names,
        tracked=np.ones(frames, dtype=bool),
        unexplained_fraction=rng.random(frames),
        residual=rng.random(frames),
        innovation=rng.random(frames),
        limb_sigma_deg=rng.random((frames, 6)),
        limb_lost=rng.random((frames, 6)),
        seconds=np.zeros((frames, 0)),
        stage_names=(),
        meta={},
    )


def entry(name, run):
    body = body_model(proportions_of(None))
    return RunEntry(name, "accurate", None, body, range(10), frames_of_run(run), stored=run)


@pytest.fixture(scope="module")
def truth():
    return recorded_truth(LandmarkTrajectory(np.arange(200), np.tile(STANDING, (200, 1, 1))))


def test_the_panel_says_what_the_command_line_says(truth):
    runs = stored(0.04), stored(0.02, 10, 200)
    entries = [entry(name, run) for name, run in zip("ab", runs, strict=True)]
    found = compared(entries, judged(entries[0].now(), truth), None)
    core = compare(
        [
            Candidate(n, r.trajectory(), r.unexplained_fraction)
            for n, r in zip("ab", runs, strict=True)
        ],
        truth.trajectory,
    )
    assert found.runs == ("a", "b")
    assert "150 frames" in found.words
    assert "the recording's reference" in found.words
    assert len(found.rows) == len(core.pairs[0].measures)
    for row, measure in zip(found.rows, core.pairs[0].measures, strict=True):
        first, second = row.cells
        assert (first.value, second.value) == (measure.first_mean, measure.second_mean)
        assert second.difference == measure.difference
        assert second.differs == measure.differs
    rows = {row.label: row.cells[1] for row in found.rows}
    assert rows["forearms [°]"].verdict.startswith("b is better by ")
    assert "consecutive frames" in found.how


def test_a_selection_limits_what_is_compared(truth):
    entries = [entry("a", stored(0.04)), entry("b", stored(0.02))]
    judgement = judged(entries[0].now(), truth)
    assert "in the selection" in compared(entries, judgement, range(20, 40)).words
    alone = compared(entries[:1], judgement, range(20, 40))
    assert alone.runs == ("a",)
    assert len(alone.rows[0].cells) == 1
    assert alone.how == ""


def test_without_a_reference_it_is_told_how_far_runs_are_apart():
    entries = [entry("a", stored(0.0)), entry("b", stored(0.02))]
    found = compared(entries, judged(entries[0].now(), None), None)
    labels = [row.label for row in found.rows]
    assert "difference: forearms [°]" in labels
    assert not any(label.startswith("forearms") for label in labels)
    apart = found.rows[labels.index("difference: forearms [°]")]
    assert np.isnan(apart.cells[0].value)
    assert apart.cells[1].value > 1.0


@pytest.mark.window
def test_the_panel_says_differences_and_nothing_where_nothing_is(qtbot, qapp):
    apply_theme(qapp, "dark")
    panel = ComparisonPanel()
    qtbot.addWidget(panel)
    better = ComparedCell(6.0, -1.5, -2.0, -1.0, True, "b is better by 1.5 deg (1.0 to 2.0)")
    row = ComparedRow("torso", "torso [°]", (ComparedCell(7.5), better))
    panel.show_numbers("words", ("a", "b"), (row,), "how it is made")
    assert panel.table.cells.cell(0, 1).text == "7.5"
    assert panel.table.cells.cell(0, 2).text == "6.0"
    assert panel.table.cells.cell(0, 3).text == "-1.5 (-2.0 to -1.0)"
    assert panel.table.cells.cell(0, 4).text == better.verdict
    assert panel.words.toolTip() == "how it is made"
    assert panel.table.cells.cell(0, 1).colour == ""
    assert panel.table.cells.cell(0, 2).colour == "good"
    assert not panel._colours.isHidden()
    assert "Green is lower than the first run" in panel._colours.text()
    unsure = replace(better, low=np.nan, high=np.nan, differs=False, verdict="too few")
    panel.show_numbers(
        "words", ("a", "b", "c"), (replace(row, cells=(*row.cells[:1], unsure, unsure)),)
    )
    assert panel.table.cells.cell(0, 2).text == "6.0 (-1.5)"
    assert panel.table.cells.cell(0, 2).colour == ""
    assert panel.table.cells.columnCount() == 4
    panel.show_numbers("", (), ())
    assert panel.table.isHidden()
    assert panel._colours.isHidden(), "nothing is coloured"
