import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.widgets.style.theme import load_theme
from app.widgets.timeline.lanes import Lane, Mark, Span, TimelineScale
from app.widgets.timeline.painting import heat_colours, strip_pixels

THEME = load_theme("dark")


@given(length=st.integers(1, 3000), columns=st.integers(1, 200), seed=st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_no_value_is_lost_and_none_invented(length, columns, seed):
    rng = np.random.default_rng(seed)
    values = rng.normal(size=length)
    values[rng.random(length) < 0.2] = np.nan
    lane = Lane("a", "#0072B2", "heat", values)
    seen = lane.columns(np.linspace(0, length, columns + 1))
    assert np.isin(seen[~np.isnan(seen)], values).all()
    if not np.isnan(values).all():
        assert np.nanmax(seen) == np.nanmax(values)
    else:
        assert np.isnan(seen).all()


def test_marks_of_a_column_are_all_kept():
    marks = np.zeros(1000, dtype=int)
    marks[[100, 101]] = Mark.CLICKED, Mark.FLAGGED
    bits = Lane("head", "#009E73", "marks", marks).columns(np.linspace(0, 1000, 11))
    assert bits[1] == (1 << Mark.CLICKED) | (1 << Mark.FLAGGED)
    assert not bits[3:].any()


@pytest.mark.parametrize(
    ("spans", "columns"),
    [((Span(10, 19), Span(55, 55), Span(90, 500)), [1, 5, 9]), ((), []), ((Span(200, 300),), [])],
)
def test_spans_cover_their_columns(spans, columns):
    lane = Lane("failures", "#0072B2", "bars", spans)
    pixels = strip_pixels(lane, np.linspace(0, 100, 11), 12, THEME)
    middle = pixels[6, :, :3].tolist()
    assert [k for k in range(10) if middle[k] == [0x00, 0x72, 0xB2]] == columns


def test_heat_becomes_lighter_with_the_value():
    values = np.array([0.0, 20.0, 45.0, 90.0, 500.0, np.nan])
    colours = heat_colours(values, 90.0, "#0072B2", THEME)
    light = colours[:, :3].astype(int).sum(axis=1)
    assert (np.diff(light[:4]) > 0).all()
    assert light[3] == light[4]
    assert colours[5, 3] == 0


def test_words_for_a_frame():
    heat = Lane("a", "#0072B2", "heat", np.array([32.14, np.nan]), unit="deg")
    assert heat.value_text(0) == "32.1 deg"
    assert heat.value_text(1) == "unknown"
    assert heat.value_text(7) == ""
    assert Lane("a", "#000000", "marks", np.array([Mark.FLAGGED])).value_text(0) == "flagged"
    bars = Lane("failures", "#000000", "bars", (Span(3, 5, "arms crossed"),))
    assert [bars.value_text(k) for k in (2, 3, 5, 6)] == ["", "arms crossed", "arms crossed", ""]


class TestScale:
    scale = TimelineScale(frame_count=1000, left=100.0, width=800.0).whole()

    def test_frames_and_positions_agree(self):
        for scale in (self.scale, self.scale.zoomed(20.0, 500.0)):
            for frame in range(int(scale.first) + 1, int(scale.last) - 1):
                left, right = scale.x_of(frame), scale.x_of(frame + 1)
                assert scale.frame_at((left + right) / 2) == frame

    def test_zoom_keeps_what_is_under_the_cursor(self):
        zoomed = self.scale.zoomed(8.0, 460.0)
        assert zoomed.frame_at(460.0) == self.scale.frame_at(460.0)
        assert zoomed.visible == pytest.approx(125.0)

    def test_it_never_leaves_the_recording(self):
        scale = self.scale.zoomed(10.0, 100.0).moved(-500.0)
        assert scale.first == 0.0
        assert scale.moved(1e9).last == pytest.approx(1000.0)
        assert self.scale.zoomed(1e-6, 300.0) == self.scale.whole()
        assert self.scale.zoomed(1e9, 300.0).visible >= 8.0
        assert self.scale.frame_at(-50.0) == 0
        assert self.scale.frame_at(5000.0) == 999

    @pytest.mark.parametrize("frames", [1, 10, 490, 100_000, 12_345_678])
    def test_ticks_have_room(self, frames):
        scale = TimelineScale(frame_count=frames, left=0.0, width=900.0).whole()
        ticks = scale.ticks()
        step = ticks[1] if len(ticks) > 1 else 1
        assert 1 <= len(ticks) <= 13
        assert all(tick % step == 0 for tick in ticks)
