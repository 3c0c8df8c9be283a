import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt

from app.widgets.style.colours import LIMB_COLOURS
from app.widgets.timeline.lanes import Lane, Mark, Span
from app.widgets.timeline.painting import RULER_HEIGHT
from app.widgets.timeline.timeline_view import TimelineView
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui.hands import wheel_event

LEFT = Qt.MouseButton.LeftButton


def lanes_of(frames):
    rng = np.random.default_rng(0)
    marks = np.full(frames, Mark.INTERPOLATED)
    marks[::10] = Mark.CLICKED
    lanes = [Lane(name, "#0072B2", "marks", marks.copy()) for name in LANDMARKS]
    lanes += [
        Lane(limb, LIMB_COLOURS[limb], "heat", rng.uniform(0, 90, frames), 90.0, "deg")
        for limb in LIMBS
    ]
    spans = tuple(Span(k, k + 5, "arms crossed") for k in range(0, frames, 50))
    return [*lanes, Lane("failures", "#CC79A7", "bars", spans)]


@pytest.fixture
def timeline(shown):
    view = TimelineView()
    view.set_range(490, 10.0)
    view.set_lanes(lanes_of(490))
    return shown(view, 1000, 330)


def at(view, frame, y=RULER_HEIGHT + 5):
    return QPoint(round(view.scale.x_of(frame + 0.5)), y)


def drag(qtbot, view, start, end, y=RULER_HEIGHT + 5, modifier=Qt.KeyboardModifier.NoModifier):
    port = view.viewport()
    qtbot.mousePress(port, LEFT, modifier, at(view, start, y))
    for frame in np.linspace(start, end, 5).round().astype(int)[1:]:
        qtbot.mouseMove(port, at(view, int(frame), y))
    qtbot.mouseRelease(port, LEFT, modifier, at(view, end, y))


def wheel(view, x, steps):
    view.wheelEvent(wheel_event(view.viewport(), QPointF(x, 100), steps))


def colour_at(view, position):
    return view.viewport().grab().toImage().pixelColor(position)


class TestScrubbing:
    def test_click_goes_to_the_frame(self, qtbot, timeline):
        with qtbot.waitSignal(timeline.frame_requested) as caught:
            qtbot.mouseClick(timeline.viewport(), LEFT, pos=at(timeline, 213))
        assert caught.args == [213]
        assert timeline.frame == 213

    def test_drag_scrubs(self, qtbot, timeline):
        requested = []
        timeline.frame_requested.connect(requested.append)
        drag(qtbot, timeline, 100, 140)
        assert requested == [100, 110, 120, 130, 140]
        assert timeline.selection is None

    def test_playhead_is_seen_at_its_frame(self, timeline, dark):
        for frame in (30, 400):
            timeline.set_frame(frame)
            image = timeline.viewport().grab().toImage()
            x = round(timeline.scale.x_of(frame + 0.5))
            names = {image.pixelColor(x + d, 300).name() for d in (-1, 0, 1)}
            assert names & {dark.playhead}
            assert image.pixelColor(x + 20, 300).name() != dark.playhead

    def test_keys_step_by_seconds(self, qtbot, timeline):
        timeline.set_frame(200)
        with qtbot.waitSignal(timeline.frame_requested) as caught:
            qtbot.keyClick(timeline, Qt.Key.Key_PageUp)
        assert caught.args == [190]


class TestSelection:
    def test_drag_in_the_ruler_selects(self, qtbot, timeline):
        drag(qtbot, timeline, 300, 240, y=10)
        assert timeline.selection == range(240, 301)

    def test_shift_and_drag_selects_and_leaves_the_playhead(self, qtbot, timeline):
        timeline.set_frame(5)
        with qtbot.waitSignal(timeline.selection_changed):
            drag(qtbot, timeline, 100, 180, modifier=Qt.KeyboardModifier.ShiftModifier)
        assert timeline.selection == range(100, 181)
        assert timeline.frame == 5

    def test_click_in_the_ruler_seeks_and_clears(self, qtbot, timeline):
        timeline.set_selection(range(10, 20))
        with qtbot.waitSignals([timeline.selection_changed, timeline.frame_requested]):
            qtbot.mouseClick(timeline.viewport(), LEFT, pos=at(timeline, 321, 10))
        assert timeline.selection is None
        assert timeline.frame == 321

    def test_keys_set_and_clear_it(self, qtbot, timeline):
        timeline.set_frame(100)
        qtbot.keyClick(timeline, Qt.Key.Key_BracketLeft)
        assert timeline.selection == range(100, 490)
        timeline.set_frame(150)
        qtbot.keyClick(timeline, Qt.Key.Key_BracketRight)
        assert timeline.selection == range(100, 151)
        with qtbot.waitSignal(timeline.selection_changed) as caught:
            qtbot.keyClick(timeline, Qt.Key.Key_Escape)
        assert caught.args == [None]


