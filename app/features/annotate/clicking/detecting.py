"""The installed pose detector looks by itself at the frames that are annotated."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.detected_body import DetectLandmarks
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import gaps_of
from stereotrack_core.worker_processes import TaskProcess

from ....context import Context
from ....session.changes import PROJECT, RECORDING, Part
from ....session.jobs import LatestOnly
from .annotating import Annotating

_SOON_MS = 150  # frames that are only passed by are not looked at
_SETTING = "annotate/detects"
_AHEAD = 2  # frames of the rhythm on either side of one that is being annotated
NO_DETECTOR = "The pose detector is not installed. Choose Track, Install pose detector … first."
_WOULD_BRING = (
    "The pose detector would predict landmarks before the first click: choose Track, Install pose "
    "detector …"
)


@dataclass(frozen=True, eq=False)
class _Look:
    """A frame that is to be looked at, until `stopped`."""

    todo: DetectLandmarks
    stopped: threading.Event = field(default_factory=threading.Event)


class FrameDetections:
    """Landmarks that the detector sees in the frame that is shown and those annotated with it.

    They are predictions that are kept until the project is closed, and never stored.
    """

    def __init__(self, context: Context, annotating: Annotating) -> None:
        session, self._annotating, self._settings = context.session, annotating, context.settings
        self._document, self._project = session.document, session.project
        self.on = bool(context.settings.value(_SETTING, True, type=bool))
        self._active, self._tell_failure = False, context.notifier.error
        self._tell = partial(session.changes.tell, Part.PROPOSALS)
        self._known: dict[int, tuple[Prediction, ...]] = {}
        self._look: _Look | None = None
        self._process = TaskProcess()
        self._looking = LatestOnly(
            context.tasks, self._answer, "detect landmarks", self._on_seen, self._on_failed,
            late=True,
        )  # fmt: skip
        self._soon = session.later(self._ask, _SOON_MS)
        watch = session.changes.watch
        watch(Part.CLICKS | Part.PLAYING | Part.KEYPOINTS, self._soon.start)
        watch(PROJECT | RECORDING, self._forget)
        watch(RECORDING, self._process.end)  # it keeps videos open
        watch(Part.WINDOW_CLOSING, self._process.close)

    def at(self, frame: int) -> tuple[Prediction, ...]:
        return self._known.get(frame, ())

    def set_active(self, active: bool) -> None:
        self._active = active
        self._soon.start()

    def toggle(self) -> None:
        self.on = not self.on
        self._settings.setValue(_SETTING, self.on)
        self._forget()
        self._annotating.reread()

    def why_not(self) -> str:
        return "" if is_installed() else NO_DETECTOR

    def words(self) -> str:
        """Say that the frame is being looked at, or what installing the detector would bring."""
        if not self.on:
            return ""
        if self.why_not():
            return _WOULD_BRING
        waits = self._look is not None and self._look.todo.frame == self._document.frame
        return "Detecting landmarks in this frame …" if waits else ""

    def settled(self) -> bool:
        return not self._soon.isActive() and self._looking.settled()

    def close(self) -> None:
        self._soon.stop()
        if self._look is not None:
            self._look.stopped.set()
            self._look = None
        self._looking.close()

    def _forget(self) -> None:
        self.close()
        self._known = {}
        self._soon.start()

    def _ask(self) -> None:
        """Have the next frame looked at that nobody has looked at yet."""
        project, recording = self._project.project, self._document.recording
        wanted = self.on and self._active and not self._document.playing
        if not wanted or project is None or recording is None or self._annotating.blind():
            return
        frame = next((one for one in self._frames() if self._is_open(project, one)), None)
        if frame is None or self.why_not():
            return
        if self._look is not None and self._look.todo.frame == frame:
            return
        proportions = proportions_of(self._project.subject())
        names = self._annotating.landmark_set.names
        self._look = _Look(DetectLandmarks(recording, frame, names, proportions))
        self._looking.ask(self._look)
        self._tell()

    def _frames(self) -> Iterator[int]:
        """The frame that is shown; once it has a click, those of the rhythm around it."""
        yield self._document.frame
        if self._annotating.clicks():
            rhythm, frame = self._annotating.rhythm(), self._document.frame
            yield from [one for one in rhythm if one > frame][:_AHEAD]
            yield from [one for one in rhythm if one < frame][-_AHEAD:]

    def _is_open(self, project: Project, frame: int) -> bool:
        if frame in self._known or any(frame in gap for gap in gaps_of(project)):
            return False
        return all(one.source != DETECTOR_NAME for one in project.predictions.at(frame))

    def _answer(self, look: _Look) -> tuple[Prediction, ...]:
        found: tuple[Prediction, ...] = self._process(look.todo, cancelled=look.stopped.is_set)
        return found

    def _on_seen(self, look: _Look, found: tuple[Prediction, ...] | None) -> None:
        if found is None or look.stopped.is_set():
            return
        self._known[look.todo.frame] = found
        if look is self._look:
            self._look = None
        if look.todo.frame == self._document.frame:
            self._annotating.reread()
        self._soon.start()

    def _on_failed(self, look: _Look, error: Exception) -> None:
        if not look.stopped.is_set():
            self._on_seen(look, ())  # and not again
            if not isinstance(error, InputError):  # pictures that cannot be read are told already
                self._tell_failure(error)
