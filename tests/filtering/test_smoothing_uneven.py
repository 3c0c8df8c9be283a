"""Smoothing of a walk that stands still most of the time."""

from __future__ import annotations

import numpy as np

from stereotrack_core.filtering.linearisation import Information
from stereotrack_core.filtering.smoothing import Walk, smooth, smooth_uneven

COUNT, NOISE = 60, 1.0


def seen(rng):
    """A state of two numbers of which the first jumps once, the walk, and its measurements."""
    true = np.zeros((COUNT, 2))
    true[COUNT // 2 :, 0] = 20.0
    z = true + NOISE * rng.normal(size=true.shape)
    walk = Walk(
        np.eye(2), np.zeros((COUNT - 1, 2)), np.ones((COUNT - 1, 2)), np.zeros(2), 1e4 * np.eye(2)
    )
    return true, walk, [Information(np.eye(2) / NOISE**2, row / NOISE**2) for row in z]


def off(found, true):
    return float(np.sqrt(np.mean((found.mean - true) ** 2)))


def test_stillness_and_a_jump_are_both_kept(rng):
    true, walk, measured = seen(rng)
    even, uneven = smooth(walk, measured), smooth_uneven(walk, measured, np.arange(2))
    assert off(uneven, true) < 0.5 * off(even, true)
    jump = uneven.mean[COUNT // 2, 0] - uneven.mean[COUNT // 2 - 1, 0]
    assert abs(jump - 20.0) < 1.5


def test_what_it_says_of_its_certainty_is_right(rng):
    true, walk, measured = seen(rng)
    found = smooth_uneven(walk, measured, np.arange(2))
    sigma = np.sqrt(np.einsum("kii->ki", found.P))
    assert (sigma > 0.0).all()
    assert np.mean(np.abs(found.mean - true) < 2.5 * sigma) > 0.9


def test_one_frame_is_a_plain_correction(rng):
    _, walk, measured = seen(rng)
    alone = Walk(walk.F, walk.c[:0], walk.Q[:0], walk.mean, walk.P)
    found = smooth_uneven(alone, measured[:1], np.arange(2))
    np.testing.assert_array_equal(found.mean, smooth(alone, measured[:1]).mean)
