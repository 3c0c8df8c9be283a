"""Frames of one video by number, exactly, in any order.

Frames are numbered in the order in which they are shown, so frame k is the k-th smallest time
stamp of the packets that are to be shown. This is right for variable frame rates, B-frames,
streams that do not start at 0 and edit lists (whose cut packets the demuxer marks).

A background thread reads the packets; the frames at the beginning are known after the first few.
Where the container stores the time stamps of all frames and there are no B-frames, its own index
is taken and nothing is read.
"""

import ctypes
import heapq
import threading
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
from numpy.typing import NDArray

from stereotrack_core.reading import MB, reason
from stereotrack_core.recording.images import DamagedFrame, Keep, PictureKind, picture_of

_REORDER_DEPTH = 32  # more packets than any codec holds back for reordering (H.264, H.265: 16)
_OPEN_OPTIONS = {"fflags": "genpts"}
"""AVI and others store decoding times only; the demuxer can deduce the presentation times."""

_PYAV = int(av.__version__.partition(".")[0])
_METADATA_OPTIONS = {"metadata_errors": "surrogateescape"} if _PYAV < 19 else {}
"""Titles that are not UTF-8 must not keep a video shut; PyAV 19 takes them by itself."""

_MOST_AT_ONCE = 200 * MB
"""Bytes that FFmpeg may ask for at once: a plane of a picture of 100 megapixels in 16 bits."""


@cache
def _limit_memory() -> None:
    """Have FFmpeg refuse what a damaged file asks for: 2 GB at once where it states so. PyAV is
    linked with it; where it is not found there (Windows), FFmpeg keeps its own limit.
    """
    with suppress(AttributeError, OSError):
        ctypes.CDLL(av.frame.__file__).av_max_alloc(ctypes.c_size_t(_MOST_AT_ONCE))


def open_container(path: Path) -> Any:
    """An opened video; raises av.FFmpegError or OSError."""
    _limit_memory()
    return av.open(str(path), options=_OPEN_OPTIONS, **_METADATA_OPTIONS)


def video_tracks(container: Any) -> list[Any]:
    """The video streams of a container, without cover pictures."""
    streams = [one for one in container.streams.video if one.codec_context is not None]
    covers = [one for one in streams if one.disposition & av.stream.Disposition.attached_pic]
    return [one for one in streams if one not in covers] or streams


def video_stream(container: Any, track: int = 0) -> Any:
    """A video stream by its place among :func:`video_tracks`; IndexError if there is none."""
    return video_tracks(container)[track]


class FrameTimes:
    """Time stamps of the frames of one video, growing while the background thread reads.

    `complete` once the end has been reached; not `ordered` where time stamps are missing or repeat:
    then frames can only be counted from the beginning of the video. `damage` says why reading
    stopped before the end of the file; empty where it did not.
    """

    def __init__(self, path: Path, track: int = 0) -> None:
        self.complete = False
        self.ordered = True
        self.damage = ""
        self._path, self._track = path, track
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
                if self._take_stored_index(container):
                    return
            with open_container(self._path) as container:
                self._read_packets(container, video_stream(container, self._track))
        except (av.FFmpegError, OSError, IndexError) as error:
            self.damage = reason(error)
        finally:
            with self._grown:
                self.complete = True
                self._grown.notify_all()

    def _take_stored_index(self, container: Any) -> bool:
        """Take the container's index if it holds every frame in the order of showing."""
        stream = video_stream(container, self._track)
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
        packets = container.demux(stream)
        for (time, key, _), packet in zip(stored[: 2 * _REORDER_DEPTH], packets, strict=False):
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
                if len(waiting) > _REORDER_DEPTH:
                    self._settle(heapq.heappop(waiting))
        while waiting:
            self._settle(heapq.heappop(waiting))

    def _settle(self, time: int) -> None:
        with self._grown:
            if self._times and time <= self._times[-1]:
                self.ordered = False
            self._times.append(time)
            self._grown.notify_all()


_KEPT_ON_THE_WAY = 24  # pictures before the wanted one that are handed on: going backwards is fast
_NEVER = 2**62  # A time stamp after all others


