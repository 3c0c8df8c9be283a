"""Steps, words, numbers and drawings of the inside of a frame, without a window."""

import re

import numpy as np
import pytest

from app.features.inspect.contents import content_of
from app.features.inspect.drawing import drawing_of
from app.features.inspect.steps import name_of, steps_of
from stereotrack_core.tracking.inspection import look_inside
from tests.tracking.test_trace import followed

KINDS = ("thesis", "fast", "scalar")


@pytest.fixture(scope="module")
def traces():
    found = {}
    for kind in KINDS:
        tracker, cloud = followed(kind)
        found[kind] = look_inside(tracker, cloud), cloud
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
        assert content.map is not None or content.tables
        for table in content.tables:
            assert {len(row) for row in table.rows} <= {len(table.headings)}
            assert not table.limbs or len(table.limbs) == len(table.rows)
            assert not table.tips or len(table.tips) == len(table.headings)
        shown = content.map
        if shown is not None:
            assert shown.values.shape == (len(shown.rows), sum(n for _, _, n in shown.groups))
            assert np.abs(shown.values).max() <= 1.0 + 1e-6
            assert shown.words(0, 0)
        marked = (*drawing.scene.lines, *drawing.scene.dots)
        assert all(np.isfinite(each.places).all() for each in marked)


def test_the_map_says_the_numbers_it_shows(traces):
    trace, _ = traces["thesis"]
    first = trace.corrections[0]
    correlation = contents(trace, "cross")[0].map
    row, column = 7, int(np.argmax(np.abs(first.P_xz[7])))
    expected = first.P_xz[row, column] * np.degrees(1.0) * 1e3
    said = correlation.words(row, column)
    shown = float(re.search(r"P_xz (\S+) ° mm", said).group(1))
    assert shown == pytest.approx(expected, rel=0.01)
    sigma = np.sqrt(first.P_zz[column] * first.before.P[row, row])
    assert correlation.values[row, column] == pytest.approx(first.P_xz[row, column] / sigma)
    assert f"correlation {first.P_xz[row, column] / sigma:+.2f}" in said


def test_what_pulls_adds_up_to_the_correction(traces):
    trace, _ = traces["fast"]
    correction = trace.corrections[-1]
    table = next(t for t in contents(trace, "correct")[-1].tables if t.title == "Contribution")
    names = [row[0] for row in table.rows]
    assert names[:2] == ["measured points", "prior (prediction)"]
    points = correction.gain @ correction.points.residual
    assert table.rows[0][1] == f"{1e3 * np.linalg.norm(points[:3]):.1f} mm"
