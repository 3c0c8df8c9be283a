"""In place of the status line and the messages over the views."""

from app.services.failures import Notifier


class Notices(Notifier):
    """Keeps what a person would read."""

    def __init__(self):
        self.said, self.shown = [], []

    def say(self, words, milliseconds=0):
        """Keep words of the status line."""
        self.said.append(words)

    def show(self, message):
        """Keep a message."""
        self.shown.append(message)
