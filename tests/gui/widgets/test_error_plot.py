import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtWidgets import QApplication

from app.widgets.plots.limb_plots import ErrorPlot, next_crossing, thinned
from app.widgets.plots.plots import Curve
from app.widgets.style.colours import EXTRA_COLOURS, LIMB_COLOURS
from app.widgets.timeline.lanes import Lane
from app.widgets.timeline.timeline_view import TimelineView
from stereotrack_core.body.limbs import LIMBS
from tests.gui.hands import wheel_event

LEFT = Qt.MouseButton.LeftButton


def curve(limb, value, style="solid", name="accurate"):
    value = np.asarray(value, dtype=float)
    colour = (LIMB_COLOURS | EXTRA_COLOURS)[limb]
    return Curve(name, limb, colour, style, np.arange(len(value)), value)


def curves_of(frames):
    rng = np.random.default_rng(0)
    return [
        curve(limb, rng.uniform(2, 20, frames), style, name)
        for name, style in (("accurate", "solid"), ("thesis", "dash"))
        for limb in LIMBS
    ]


@pytest.fixture
def plot(shown):
    visited, dragged, zoomed = [], [], []
    widget = ErrorPlot(visited.append, dragged.append, lambda *ends: zoomed.append(ends))
    widget.visited, widget.dragged, widget.zoomed = visited, dragged, zoomed
    widget.set_curves(curves_of(490))
    return shown(widget, 900, 240)


def position(plot, frame, value):
    point = plot._plot.mapFromScene(plot._box.mapViewToScene(QPointF(frame, value)))
    return QPoint(round(point.x()), round(point.y()))


