"""Tables from errors that are known."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.experiments.reproduction.plan import PlannedRun
from stereotrack_core.experiments.reproduction.tables import (
    LOST,
    OF_THESIS,
    Outcome,
    compared_tables,
    fast_from,
    figure,
    in_full,
    readable,
)
from stereotrack_core.experiments.reproduction.thesis import TABLE_4_1
from stereotrack_core.recording.description import Segment

SEGMENTS = (Segment("whip", 2, 8), Segment("whip-fast", 12, 18))
PEOPLE = ("P1", "P2")


def outcome(recording, way, seed, degrees, *, fast=90.0, frames=20):
    pace = np.where(np.arange(frames) < 12, degrees, fast)
    angles = np.radians(pace)
    errors = LimbErrors(
        np.arange(frames),
        pace / 1000.0,
        angles,
        angles,
        np.stack([angles, angles], axis=1),
        np.stack([angles, angles], axis=1),
        np.ones(frames, dtype=bool),
    )
    return Outcome(recording, replace(way, seed=seed), errors, 12, SEGMENTS, "1")


def test_fast_motions_begin_with_the_first_fast_segment():
    assert fast_from(SEGMENTS, 20) == 12
    assert fast_from(SEGMENTS[:1], 20) == 20


def test_frames_are_pooled_and_seeds_give_the_spread():
    way = PlannedRun("thesis")
    outcomes = [outcome("P1", way, 0, 10.0), outcome("P1", way, 1, 14.0)]
    outcomes += [outcome("P2", way, 0, 30.0), outcome("P2", way, 1, 34.0)]
    found = figure(outcomes, "thesis", "forearms", Outcome.slow, PEOPLE)
    assert found.mean == pytest.approx(22.0)
    assert found.deviation == pytest.approx(np.sqrt(8.0))
    fast = figure(outcomes, "thesis", LOST, Outcome.fast, PEOPLE)
    assert fast.mean == pytest.approx(100.0)


def test_nothing_is_said_before_all_recordings_are_tracked():
    outcomes = [outcome("P1", PlannedRun("thesis"), 0, 10.0)]
    assert np.isnan(figure(outcomes, "thesis", "forearms", Outcome.slow, PEOPLE).mean)


@pytest.fixture
def tables():
    outcomes = [
        outcome(name, way, 0, degrees)
        for name in PEOPLE
        for way, degrees in [
            (PlannedRun("thesis"), 30.0),
            (PlannedRun("thesis", anew=True), 20.0),
            (PlannedRun("thesis", points=24), 40.0),
            (PlannedRun("accurate"), 5.0),
            (PlannedRun("accurate", few_views=True), 7.0),
        ]
    ]
    made = compared_tables(outcomes, PEOPLE, ("thesis", "accurate"))
    return {compared.key: compared for compared in made}


def lines_of(compared, measure):
    return {line.source: line.figures for line in compared.lines if line.measure == measure}


def test_the_thesis_and_all_presets_stand_below_each_other(tables):
    lines = lines_of(tables["4.1"], "forearms")
    assert list(lines) == [OF_THESIS, "preset thesis", "preset thesis, re-initialised", "accurate"]
    assert [f.mean for f in lines[OF_THESIS]] == list(TABLE_4_1.values["forearms"])
    assert lines["accurate"][-1].mean == pytest.approx(5.0)
    assert lines["preset thesis, re-initialised"][0].mean == pytest.approx(20.0)


def test_columns_stand_for_what_they_say(tables):
    points = lines_of(tables["4.2"], "upper_arms")["preset thesis"]
    assert points[0].mean == pytest.approx(40.0)
    assert points[2].mean == pytest.approx(30.0)
    assert np.isnan(points[1].mean)
    two, four = lines_of(tables["4.3"], "upper_arms")["accurate"]
    assert (two.mean, four.mean) == (pytest.approx(7.0), pytest.approx(5.0))


def test_fast_motions_have_their_own_table(tables):
    assert lines_of(tables["fast"], "forearms")["accurate"][-1].mean == pytest.approx(90.0)
    motions = {(line.label, line.source): line.figures[0].mean for line in tables["motions"].lines}
    assert motions["whip", "accurate"] == pytest.approx(5.0)
    assert motions["whip, fast", "accurate"] == pytest.approx(90.0)


def test_numbers_are_written_as_people_and_programs_read_them(tables):
    assert Spread(32.14, 0.84).text() == "32.1 ± 0.8"
    assert Spread(66.6).text(0) == "67"
    assert Spread().text() == "-"
    rows = readable(tables["4.1"]).rows
    assert rows[0][:3] == ("torso position [mm]", OF_THESIS, "65")
    assert rows[1][0] == ""
    columns, full = in_full(tables["4.2"])
    assert len(columns) == len(full[0]) == 3 + 2 * 4
    assert "" in full[1]  # not known is empty, not NaN
    assert readable(tables["4.1"]).kinds[0] == "first given"
