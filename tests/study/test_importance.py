"""Main effects of parameters over runs."""

import numpy as np
import pytest

from stereotrack_core.study.store import RunTable, effects, effects_of, effects_words

COLUMNS = ("recording", "iterations", "loss_scale", "seed", "forearms")


@pytest.fixture
def table():
    """Two recordings, one harder by 20 degrees; iterations matter much, the loss does not."""
    rng = np.random.default_rng(1)
    rows = []
    for hard, recording in ((0.0, "a"), (20.0, "b")):
        for iterations in (2, 4, 6):
            for scale in (0.02, 0.03):
                for seed in range(4):
                    value = 15.0 + hard - 2.0 * iterations + rng.normal(0.0, 1.0)
                    rows.append((recording, str(iterations), str(scale), str(seed), str(value)))
    return RunTable(COLUMNS, tuple(rows))


def test_what_matters_is_told_from_what_does_not(table):
    iterations, loss = effects_of(table, "forearms")
    assert (iterations.name, loss.name) == ("iterations", "loss_scale")
    assert iterations.share > 0.6
    assert loss.share < 0.05
    assert iterations.high - iterations.low == pytest.approx(8.0, abs=1.0)
    told = effects_words((iterations, loss), "deg")
    assert told.startswith(f"iterations {100 * iterations.share:.0f} % ({iterations.low:.1f} to")


def test_values_without_an_effect_are_given_none_on_average():
    """The share is corrected for what as many values explain by chance."""
    rng = np.random.default_rng(2)
    cells = [str(k % 5) for k in range(20)]
    shares = [effects({"x": cells}, rng.normal(size=20))[0].share for _ in range(100)]
    assert np.median(shares) < 0.02


def test_runs_that_all_have_values_of_their_own_say_nothing():
    (one,) = effects({"x": list("abcd")}, np.arange(4.0))
    assert np.isnan(one.share)
    assert effects_words((one,), "deg") == ""


def test_numbers_drawn_at_random_are_put_together():
    x = np.random.default_rng(3).uniform(0.0, 1.0, 60)
    (one,) = effects({"x": [str(value) for value in x]}, 10.0 * x)
    assert one.share > 0.9


def test_unknown_measures_are_left_out():
    values = np.array([1.0, 2.0, np.nan, 1.0, 2.0, np.nan])
    (one,) = effects({"x": list("abcabc"), "y": list("aaxaax")}, values)
    assert (one.name, one.share) == ("x", pytest.approx(1.0))


def test_what_was_changed_together_is_said_to_share_its_effect():
    values = np.array([10.0, 10.1, 4.0, 4.1])
    same = ["1", "1", "2", "2"]
    words = effects_words(effects({"iterations": same, "data_points": same}, values), "deg")
    assert words.endswith("; some were changed together, and share it")
    assert "together" not in effects_words(effects({"iterations": same}, values), "deg")
