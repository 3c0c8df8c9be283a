"""The open recording, the frame that is shown, and playback."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Generic, TypeVar

from stereotrack_core.doctor.diagnose import glance, hindrances
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import Finding, by_severity, examine
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader, FrameSet

from .changes import Changes, Part
from .jobs import Job, LatestOnly, NewestJob, Task, TaskList
from .messages import Message, Tell

_COUNT_MS = 200
_SHORTEST_MS = 10  # between two frames that are played
_CACHE = 256 * 1024 * 1024  # bytes of pictures: 34 frames of four pairs of 640x480 in colour
R = TypeVar("R")


class Shared(Generic[R]):
    """A resource with an owner, and users in other threads.

    The owner closes it without waiting: where somebody still uses it, the last user closes it when
    leaving; `close` is called once, in whichever thread is the last. Only the owner, who knows
    whether it is closed, looks at the `resource` itself.
    """

    def __init__(self, resource: R, close: Callable[[], object]) -> None:
        self.resource = resource
        self._close = close
        self._lock = threading.Lock()
        self._users = 0
        self.wanted = True

    @contextmanager
    def used(self) -> Iterator[R]:
        """The resource, which stays open meanwhile; Cancelled if its owner has closed it."""
        resource = self.enter()
        try:
            yield resource
        finally:
            self.leave()

    def enter(self) -> R:
        with self._lock:
            if not self.wanted:
                raise Cancelled
            self._users += 1
        return self.resource

    def leave(self) -> None:
        """No longer use it; once for every :meth:`enter`."""
        with self._lock:
            self._users -= 1
            last = not self.wanted and not self._users
        if last:
            self._close()

    def close(self) -> None:
        """Let nobody else begin to use it, and have it closed; a second time does nothing."""
        with self._lock:
            last = self.wanted and not self._users
            self.wanted = False
        if last:
            self._close()


def _looked_at(recording: Recording) -> tuple[Finding, ...]:
    """What the files of a recording, and a glance at its images, say."""
    found = examine(recording.folder, compare=True)
    try:
        return (*found, *glance(recording))
    except InputError as error:
        return (*found, Finding.of(error))


class DocumentPresenter:
    """Opens recordings, steps and plays; pictures are read off the window's thread."""

    def __init__(self, changes: Changes, tasks: TaskList, tell: Tell) -> None:
        self._changes, self._tasks, self._tell = changes, tasks, tell
        self.on_opened: Callable[[], object] = lambda: None
        self.on_closed: Callable[[], object] = lambda: None
        self.recording: Recording | None = None
        self.reader: Shared[FrameReader] | None = None
        self.frame = 0
        self._frame_set: FrameSet | None = None
        self._reading: LatestOnly | None = None
        self._opening, self._checking = NewestJob(tasks), NewestJob(tasks)
        self._start_frame = 0
        self.findings: tuple[Finding, ...] | None = None
        self._examined: tuple[Finding, ...] = ()
        self._measured: tuple[Finding, ...] = ()
        self.playing = False
        self._play_timer = changes.loop.later(self._on_play, _SHORTEST_MS)
        self._play_ms = _SHORTEST_MS
        self._played_from, self._played_since = 0, 0.0
        self.loop: range | None = None
        """Frames that are played again and again; None where playing goes on to the end."""
        self._count_timer = changes.loop.later(self._on_count, _COUNT_MS)
        self.frame_count = 0

    @property
    def frame_set(self) -> FrameSet | None:
        """Images of the frame that shall be shown, once they are there."""
        there = self._frame_set is not None and self._frame_set.index == self.frame
        return self._frame_set if there else None

    @property
    def opening(self) -> bool:
        return self._opening.busy

    def open(self, folder: Path, frame: int = 0) -> None:
        """Open a recording folder in the background and show `frame`."""
        self._start_frame = frame

        def read(task: Task) -> FrameReader:
            reader = FrameReader(open_recording(folder), cache_bytes=_CACHE)
            try:
                if reader.frame_count_so_far()[0] > 0:
                    reader.frame_set(0)
                self._tasks.finish_writes()  # what is open is closed once all of it is written
                if task.token.cancelled():
                    raise Cancelled
            except (InputError, Cancelled):
                reader.close()
                raise
            return reader

        title = f"opening {folder.name}"
        self._opening.run(Job(title, read, self._take, discard=FrameReader.close))

    def close(self) -> None:
        """Close the recording; one that is being opened does not come any more."""
        self._opening.give_up()
        self._checking.give_up()
        self.pause()
        self._count_timer.stop()
        if self._reading is not None:
            self._reading.close()
            self._reading = None
        reader, self.recording, self.reader = self.reader, None, None
        self._frame_set, self.frame, self.frame_count, self.findings = None, 0, 0, None
        self._examined = self._measured = ()
        self.loop = None
        if reader is not None:
            reader.close()
            self.on_closed()

    def go_to(self, frame: int) -> None:
        """Show a frame; beyond the ends the first or last one."""
        if self.recording is None or self.frame_count == 0:
            return
        wanted = min(max(frame, 0), self.frame_count - 1)
        if self.playing:
            self._restart_clock(wanted)
        self._show(wanted)

    def step(self, by: int) -> None:
        self.visit(self.frame + by)

    def play(self) -> None:
        """Go on by the recording's own clock; from the last frame it begins again."""
        if self.recording is None or self.frame_count < 2:
            return
        at_end = self.frame >= self.frame_count - 1 and self.loop is None
        self._restart_clock(0 if at_end else self.frame)
        self._play_ms = max(_SHORTEST_MS, round(1000.0 / self.recording.fps))
        self._play_timer.start(self._play_ms)
        self.playing = True
        self._changes.tell(Part.PLAYING)

    def pause(self) -> None:
        if self.playing:
            self._play_timer.stop()
            self.playing = False
            self._changes.tell(Part.PLAYING)

    def toggle_playing(self) -> None:
        if self.playing:
            self.pause()
        else:
            self.play()

    def visit(self, frame: int) -> None:
        self.pause()
        self.go_to(frame)

    def settled(self) -> bool:
        if self.opening:
            return False
        return self.recording is None or self.frame_count == 0 or self.frame_set is not None

    def _restart_clock(self, frame: int) -> None:
        self._played_from, self._played_since = frame, time.monotonic()

    def _show(self, frame: int) -> None:
        self.frame = frame
        if self._reading is not None:
            self._reading.ask(frame)
        self._changes.tell(Part.FRAME)

    def _take(self, reader: FrameReader) -> None:
        self.close()
        recording = self.recording = reader.recording
        self.reader = Shared(reader, reader.close)
        read = partial(_frame_set, self.reader)
        answers = self._on_frame_read, self._on_frame_failed
        self._reading = LatestOnly(self._tasks, read, "frames read", *answers)
        self.frame_count, final = reader.frame_count_so_far()
        if not final:
            self._count_timer.start()
        self.on_opened()
        if self.frame_count == 0 and final:
            remedy = "See Recording checks for the length of every stream."
            what = "no frame is present in all streams"
            self._tell(Message("error", what, recording.name, remedy))
        elif final and self._start_frame >= self.frame_count:
            remedy = f"The frames are numbered 0 to {self.frame_count - 1}. The last one is shown."
            what = f"there is no frame {self._start_frame}"
            self._tell(Message("note", what, recording.name, remedy))
        self.go_to(self._start_frame or self.frame)  # a project may have gone to its own

        look = partial(_looked_at, recording)
        self._checking.run(Job("checking the recording", lambda _task: look(), self._on_examined))

    def _on_examined(self, findings: tuple[Finding, ...]) -> None:
        self._examined = findings
        self.take_measured(self._measured)

    def take_measured(self, findings: Sequence[Finding]) -> None:
        """Add what was measured of the recording's images to what its files say."""
        self._measured = tuple(findings)
        self.findings = by_severity(dict.fromkeys((*self._examined, *self._measured)))
        self._changes.tell(Part.FINDINGS)

    def hindrances(self) -> tuple[Finding, ...]:
        """Errors because of which the recording would not be tracked correctly, as far as known."""
        found, recording = self.findings or (), self.recording
        return () if recording is None else hindrances(found, recording)

    def _on_frame_read(self, _frame: int, frame_set: FrameSet) -> None:
        self._frame_set = frame_set
        self._changes.tell(Part.IMAGES)

    def _on_frame_failed(self, frame: int, error: Exception) -> None:
        self._tasks.failed(error)
        self._on_frame_read(frame, FrameSet(frame, {}, {}))

    def _on_play(self) -> None:
        if self.recording is None:
            return
        self._play_timer.start(self._play_ms)
        if self.frame_set is None and self._reading is not None and not self._reading.settled():
            return  # the picture before is not there yet; time goes on all the same
        seconds = time.monotonic() - self._played_since
        due = self._played_from + int(seconds * self.recording.fps)
        if self.loop is not None and (due >= self.loop.stop or due < self.loop.start):
            self._show(min(self.loop.start, self.frame_count - 1))
            self._restart_clock(self.frame)
            return
        last = self.frame_count - 1
        if due > self.frame:
            self._show(min(due, last))
        if self.frame >= last and self.loop is None:
            self.pause()

    def _on_count(self) -> None:
        if self.reader is None:
            return
        count, final = self.reader.resource.frame_count_so_far()
        if not final:
            self._count_timer.start()
        if count != self.frame_count:
            first = self.frame_count == 0
            self.frame_count = count
            self._changes.tell(Part.LENGTH)
            if first:
                self.go_to(self._start_frame)
            elif self.frame >= count:  # there are fewer than estimated
                self.go_to(count - 1)


def _frame_set(reader: Shared[FrameReader], frame: int) -> FrameSet:
    with reader.used() as open_reader:
        return open_reader.frame_set(frame)
