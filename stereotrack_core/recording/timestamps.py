"""Which presentation time stamp each frame of a video has, found without decoding.

Frames are numbered in the order in which they are shown, so frame k is the k-th smallest time
stamp of the packets that are to be shown. This is right for variable frame rates, B-frames,
streams that do not start at 0 and edit lists (whose cut packets the demuxer marks).

A background thread reads the packets; the frames at the beginning are known after the first few.
Where the container stores the time stamps of all frames and there are no B-frames, its own index
is taken and nothing is read.
"""

from __future__ import annotations

import heapq
import threading
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import av

from stereotrack_core.reading import reason

REORDER_DEPTH = 32
"""More packets than any codec holds back for reordering (H.264 and H.265 allow 16)."""

OPEN_OPTIONS = {"fflags": "genpts"}
"""AVI and others store decoding times only; the demuxer can deduce the presentation times."""

PYAV = int(av.__version__.partition(".")[0])
METADATA_OPTIONS = {"metadata_errors": "surrogateescape"} if PYAV < 19 else {}
"""Titles that are not UTF-8 must not keep a video shut; PyAV 19 takes them by itself."""


def open_container(path: Path) -> Any:
    """An opened video; raises av.FFmpegError or OSError."""
    return av.open(str(path), options=OPEN_OPTIONS, **METADATA_OPTIONS)


def video_stream(container: Any) -> Any:
    """The first video stream; IndexError where there is none or nobody knows its codec."""
    stream = container.streams.video[0]
    if stream.codec_context is None:
        raise IndexError
    return stream


class FrameTimes:
    """Time stamps of the frames of one video, growing while the background thread reads.

    Attributes
    ----------
    complete : bool
        Whether the end of the video has been reached.
    ordered : bool
        False where time stamps are missing or repeat: then frames can only be counted from the
        beginning of the video.
    damage : str
        Why reading stopped before the end of the file; empty where it did not.
    """

    def __init__(self, path: Path) -> None:
        self.complete = False
        self.ordered = True
        self.damage = ""
        self._path = path
        self._times: list[int] = []
        self._keys: list[int] = []
        self._packets = 0
        self._grown = threading.Condition()
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name=f"index {path.name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the background thread."""
        self._stopped = True
        self._thread.join()

    def count(self) -> int:
        """Number of frames; waits for the end of the video to be reached."""
        self._wait(lambda: self.complete)
        return len(self._times) if self.ordered else self._packets

    def count_so_far(self) -> int:
        """Number of frames known up to now."""
        with self._grown:
            return len(self._times)

    def time_of(self, k: int) -> int | None:
        """Time stamp of frame k, None behind the end; waits until it is known."""
        self._wait(lambda: self.complete or not self.ordered or len(self._times) > k)
        with self._grown:
            return self._times[k] if 0 <= k < len(self._times) else None

    def frame_at(self, time: int) -> int | None:
        """Number of the frame with that time stamp, None where there is none."""
        with self._grown:
            i = bisect_left(self._times, time)
            return i if i < len(self._times) and self._times[i] == time else None

    def key_times(self, time: int) -> list[int]:
        """Time stamps of key frames not after `time`, ascending."""
        with self._grown:
            return self._keys[: bisect_right(self._keys, time)]

    def next_key_time(self, time: int) -> int | None:
        """Time stamp of the first key frame after `time`, None where there is none; waits."""
        self._wait(lambda: self.complete or (bool(self._keys) and self._keys[-1] > time))
        with self._grown:
            i = bisect_right(self._keys, time)
            return self._keys[i] if i < len(self._keys) else None

    def times(self) -> list[int]:
        """All time stamps; waits for the end of the video to be reached."""
        self._wait(lambda: self.complete)
        return list(self._times)

    def _wait(self, known: Callable[[], bool]) -> None:
        with self._grown:
            while not known():
                self._grown.wait()

    def _run(self) -> None:
        try:
            with open_container(self._path) as container:
                stream = video_stream(container)
                if not self._take_stored_index(stream):
                    self._read_packets(container, stream)
        except (av.FFmpegError, OSError, IndexError) as error:
            self.damage = reason(error)
        finally:
            with self._grown:
                self.complete = True
                self._grown.notify_all()

    def _take_stored_index(self, stream: Any) -> bool:
        """Take the container's index if it holds every frame in the order of showing."""
        entries = getattr(stream, "index_entries", ())
        if stream.codec_context.has_b_frames or not 0 < stream.frames == len(entries):
            return False
        if max(e.pos + e.size for e in entries) > self._path.stat().st_size:
            return False
        stored = [(e.timestamp, e.is_keyframe, e.is_discard or e.size == 0) for e in entries]
        times = [time for time, _, hidden in stored if not hidden]
        keys = [time for time, key, _ in stored if key]
        increasing = all(a < b for a, b in pairwise(times))
        if not increasing or not keys or keys[0] != stored[0][0]:
            return False
        with open_container(self._path) as trial:
            packets = trial.demux(video_stream(trial))
            for (time, key, _), packet in zip(stored[: 2 * REORDER_DEPTH], packets, strict=False):
                if (packet.pts, packet.dts, packet.is_keyframe) != (time, time, key):
                    return False
        with self._grown:
            self._times, self._keys, self._packets = times, keys, len(times)
        return True

    def _read_packets(self, container: Any, stream: Any) -> None:
        waiting: list[int] = []
        for packet in container.demux(stream):
            if self._stopped:
                return
            if packet.size == 0:
                continue
            if packet.pts is None:
                self.ordered = False
            if packet.is_keyframe and packet.pts is not None:
                with self._grown:
                    self._keys.append(packet.pts)
            # Before the first key frame nothing can be decoded.
            if packet.is_discard or not self._keys:
                self._packets += not self.ordered
                continue
            self._packets += 1
            if self.ordered and packet.pts >= self._keys[0]:
                heapq.heappush(waiting, packet.pts)
                if len(waiting) > REORDER_DEPTH:
                    self._settle(heapq.heappop(waiting))
        while waiting:
            self._settle(heapq.heappop(waiting))

    def _settle(self, time: int) -> None:
        with self._grown:
            if self._times and time <= self._times[-1]:
                self.ordered = False
            self._times.append(time)
            self._grown.notify_all()
