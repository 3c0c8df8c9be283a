"""Timing in turn, on a clock that goes on only while something is at work."""

import time

import pytest

from stereotrack_core.experiments.benchmark import speed as clock
from stereotrack_core.experiments.benchmark.speed import median_seconds, seconds_of


class Work:
    """Functions that take so long, and the order in which they were called."""

    def __init__(self):
        self.now = 100.0
        self.calls = []

    def of(self, name, seconds):
        def work():
            self.calls.append(name)
            self.now += seconds

        return work


@pytest.fixture
def work(monkeypatch):
    made = Work()
    monkeypatch.setattr(clock.time, "perf_counter", lambda: made.now)
    return made


def test_seconds_are_those_of_the_wall():
    assert seconds_of(lambda: time.sleep(0.02)) >= 0.019


def test_seconds_of_a_call(work):
    assert seconds_of(work.of("once", 0.25)) == 0.25


def test_functions_are_called_in_turn_within_the_budget(work, monkeypatch):
    monkeypatch.setattr(clock, "_MOST_CALLS", 20)
    functions = {"slow": work.of("slow", 0.03125), "fast": work.of("fast", 0.001)}
    times = median_seconds(functions, budget=0.1)
    assert times == {"slow": 0.03125, "fast": pytest.approx(0.001)}
    assert work.calls[:4] == ["slow", "fast", "slow", "fast"]
    assert work.calls.count("fast") == 21
    assert work.calls.count("slow") == 4


def test_one_call_beyond_the_budget_is_the_measurement(work):
    assert median_seconds({"slow": work.of("slow", 0.5)}, budget=0.1) == {"slow": 0.5}
    assert work.calls == ["slow"]