@given(
    frames=st.integers(1, 4000),
    columns=st.integers(1, 300),
    first=st.floats(-50, 4000),
    width=st.floats(1, 4000),
)
@settings(max_examples=80, deadline=None)
def test_thinning_keeps_the_peaks_that_are_visible(frames, columns, first, width):
    frame = np.arange(frames)
    value = np.random.default_rng(frames).normal(size=frames)
    value[frames // 3 : frames // 2] = np.nan
    x, y = thinned(frame, value, first, first + width, columns)
    assert len(x) == len(y) <= max(4 * columns, 2 * (columns + 2)) + 4
    visible = value[(frame >= first) & (frame <= first + width)]
    if np.isfinite(visible).any():
        assert np.nanmax(y) >= np.nanmax(visible)
        assert np.nanmin(y) <= np.nanmin(visible)


def test_gap_stays_a_gap_after_thinning():
    value = np.ones(10_000)
    value[4000:6000] = np.nan
    x, y = thinned(np.arange(10_000), value, 0, 10_000, 500)
    inside = (x > 4050) & (x < 5950)
    assert np.isnan(y[inside]).all()
    assert np.isfinite(y[(x < 3950) | (x > 6050)]).all()


def test_crossings_go_from_stretch_to_stretch():
    value = np.zeros(100)
    value[10:15] = 60.0
    value[40] = 60.0
    value[70:80] = np.nan
    curves = [curve("head", value)]
    assert next_crossing(curves, 45.0, 0, 1) == 10
    assert next_crossing(curves, 45.0, 10, 1) == 40
    assert next_crossing(curves, 45.0, 40, 1) is None
    assert next_crossing(curves, 45.0, 40, -1) == 10
    assert next_crossing(curves, 45.0, 13, -1) == 10
    assert next_crossing(curves, 90.0, 0, 1) is None
    assert next_crossing([], 45.0, 0, 1) is None


class TestPlot:
    def test_click_goes_to_the_frame(self, qtbot, plot):
        qtbot.mouseClick(plot._plot.viewport(), LEFT, pos=position(plot, 213, 10))
        assert plot.visited == [pytest.approx(213, abs=1)]

    def test_threshold_can_be_dragged(self, qtbot, plot):
        plot.set_threshold(12.0)
        port = plot._plot.viewport()
        start, end = position(plot, 100, 12.0), position(plot, 100, 6.0)
        qtbot.mouseMove(port, start)
        qtbot.wait(20)  # pyqtgraph passes over moves that come faster than 100 a second
        qtbot.mousePress(port, LEFT, pos=start)
        for share in (0.3, 0.6, 1.0):
            qtbot.mouseMove(port, start + (end - start) * share)
            qtbot.wait(20)
        qtbot.mouseRelease(port, LEFT, pos=end)
        assert 0 <= plot.dragged[0] < 12.0
        assert plot.threshold == pytest.approx(6.0, abs=1.0)

    def test_hovering_says_value_and_limb_of_the_nearest_curve_and_marks_its_frame(self, plot):
        high, low = np.full(490, 15.0), np.full(490, 4.0)
        plot.set_curves([curve("left_forearm", high), curve("torso", low, name="thesis")])
        hovered = []
        plot.hovered.connect(hovered.append)
        plot.hovered.connect(plot.set_hover)
        for value, words in ((14.0, "left forearm 15.0°, accurate"), (5.0, "torso 4.0°, thesis")):
            place = plot._box.mapViewToScene(QPointF(300, value))
            plot._plot.scene().sigMouseMoved.emit(place)
            assert plot._value.toPlainText() == f"300: {words}"
        assert hovered[-1] == plot._hover.value() == 300
        plot.set_hover(20)
        assert plot._hover.value() == 20
        plot.leaveEvent(QEvent(QEvent.Type.Leave))
        assert hovered[-1] is None
        assert not plot._value.isVisible()

    def test_the_selection_is_shown(self, plot):
        plot.set_selection(range(20, 30))
        assert plot._selection.isVisible()
        assert plot._selection.getRegion() == (19.5, 29.5)
        plot.set_selection(None)
        assert not plot._selection.isVisible()

    def test_the_run_or_limb_that_the_legend_points_at_stands_alone(self, qtbot, plot):
        def solid():
            shown = zip(plot.shown_curves, plot._items, strict=True)
            return {(one.name, one.limb) for one, item in shown if item.opacity() == 1.0}

        every = {(one.name, one.limb) for one in plot.shown_curves}
        for place, names in ((0, {"accurate"}), (1, {"thesis"})):
            QApplication.sendEvent(plot.legend._labels[place][1], QEvent(QEvent.Type.Enter))
            assert {name for name, _ in solid()} == names
        QApplication.sendEvent(plot.legend.buttons["torso"], QEvent(QEvent.Type.Enter))
        assert {limb for _, limb in solid()} == {"torso"}
        QApplication.sendEvent(plot.legend.buttons["torso"], QEvent(QEvent.Type.Leave))
        assert solid() == every

    def test_crossing_obeys_threshold_and_legend(self, qtbot, plot):
        high = np.zeros(100)
        high[50] = 80.0
        plot.set_curves([curve("head", np.zeros(100)), curve("left_forearm", high)])
        plot.set_frame(0)
        assert plot.crossing(1) == 50
        plot.set_threshold(85.0)
        assert plot.crossing(1) is None
        plot.set_threshold(45.0)
        qtbot.mouseClick(plot.legend.buttons["left_forearm"], LEFT)
        assert plot.crossing(1) is None

    def test_legend_hides_limbs(self, qtbot, plot):
        button = plot.legend.buttons["head"]
        qtbot.mouseClick(button, LEFT)
        assert plot.legend.hidden_limbs == {"head"}
        assert {c.limb for c in plot.shown_curves} == set(LIMBS) - {"head"}
        plot.set_curves(curves_of(490))
        assert plot.legend.hidden_limbs == {"head"}

    def test_ctrl_and_click_shows_one_alone(self, qtbot, plot):
        button = plot.legend.buttons["head"]
        qtbot.mouseClick(button, LEFT, Qt.KeyboardModifier.ControlModifier)
        assert {c.limb for c in plot.shown_curves} == {"head"}
        qtbot.mouseClick(button, LEFT, Qt.KeyboardModifier.ControlModifier)
        assert {c.limb for c in plot.shown_curves} == set(LIMBS)

    def test_wheel_zooms_and_tells(self, qtbot, plot):
        place = QPointF(position(plot, 245, 5))
        plot._plot.wheelEvent(wheel_event(plot._plot.viewport(), place, 3))
        first, last = plot.zoomed[-1]
        assert 0 < first < 245 < last < 490

    def test_zoom_is_set_in_silence_and_kept(self, qtbot, plot):
        plot.zoomed.clear()
        plot.set_visible_range(100, 200)
        plot.set_curves(curves_of(490))
        plot.set_curves(curves_of(495))
        assert not plot.zoomed
        assert plot._box.viewRange()[0] == pytest.approx([99.5, 199.5])
        qtbot.keyClick(plot, Qt.Key.Key_0)
        assert plot.zoomed[-1] == (0, 495)
        assert plot._box.viewRange()[0] == pytest.approx([-0.5, 494.5])

    @pytest.mark.parametrize("lanes", [1, 12])
    def test_frames_stand_over_those_of_the_timeline(self, qapp, plot, shown, lanes):
        timeline = TimelineView()
        timeline.set_range(490, 10.0)
        lane = Lane("left upper arm error", "#0072B2", "heat", np.zeros(490))
        timeline.set_lanes([lane] * lanes)
        shown(timeline, 900, 120)
        assert timeline.verticalScrollBar().isVisible() == (lanes > 1)
        plot.set_margins(*timeline.margins)
        qapp.processEvents()
        for first, last in ((0, 490), (100, 150)):
            timeline.set_visible_range(first, last)
            plot.set_visible_range(timeline.scale.first, timeline.scale.last)
            for frame in (first, (first + last) // 2, last - 1):
                x = plot._plot.mapFromScene(plot._box.mapViewToScene(QPointF(frame, 0))).x()
                assert x == pytest.approx(timeline.scale.x_of(frame + 0.5), abs=4)

    def test_unexplained_share_is_drawn_when_asked_for_and_is_no_angle(self, plot):
        plot.set_frame(0)
        plot.set_curves([curve("torso", np.zeros(9)), curve("unexplained %", np.full(9, 80.0))])
        assert [drawn.limb for drawn in plot.shown_curves] == ["torso"]
        plot.legend.buttons["unexplained %"].click()
        assert len(plot.shown_curves) == 2
        assert plot.crossing(1) is None
