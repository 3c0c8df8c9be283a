"""Timing in turn."""

import time

import pytest

from stereotrack_core.evaluation.benchmarks.clock import median_seconds, seconds_of


def test_seconds_of_a_sleep():
    assert seconds_of(lambda: time.sleep(0.02)) == pytest.approx(0.02, abs=0.015)


def test_functions_are_called_in_turn_within_the_budget():
    calls = []

    def slow():
        calls.append("slow")
        time.sleep(0.03)

    def fast():
        calls.append("fast")

    times = median_seconds({"slow": slow, "fast": fast}, budget=0.1, most_calls=20)
    assert times["slow"] >= 0.03
    assert times["fast"] < 0.03
    assert calls[:4] == ["slow", "fast", "slow", "fast"]
    assert calls.count("fast") == 21
    assert 2 <= calls.count("slow") <= 4


def test_one_call_beyond_the_budget_is_the_measurement():
    calls = []
    times = median_seconds({"slow": lambda: calls.append(time.sleep(0.03))}, budget=0.01)
    assert len(calls) == 1
    assert times["slow"] >= 0.03