class TestZoom:
    def test_wheel_zooms_at_the_cursor(self, qtbot, timeline):
        x = at(timeline, 213).x()
        with qtbot.waitSignal(timeline.visible_range_changed):
            wheel(timeline, x, 8)
        assert timeline.scale.visible < 200
        assert timeline.scale.frame_at(x) == 213

    def test_page_turns_with_the_playhead(self, timeline):
        timeline.set_visible_range(100, 150)
        timeline.set_frame(320)
        assert timeline.scale.first <= 320 < timeline.scale.last
        assert timeline.scale.visible == pytest.approx(50)

    def test_keys(self, qtbot, timeline):
        timeline.set_frame(213)
        for _ in range(4):
            qtbot.keyClick(timeline, Qt.Key.Key_Plus)
        assert timeline.scale.first < 213 < timeline.scale.last < 490
        qtbot.keyClick(timeline, Qt.Key.Key_0)
        assert timeline.scale == timeline.scale.whole()

    def test_more_lanes_than_room_scroll(self, qapp, timeline):
        timeline.resize(1000, 150)
        qapp.processEvents()
        assert timeline.lane_at(RULER_HEIGHT + 1).name == LANDMARKS[0]
        bar = timeline.verticalScrollBar()
        assert bar.maximum() > 0
        bar.setValue(2 * timeline.lane_height)
        assert timeline.lane_at(RULER_HEIGHT + 1).name == LANDMARKS[2]


class TestLanes:
    def test_tooltip_has_frame_time_and_value(self, timeline):
        y = RULER_HEIGHT + 15 * timeline.lane_height + 5
        text = timeline.tooltip_at(QPointF(at(timeline, 52, y)))
        assert text == "frame 52   5.20 s\nfailures: arms crossed"
        y = RULER_HEIGHT + 5
        assert "left_shoulder: clicked" in timeline.tooltip_at(QPointF(at(timeline, 40, y)))

    def test_click_on_a_name_says_it(self, qtbot, timeline):
        with qtbot.waitSignal(timeline.lane_clicked) as caught:
            position = QPoint(20, RULER_HEIGHT + timeline.lane_height + 5)
            qtbot.mouseClick(timeline.viewport(), LEFT, pos=position)
        assert caught.args == [LANDMARKS[1]]

    def test_ctrl_and_click_on_names_selects_lanes(self, qtbot, timeline):
        control = Qt.KeyboardModifier.ControlModifier
        for row in (0, 2):
            place = QPoint(20, RULER_HEIGHT + row * timeline.lane_height + 5)
            qtbot.mouseClick(timeline.viewport(), LEFT, control, place)
        assert timeline.selected_lanes == {LANDMARKS[0], LANDMARKS[2]}
        height = timeline.lane_height
        shown, other = (QPoint(3, RULER_HEIGHT + row * height + 5) for row in (0, 1))
        assert colour_at(timeline, shown) != colour_at(timeline, other)
        with qtbot.waitSignal(timeline.lanes_selected) as caught:
            qtbot.keyClick(timeline, Qt.Key.Key_Escape)
        assert caught.args == [frozenset()]

    def test_up_and_down_select_lanes(self, qtbot, timeline):
        shift = Qt.KeyboardModifier.ShiftModifier
        qtbot.keyClick(timeline, Qt.Key.Key_Down)
        assert timeline.selected_lanes == {LANDMARKS[0]}
        qtbot.keyClick(timeline, Qt.Key.Key_Down)
        qtbot.keyClick(timeline, Qt.Key.Key_Down, shift)
        assert timeline.selected_lanes == {LANDMARKS[1], LANDMARKS[2]}
        qtbot.keyClick(timeline, Qt.Key.Key_Up)
        assert timeline.selected_lanes == {LANDMARKS[0]}
        qtbot.keyClick(timeline, Qt.Key.Key_Up)
        assert timeline.selected_lanes == {LANDMARKS[0]}

    def test_what_was_clicked_in_few_views_and_gaps_look_different(self, timeline):
        pictures = []
        for mark in (Mark.CLICKED, Mark.PARTLY, Mark.GAP, Mark.NONE, Mark.MISSING):
            lane = Lane("left elbow", "#0072B2", "marks", np.full(490, mark, dtype=np.uint8))
            timeline.set_lanes([lane])
            port = timeline.viewport().grab().toImage()
            left, top = int(timeline.scale.left) + 200, RULER_HEIGHT
            strip = port.copy(left, top, 40, timeline.lane_height - 2)
            pictures.append(bytes(strip.constBits()))
        assert len(set(pictures)) == 5

    def test_one_bad_frame_among_many_is_seen(self, timeline):
        values = np.zeros(100_000)
        values[43_210] = 90.0
        timeline.set_range(100_000, 10.0)
        timeline.set_lanes([Lane("error", "#D55E00", "heat", values, 90.0)])
        image = timeline.viewport().grab().toImage()
        x = int(timeline.scale.x_of(43_210))
        assert max(image.pixelColor(x + d, RULER_HEIGHT + 5).lightness() for d in (-1, 0, 1)) > 180

    def test_nothing_open_is_painted_and_takes_keys(self, qtbot, shown):
        view = shown(TimelineView(), 500, 120)
        with qtbot.assertNotEmitted(view.frame_requested):
            qtbot.keyClick(view, Qt.Key.Key_PageDown)
            qtbot.mouseClick(view.viewport(), LEFT, pos=QPoint(300, 60))
            wheel(view, 300, 1)
        assert not view.grab().isNull()
