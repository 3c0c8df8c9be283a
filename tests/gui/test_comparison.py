"""Runs beside each other in numbers, in their panel and over a selection."""

import numpy as np
import pytest

from app.features.track.comparison import compared, compared_stretches
from app.session.judgement import judged, recorded_truth
from app.session.runs import RunEntry, frames_of_run
from app.widgets.style.theme import apply_theme
from app.widgets.tables.panels import ComparisonPanel
from app.widgets.tables.table import Cell
from stereotrack_core.body.angles import ALL_JOINTS, state_names
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.evaluation.compare import Candidate, compare
from stereotrack_core.recording.description import Segment
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
        _, first, second, difference, _ = row
        assert first.text == f"{measure.first_mean:.1f}"
        assert second.text == f"{measure.second_mean:.1f}"
        change = "" if measure.equal else f"{measure.difference:+z.1f} ("
        assert difference.text.startswith(change)
        assert bool(second.colour) == measure.differs
    verdicts = {row[0].text: row[-1].text for row in found.rows}
    assert verdicts["forearms [°]"].startswith("b is better by ")
    assert "consecutive frames" in found.how


def test_a_selection_limits_what_is_compared(truth):
    entries = [entry("a", stored(0.04)), entry("b", stored(0.02))]
    judgement = judged(entries[0].now(), truth)
    assert "in the selection" in compared(entries, judgement, range(20, 40)).words
    alone = compared(entries[:1], judgement, range(20, 40))
    assert alone.runs == ("a",)
    assert len(alone.rows[0]) == 2
    assert alone.how == ""


def test_named_stretches_have_rows_each(truth):
    entries = [entry("a", stored(0.04)), entry("b", stored(0.02))]
    judgement = judged(entries[0].now(), truth)
    segments = (Segment("fast", 20, 40), Segment("slow", 50, 90), Segment("fast", 60, 80))
    both = compared_stretches(entries, judgement, segments)
    names = ["upper arms [°]", "forearms [°]", "arm segments lost [%]", "unexplained fraction [%]"]
    expected = [f"{stretch}: {name}" for stretch in ("fast", "slow") for name in names]
    assert [row[0].text for row in both.rows] == expected
    inside = np.concatenate([np.arange(20, 40), np.arange(60, 80)])
    candidates = [Candidate(one.name, one.trajectory()) for one in entries]
    pair = compare(candidates, truth.trajectory, inside).pairs[0]
    core = {one.measure.name: one for one in pair.measures}
    assert both.rows[1][1].text == f"{core['forearms'].first_mean:.1f}"
    alone = compared_stretches(entries[:1], judgement, segments)
    assert [row[0].text for row in alone.rows] == expected
    assert alone.rows[1][1].text == both.rows[1][1].text
    nowhere = compared_stretches(entries, judgement, (Segment("gone", 900, 950),))
    assert (nowhere.rows, nowhere.words[:22]) == ((), "The named stretches ha")


def test_without_a_reference_it_is_told_how_far_runs_are_apart():
    entries = [entry("a", stored(0.0)), entry("b", stored(0.02))]
    found = compared(entries, judged(entries[0].now(), None), None)
    labels = [row[0].text for row in found.rows]
    assert "difference: forearms [°]" in labels
    assert not any(label.startswith("forearms") for label in labels)
    apart = found.rows[labels.index("difference: forearms [°]")]
    assert apart[1].text == ""
    assert float(apart[2].text) > 1.0


def test_of_more_runs_the_difference_stands_in_brackets(truth):
    entries = [
        entry(name, stored(sigma)) for name, sigma in zip("abc", (0.04, 0.02, 0.04), strict=True)
    ]
    found = compared(entries, judged(entries[0].now(), truth), None)
    (_, first, better, same), *_ = (r for r in found.rows if r[0].text == "forearms [°]")
    assert better.text.startswith(f"{float(better.text.split()[0]):.1f} (-")
    assert (better.colour, same.colour, first.colour) == ("good", "", "")
    assert (same.text, better.tip[:15]) == (first.text, "B is better by ")


@pytest.mark.window
def test_the_panel_says_nothing_where_nothing_is(qtbot, qapp):
    apply_theme(qapp, "dark")
    panel = ComparisonPanel()
    qtbot.addWidget(panel)
    row = [Cell(text) for text in ("torso [°]", "7.5", "6.0", "-1.5 (-2.0 to -1.0)", "b is better")]
    panel.show_numbers("words", ("a", "b"), (row,), "how it is made")
    assert panel.table.cells.columnCount() == 5
    assert panel.words.toolTip() == "how it is made"
    assert not panel._colours.isHidden()
    assert "Green is lower than the first run" in panel._colours.text()
    panel.show_numbers("", (), ())
    assert panel.table.isHidden()
    assert panel._colours.isHidden(), "nothing is coloured"
