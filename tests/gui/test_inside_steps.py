"""Steps, words, numbers and drawings of the inside of a frame, without a window."""

import numpy as np
import pytest

from app.features.inspect.contents import content_of
from app.features.inspect.controller import drawing_of
from app.session.inspection import name_of, steps_of
from stereotrack_core.body.model import landmarks
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.tracking.arm_search.arms import LEFT, with_arm
from tests.tracking.test_trace import followed

KINDS = ("thesis", "fast", "scalar")


@pytest.fixture(scope="module")
def traces():
    found = {}
    for kind in KINDS:
        tracker, cloud = followed(kind)
        found[kind] = tracker.explain(cloud), cloud
    return found


def contents(trace, kind):
    return [content_of(trace, step) for step in steps_of(trace) if step.kind == kind]


@pytest.mark.parametrize("kind", KINDS)
def test_every_step_has_words_a_source_and_something_to_see(traces, kind):
    trace, cloud = traces[kind]
    steps = steps_of(trace)
    assert steps[0].kind == "predict"
    assert steps[-1].kind == "result"
    for step in steps:
        content, drawing = content_of(trace, step), drawing_of(trace, step, cloud)
        assert content.title == drawing.words == name_of(step, trace)
        assert 1 <= step.words.count(". ") + 1 <= 3, "one or two plain sentences"
        assert step.source
        assert content.tables
        for table in content.tables:
            assert {len(row) for row in table.rows} <= {len(table.headings)}
            assert not table.limbs or len(table.limbs) == len(table.rows)
            assert not table.tips or len(table.tips) == len(table.headings)
        marked = (*drawing.scene.lines, *drawing.scene.dots)
        assert all(np.isfinite(each.places).all() for each in marked)


def test_the_true_arms_stand_in_the_table_with_a_verdict():
    tracker, cloud = followed("accurate")
    pose = with_arm(tracker.pose, LEFT, np.array([-1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    trace = tracker.explain(cloud, landmarks(tracker.setup.body, pose))
    (content,) = contents(trace, "search")
    names = [row[0] for row in content.tables[0].rows]
    assert names[1:3] == ["reference", "reference, refined"]
    assert "true arms cost" in content.words, "arms that are not there cannot be cheaper"
    assert "itself never sees them" in content.words
    assert content.parameters == reason_of(trace.search).parameters != ()
    (without,) = contents(tracker.explain(cloud), "search")
    assert "reference" not in [row[0] for row in without.tables[0].rows]
    assert without.parameters == ()


def test_correlations_are_the_cross_covariance_over_both_deviations(traces):
    trace, _ = traces["thesis"]
    first = trace.corrections[0]
    table = contents(trace, "cross")[0].tables[0]
    shown = np.array([[float(value) for value in row[1:]] for row in table.rows])
    correlation = first.P_xz / np.outer(first.before.sigma, np.sqrt(first.P_zz))
    row, column = np.unravel_index(np.argmax(np.abs(correlation)), correlation.shape)
    part = np.unique(first.points.part).tolist().index(first.points.part[column])
    assert shown[row, part] == pytest.approx(correlation[row, column], abs=0.005)
    assert np.abs(shown).max() <= 1.0


def test_what_pulls_adds_up_to_the_correction(traces):
    trace, _ = traces["fast"]
    correction = trace.corrections[-1]
    table = next(t for t in contents(trace, "correct")[-1].tables if t.title == "Contribution")
    names = [row[0] for row in table.rows]
    assert names[:2] == ["measured points", "prior (prediction)"]
    points = correction.gain @ correction.points.residual
    assert table.rows[0][1] == f"{1e3 * np.linalg.norm(points[:3]):.1f} mm"
