"""A histogram for each limb: in columns as wide as there is room, in the theme's colours."""

from __future__ import annotations

import numpy as np
import pytest

from app.widgets.plots.cloud_plot import CloudContent, CloudPlot
from app.widgets.plots.histograms import Steps
from app.widgets.style.theme import apply_theme, current_theme

LIMBS = ("torso", "left_forearm", "right_forearm")


@pytest.fixture
def plot(shown):
    widget = CloudPlot((("histogram", "histogram"),))
    edges, height = np.arange(0.0, 10.0), np.ones(9)
    steps = [Steps("run", 0, limb, "#ff8800", "solid", edges, k * height)
             for k, limb in enumerate(LIMBS, start=1)]  # fmt: skip
    widget.show_content(CloudContent("words", steps=tuple(steps)))
    return shown(widget, 700, 300)


def places(plot):
    return {limb: (one.x(), one.y()) for limb, one in plot.histograms.plots.items()}


def test_they_stand_beside_each_other_and_where_it_is_narrow_below(qapp, plot):
    assert len({y for _, y in places(plot).values()}) == 1
    plot.resize(220, 400)
    qapp.processEvents()
    assert len({x for x, _ in places(plot).values()}) == 1
    tops = [one.viewRange()[1][1] for one in plot.histograms.plots.values()]
    assert tops == pytest.approx([3.15] * 3), "the highest of all decides"


def test_another_theme_dresses_those_that_are_there(qapp, plot):
    before = dict(plot.histograms.plots)
    for name in ("light", "dark", "light"):
        apply_theme(qapp, name)
        qapp.processEvents()
        assert plot.histograms.plots == before
        colours = {one.getPlotItem().titleLabel.opts["color"] for one in before.values()}
        assert colours == {current_theme().text}