@dataclass(frozen=True)
class Stretch:
    """A stretch of time, half-open, whose pictures are damaged."""

    first: int
    end: int
    complaint: str


class VideoStream:
    """Frames of one video by number; a frame is recognised by its time stamp, never by guess.

    To get a frame, decoding goes on from where it stands, or from the last key frame that is shown
    not later than it. If the container leads to a wrong place, an earlier key frame is tried, at
    last the beginning. Used by one thread at a time. Raises av.FFmpegError, OSError or IndexError
    when the file cannot be opened or holds no video.
    """

    def __init__(self, path: Path, kind: PictureKind, track: int = 0) -> None:
        self._path, self._track = path, track
        self._kind: PictureKind = kind
        self._damaged: list[Stretch] = []
        self._open()
        self._estimate = _estimated_count(self._container, self._stream)
        self._times = FrameTimes(path, track)

    def _open(self) -> None:
        self._container = open_container(self._path)
        self._stream = video_stream(self._container, self._track)
        self._stream.codec_context.thread_count = 1  # streams are decoded in parallel instead
        self._stream.codec_context.options = {"err_detect": "explode"}
        self._frames = self._decode()
        self._spoilt: list[Stretch] = []  # by what failed since decoding was started
        self._at: int | None = None  # time stamp of the picture that was decoded last
        self._counted: int | None = None  # its number, where pictures are counted

    def close(self) -> None:
        """Close the file, stop its background thread and free the decoder."""
        self._times.close()
        self._frames.close()  # It holds this object: decoders stayed until garbage was looked for.
        self._container.close()

    def count(self) -> int:
        """Number of frames; may wait until the video has been read to its end."""
        return self._times.count()

    def count_so_far(self) -> tuple[int, bool]:
        """Number of frames known or estimated now, and whether it is final."""
        if self._times.complete:
            return self._times.count(), True
        return max(self._estimate, self._times.count_so_far()), False

    @property
    def seconds_per_tick(self) -> float:
        """Unit of the time stamps."""
        return float(self._stream.time_base)

    @property
    def times(self) -> FrameTimes:
        """Time stamps of the frames."""
        return self._times

    def read(self, k: int, keep: Keep) -> NDArray[Any]:
        """Picture of frame k; pictures decoded on the way are given to `keep`."""
        time = self._times.time_of(k)
        if not self._times.ordered:
            return self._read_by_counting(k)
        if time is None:
            raise DamagedFrame(self._times.damage or f"the video ends before frame {k}")
        known = _stretch_with(self._damaged, time)
        if known is not None:
            raise DamagedFrame(known.complaint)
        if self._goes_on_to(time):
            frame = self._forward_to(time, keep)
            if self._is_sound(frame, time):
                return picture_of(frame, self._kind)
        return self._read_from_a_key(time, keep)

    def _read_from_a_key(self, time: int, keep: Keep) -> NDArray[Any]:
        """Start at the last key frame, then at earlier ones, at last at the beginning.

        What fails from two key frames is damaged; from one it may only lack a picture of before.
        """
        keys = self._times.key_times(time)
        failures = 0
        for key in [*reversed(keys), None]:
            if not self._start_at(key):
                continue
            frame = self._forward_to(time, keep)
            if self._is_sound(frame, time):
                return picture_of(frame, self._kind)
            failures += self._at is not None  # else the container led to too late a place
            if failures > 1:
                break
        found = _stretch_with(self._spoilt, time)
        if found is None:
            raise DamagedFrame("the decoder returns no image for it")
        self._damaged.append(found)
        raise DamagedFrame(found.complaint)

    def _is_sound(self, frame: Any | None, time: int) -> bool:
        if frame is None or frame.is_corrupt:
            return False
        return _stretch_with(self._spoilt, time) is None

    def _goes_on_to(self, time: int) -> bool:
        """Whether decoding on is at most as long as starting at the last key frame."""
        if self._at is None or self._at >= time:
            return False
        keys = self._times.key_times(time)
        if not keys or keys[-1] <= self._at:
            return True
        here, there = self._times.frame_at(self._at), self._times.frame_at(time)
        return here is not None and there == here + 1

    def _start_at(self, key: int | None) -> bool:
        """Stand at a key frame, or at the beginning of the file; whether the container can.

        Raises :class:`DamagedFrame` where the file itself has changed or gone.
        """
        if key is None:
            self._container.close()
            try:
                self._open()
            except (av.FFmpegError, OSError, IndexError) as error:
                raise DamagedFrame(f"the video can no longer be read ({error})") from None
            return True
        self._frames = self._decode()
        self._spoilt = []
        self._at = self._counted = None
        try:
            self._container.seek(key, stream=self._stream, backward=True)
        except (av.FFmpegError, OSError):
            return False
        return True

    def _forward_to(self, time: int, keep: Keep) -> Any | None:
        """Decode up to the frame at `time`; None if it does not come, or it starts too late."""
        passed: deque[Any] = deque(maxlen=_KEPT_ON_THE_WAY)
        wanted = None
        for frame in self._frames:
            if frame.pts is None:
                continue
            if self._at is None and frame.pts > time:
                return None
            self._at = frame.pts
            if frame.pts >= time:
                wanted = frame if frame.pts == time else None
                break
            passed.append(frame)
        else:
            self._at = None if self._at is None else _NEVER
        for frame in passed:
            number = self._times.frame_at(frame.pts)
            if number is not None and self._is_sound(frame, frame.pts):
                keep(number, picture_of(frame, self._kind))
        return wanted

    def _decode(self) -> Generator[Any, None, None]:
        """Pictures from here on; a damaged packet spoils what follows up to the next key frame.

        Begins at the first key frame, and leaves out what is decoded after it but shown before:
        such pictures need others from before the key frame.
        """
        context = self._stream.codec_context
        packets = self._container.demux(self._stream)
        start: int | None = None
        while True:
            try:
                packet = next(packets)
            except StopIteration:
                return
            except (av.FFmpegError, OSError) as error:
                self._spoil(None, reason(error))
                return
            if packet.is_keyframe and packet.size:
                key = -_NEVER if packet.pts is None else packet.pts
                start = key if start is None else start
            if start is None and packet.size:
                continue
            try:
                for frame in context.decode(packet if packet.size else None):
                    if frame.pts is None or start is None or frame.pts >= start:
                        yield frame
            except av.EOFError:
                return
            except av.FFmpegError as error:
                if packet.pts is None or start is None or packet.pts >= start:
                    self._spoil(packet.pts, reason(error))

    def _spoil(self, time: int | None, cause: str) -> None:
        """Pictures from `time` to the next key frame cannot be trusted."""
        if time is None:
            time = _NEVER if self._at is None else self._at + 1
        end = self._times.next_key_time(time) if self._times.ordered else None
        complaint = f"the video is damaged here ({cause})"
        self._spoilt.append(Stretch(time, _NEVER if end is None else end, complaint))

    def _read_by_counting(self, k: int) -> NDArray[Any]:
        """Frame k of a stream whose time stamps are missing or repeat: count from its beginning."""
        if self._counted is None or self._counted >= k:
            self._start_at(None)
            self._counted = -1
        for frame in self._frames:
            self._counted += 1
            if self._counted == k:
                if self._spoilt or frame.is_corrupt:
                    break
                return picture_of(frame, self._kind)
        self._counted = None
        spoilt = [stretch.complaint for stretch in self._spoilt]
        raise DamagedFrame(spoilt[0] if spoilt else f"the video ends before frame {k}")


def _stretch_with(stretches: list[Stretch], time: int) -> Stretch | None:
    return next((s for s in stretches if s.first <= time < s.end), None)


def _estimated_count(container: Any, stream: Any) -> int:
    """Number of frames as far as the header tells."""
    rate, length = stream.average_rate, stream.duration
    if rate is None or (length is None and container.duration is None):
        return int(stream.frames)
    seconds = container.duration / av.time_base if length is None else length * stream.time_base
    return round(float(seconds * rate))
