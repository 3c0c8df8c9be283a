"""Edges of silhouettes lie at half the height of the difference, wherever that is."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.depth.outline import difference_of, sharp_outline
from tests.depth.scenes import texture

HEIGHT, WIDTH = 120, 160
NOTHING = np.zeros((HEIGHT, WIDTH), dtype=bool)


def _wall(seed=1):
    """Textured, of middling grey."""
    return 90.0 + 0.25 * (texture(HEIGHT, WIDTH, seed=seed) - 127.0)


def _picture(body, grey, *, blur=1.2, wall=None, times=8):
    """Body given by a function of (column, row), as a lens that blurs shows it before a wall."""
    at = (np.arange(-0.5 + 0.5 / times, max(HEIGHT, WIDTH), 1.0 / times),) * 2
    u, v = np.meshgrid(at[0][: WIDTH * times], at[1][: HEIGHT * times])
    share = body(u, v).astype(float).reshape(HEIGHT, times, WIDTH, times).mean(axis=(1, 3))
    share = cv2.GaussianBlur(share, (0, 0), blur)
    mixed = share * grey + (1.0 - share) * (_wall() if wall is None else wall)
    return np.rint(mixed).clip(0, 255).astype(np.uint8)


def _empty():
    return np.rint(_wall()).astype(np.uint8)


def _disc(radius, middle=(80.3, 60.7)):
    return lambda u, v: np.hypot(u - middle[0], v - middle[1]) < radius


def _mean_radius(found):
    return float(np.sqrt(found.sum() / np.pi))


def _found(picture, foreground=NOTHING):
    return sharp_outline(difference_of(picture, _empty()), foreground)


@given(
    radius=st.floats(12.0, 45.0),
    grey=st.sampled_from([20.0, 160.0, 200.0, 250.0]),
    blur=st.floats(0.6, 1.8),
)
def test_the_edge_of_a_blurred_body_is_where_the_body_ends(radius, grey, blur):
    found = _found(_picture(_disc(radius), grey, blur=blur))
    assert _mean_radius(found) == pytest.approx(radius, abs=0.7)


@given(edge=st.floats(60.0, 100.0), slope=st.floats(0.1, 0.4), leans=st.sampled_from([-1, 1]))
def test_a_straight_edge_is_right_in_every_row(edge, slope, leans):
    slope *= leans
    found = _found(_picture(lambda u, v: u < edge + slope * (v - 60.0), 210.0))
    rows = np.arange(5, HEIGHT - 5)
    off = found[rows].sum(axis=1) - 0.5 - (edge + slope * (rows - 60.0))
    assert abs(off.mean()) < 0.7
    assert abs(off).max() < 1.7


def test_strong_and_weak_differences_end_at_the_same_place():
    weak, strong = (_mean_radius(_found(_picture(_disc(30.0), grey))) for grey in (145.0, 255.0))
    assert weak == pytest.approx(strong, abs=0.7)


def test_a_place_where_the_body_looks_like_the_wall_is_closed():
    picture = _picture(_disc(30.0), 200.0)
    like_wall = _disc(4.0)(*np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)))
    picture[like_wall] = _empty()[like_wall]
    found = _found(picture)
    assert found[like_wall].all()
    assert _mean_radius(found) == pytest.approx(30.0, abs=0.7)


def test_a_wide_gap_between_arm_and_body_stays_open():
    ring = lambda u, v: _disc(40.0)(u, v) & ~_disc(15.0)(u, v)  # noqa: E731
    found = _found(_picture(ring, 200.0))
    assert not found[61, 80]
    assert found.sum() == pytest.approx(np.pi * (40.0**2 - 15.0**2), rel=0.04)


def test_specks_are_nobody():
    picture = _empty().copy()
    for row, column in ((20, 30), (60, 100), (100, 140)):
        picture[row, column] += 60
    assert not _found(picture).any()
    picture[60, 100] = 255
    assert _found(picture).sum() <= 9


def test_noise_of_a_camera_is_nobody():
    noise = np.random.default_rng(7).normal(scale=2.0, size=(HEIGHT, WIDTH))
    picture = np.rint(_wall() + noise).astype(np.uint8)
    assert _found(picture).mean() < 0.002


def test_what_stereo_sees_well_inside_its_own_edge_counts():
    wide = np.zeros((HEIGHT, WIDTH), dtype=bool)
    wide[30:90, 50:110] = True
    found = _found(_empty(), wide)
    assert found[60, 80]
    rows, columns = np.flatnonzero(found.any(axis=1)), np.flatnonzero(found.any(axis=0))
    assert (rows[0], rows[-1], columns[0], columns[-1]) == (34, 85, 54, 105)


def test_stereo_does_not_widen_what_the_picture_shows():
    picture, widened = _picture(_disc(30.0), 200.0), np.zeros((HEIGHT, WIDTH), dtype=np.uint8)
    cv2.circle(widened, (80, 61), 34, 1, -1)
    found = _found(picture, widened.astype(bool))
    assert _mean_radius(found) == pytest.approx(30.0, abs=0.7)
