"""A loop in place of the window's, and what is kept in place of its settings."""

import queue
import time

from app.session.messages import Loop

PATIENCE_S = 300.0
"""Waiting ends with what is waited for; this ends it where that never comes."""


class PlainTimer:
    """Calls a function once, from the loop that it belongs to."""

    def __init__(self, do, milliseconds):
        self.do, self._seconds, self.due = do, milliseconds / 1000.0, None

    def start(self, milliseconds=None):
        seconds = self._seconds if milliseconds is None else milliseconds / 1000.0
        self.due = time.monotonic() + seconds

    def stop(self):
        self.due = None

    def isActive(self):
        return self.due is not None


class PlainLoop:
    """Does what was posted and what is due, while a test waits for something."""

    def __init__(self):
        self._posted, self._timers = queue.SimpleQueue(), []
        self.loop = Loop(self._posted.put, self._later)

    def _later(self, do, milliseconds):
        self._timers.append(PlainTimer(do, milliseconds))
        return self._timers[-1]

    def until(self, condition, seconds=PATIENCE_S):
        """Go on until a condition holds."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "it never came"
            self.once()

    def once(self, wait=0.005):
        """Do what has been posted and what is due now."""
        for timer in tuple(self._timers):
            if timer.due is not None and timer.due <= time.monotonic():
                timer.stop()
                timer.do()
        try:
            while True:
                self._posted.get(timeout=wait)()
                wait = 0.0
        except queue.Empty:
            return


class Kept(dict):
    """What is kept for the next start."""

    def value(self, key):
        return self.get(key)

    def setValue(self, key, value):
        self[key] = value
