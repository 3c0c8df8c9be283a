"""One event of the session: which parts of it are new, and who follows them."""

import enum
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

from .messages import Loop


class Part(enum.Flag):
    """Parts of what the window knows; several are new at once where they are joined by ``|``."""

    # the recording and the window
    RECORDING_OPENED = enum.auto()  # nothing is left of the one before
    READY = enum.auto()  # all that shows the recording follows it
    LEAVING = enum.auto()  # about to change or to be closed: what works on it stops
    RECORDING_CLOSED = enum.auto()
    WINDOW_CLOSING = enum.auto()  # whoever has a thread ends it
    WORKSPACE = enum.auto()
    RECENT = enum.auto()  # the list of what was opened last
    TASKS = enum.auto()  # what is under way, and how far it is
    # its frames
    FRAME = enum.auto()  # the frame that shall be shown
    IMAGES = enum.auto()  # those of the frame are there
    LENGTH = enum.auto()  # the number of frames is known better than before
    PLAYING = enum.auto()
    FINDINGS = enum.auto()  # what looks wrong about the recording
    CLOUD = enum.auto()  # points that were asked for, or there will be none; news: the cloud
    INSTANT = enum.auto()  # everything about one frame; all views show it together
    # the project
    PROJECT_OPENED = enum.auto()  # perhaps for reading only
    PROJECT_FOLLOWED = enum.auto()  # there is one now, or it is known that there is none
    PROJECT_CLOSING = enum.auto()  # it can still be read
    PROJECT_CLOSED = enum.auto()
    EDIT = enum.auto()  # made, undone or redone; news: Changed
    EDITS = enum.auto()  # what undo and redo do next
    MOVED = enum.auto()  # a person has undone or redone something; news: Moved
    KEYPOINTS = enum.auto()  # keypoints or proposals of detectors
    DOUBTS = enum.auto()  # which camera contradicts the others, and by how much
    # the tracker and its runs
    RUNS = enum.auto()  # a run was added, removed, renamed, shown or hidden
    ACTIVE_RUN = enum.auto()  # the one whose model is drawn
    RUN_FRAMES = enum.auto()  # a run that is tracked has more frames
    TRACKED = enum.auto()  # news: the newest frame, still with cloud and correspondences
    RESTED = enum.auto()  # news: cloud and depth images of the frame at which the tracker stopped
    TRACKING = enum.auto()  # running, paused, finished or idle, or further in preparing
    RUN_ENDED = enum.auto()  # news: the run
    SETTINGS = enum.auto()  # those of the next run, or its preset
    JUDGEMENT = enum.auto()  # every run is judged as it is; told once for all that has changed
    TRUTH = enum.auto()  # what errors are measured against
    TRIALS = enum.auto()  # what is tried, or would be
    REMEDIES = enum.auto()  # what was tried on a failure
    FAILURES = enum.auto()  # found, listed or chosen ones of the active run
    INSPECTION = enum.auto()  # whether a frame is inspected, what is known of it, and the stage
    # what is chosen of what is shown
    SELECTION = enum.auto()
    SCENARIOS = enum.auto()  # the named stretches, or whether results are told of each
    THRESHOLD = enum.auto()
    ACTIVE_VIEW = enum.auto()
    PICTURES = enum.auto()  # another kind in some view, or the views are arranged anew
    DISPLAY = enum.auto()  # overlays, loupe or the selected limb
    SCENE = enum.auto()  # colour of the points, selected limb or fitted body
    STEP = enum.auto()  # the step inside the frame that is drawn instead of the run
    # what features know
    CLICKS = enum.auto()  # of the frame that shall be shown
    CHOICE = enum.auto()  # the landmark of the next click
    HINTS = enum.auto()  # and the body fitted to the clicks
    PROPOSALS = enum.auto()  # in the frame that is shown or one step ahead
    CALIBRATION = enum.auto()  # what is chosen for it, and what is calculated
    STUDY = enum.auto()  # the study that is open, its rows, and what is done with it
    SAID = enum.auto()  # news: words for the status line
    # what a person has to be asked for; news: a path, or several
    IMPORT_WANTED = enum.auto()
    STUDY_WANTED = enum.auto()
    PARAMETER_WANTED = enum.auto()  # news: its name
    RUN_WANTED = enum.auto()
    RUN_ALONE = enum.auto()  # nobody knows the recording of this run
    RECORDING_MISSING = enum.auto()  # that of this project


RECORDING = Part.RECORDING_OPENED | Part.RECORDING_CLOSED
PROJECT = Part.PROJECT_OPENED | Part.PROJECT_CLOSED
TellChange: TypeAlias = Callable[..., None]  # `Changes.tell`


class Changes:
    """Tells followers at once, in the order in which they began to follow.

    A change that a follower tells is delivered before the rest of the one that it was told
    (depth first). So a follower reads the state as it is; it may have been told of it already.
    A change that another thread tells is delivered by the loop of the window's thread.
    """

    def __init__(self, loop: Loop) -> None:
        self.loop, self._thread = loop, threading.get_ident()
        self._followers: list[tuple[int, Callable[..., object], bool]] = []

    def tell(self, parts: Part, news: Any = None) -> None:
        """Say that parts are new, with what is to be said of one of them."""
        if threading.get_ident() != self._thread:
            self.loop.post(partial(self.tell, parts, news))
            return
        told = parts.value  # as a number: it is compared with that of every follower
        for watched, do, hears in tuple(self._followers):
            if watched & told:
                self.loop.call(do, *([news] if hears else []))

    def watch(self, parts: Part, do: Callable[[], object]) -> None:
        """Call a function when one of these parts is new, or several at once."""
        self._followers.append((parts.value, do, False))

    def hear(self, part: Part, do: Callable[[Any], object]) -> None:
        """Call a function with the news of this part."""
        self._followers.append((part.value, do, True))
