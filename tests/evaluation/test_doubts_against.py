"""How right a run is about which limbs are lost."""

import numpy as np
import pytest

from stereotrack_core.evaluation.summary import LimbErrors, doubts_against


def errors(frame, degrees) -> LimbErrors:
    """Errors of the arms (F, 4): upper arms, forearms, in degrees."""
    arms = np.radians(np.asarray(degrees, dtype=float))
    nothing = np.zeros(len(frame))
    return LimbErrors(
        np.asarray(frame), nothing, nothing, nothing, arms[:, :2], arms[:, 2:],
        np.ones(len(frame), dtype=bool),
    )  # fmt: skip


def test_counts_over_the_frames_that_both_know():
    chance = np.full((4, 6), np.nan)
    chance[:, 2:] = [[0.9, 0.1, 0.1, 0.1], [0.9, 0.9, 0.1, 0.1], [0.6, 0.4, 0.2, 0.9], [1, 1, 1, 1]]
    found = doubts_against(
        np.array([3, 4, 5, 9]),
        chance,
        errors([2, 3, 4, 5], [[90] * 4, [80, 5, 5, 5], [10, 50, 60, 44], [np.nan, 46, 5, 5]]),
    )
    assert (found.judged, found.lost, found.called, found.both) == (11, 4, 4, 2)
    assert found.precision == pytest.approx(0.5)
    assert found.recall == pytest.approx(0.5)


def test_nothing_is_known_of_a_run_that_does_not_say():
    found = doubts_against(np.arange(3), np.full((3, 6), np.nan), errors(range(3), [[90] * 4] * 3))
    assert found.judged == 0
    assert np.isnan([found.precision, found.recall]).all()
