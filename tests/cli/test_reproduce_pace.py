"""How far long work is, in a bar or in lines."""

import pytest

from stereotrack_core.cli import progress as module
from stereotrack_core.cli.progress import Pace, duration


@pytest.mark.parametrize(
    ("seconds", "words"), [(12, "12 s"), (600, "10 min"), (3900, "1 h 5 min"), (7260, "2 h 1 min")]
)
def test_times_are_told_as_people_do(seconds, words):
    assert duration(seconds) == words


def test_the_time_left_follows_from_the_time_so_far(monkeypatch, capsys):
    now = [1000.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    drawn = []
    going = Pace("Tracking", 400, drawn.append)
    assert going.words() == "0 s so far"
    now[0] += 600.0
    going.advance(50)
    going.next(100)
    assert going.words() == "10 min so far, about 30 min left"
    going.advance(100)
    assert drawn == [50, 100, 200]
    assert "Tracking: 50 of 400 frames" in capsys.readouterr().err
