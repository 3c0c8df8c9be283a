"""How far long work is, in a bar or in lines."""

from stereotrack_core.cli import progress as module
from stereotrack_core.cli.progress import Pace


def test_the_time_left_follows_from_the_time_so_far(monkeypatch, capsys):
    now = [1000.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    drawn = []
    going = Pace("Tracking", 400, drawn.append)
    assert going.words() == "under a second so far"
    now[0] += 600.0
    going.advance(50)
    going.next(100)
    assert going.words() == "10 min so far, about 30 min left"
    going.advance(100)
    assert drawn == [50, 100, 200]
    assert "Tracking: 50 of 400 frames" in capsys.readouterr().err
