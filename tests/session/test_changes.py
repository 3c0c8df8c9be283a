"""The one event of the session: who is told, in which order, from which thread."""

import sys
import threading

import pytest

from app.session.changes import Changes, Part


@pytest.fixture
def changes(plain):
    return Changes(plain.loop)


def test_followers_are_told_in_their_order_of_the_parts_that_they_watch(changes):
    told = []
    changes.watch(Part.RUNS | Part.FRAME, lambda: told.append("first"))
    changes.hear(Part.EDIT, told.append)
    changes.watch(Part.FRAME, lambda: told.append("second"))
    changes.tell(Part.RUNS | Part.FRAME)
    changes.tell(Part.EDIT, "news")
    changes.tell(Part.PLAYING)
    assert told == ["first", "second", "news"]


def test_what_a_follower_tells_comes_before_the_rest(changes):
    told = []
    changes.watch(Part.RUNS, lambda: changes.tell(Part.FRAME))
    changes.watch(Part.FRAME, lambda: told.append("frame"))
    changes.watch(Part.RUNS, lambda: told.append("runs"))
    changes.tell(Part.RUNS)
    assert told == ["frame", "runs"]


def test_a_follower_that_fails_keeps_nobody_from_being_told(changes, monkeypatch):
    failed, told = [], []
    monkeypatch.setattr(sys, "excepthook", lambda kind, *_: failed.append(kind))
    changes.watch(Part.RUNS, lambda: 1 / 0)
    changes.watch(Part.RUNS, lambda: told.append("runs"))
    changes.tell(Part.RUNS)
    assert (failed, told) == ([ZeroDivisionError], ["runs"])


def test_another_thread_tells_by_way_of_the_loop(changes, plain):
    told = []
    changes.watch(Part.EDIT, lambda: told.append(threading.current_thread()))
    thread = threading.Thread(target=changes.tell, args=(Part.EDIT,))
    thread.start()
    thread.join()
    assert told == []
    plain.until(lambda: told == [threading.main_thread()])
