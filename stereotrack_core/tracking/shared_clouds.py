"""Clouds that several runs over the same frames share."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol, TypeAlias

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.mono_silhouettes import silhouette_views
from stereotrack_core.depth.volume import settled
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader, has_colours
from stereotrack_core.tracking.frame import cloudless
from stereotrack_core.tracking.run_spec import RunSpec

_AHEAD = 2
"""Clouds that are made while the tracker works on an earlier one."""

ReadCloud: TypeAlias = tuple[Cloud, float]
"""A cloud, and the seconds that reading its images took."""


def made_ahead(make: Callable[[int], ReadCloud], frames: range) -> Generator[ReadCloud, None, None]:
    """Clouds of frames in their order; while one is worked on, the next ones are made."""
    with ThreadPoolExecutor(1, thread_name_prefix="cloud") as ahead:
        waiting: deque[Future[ReadCloud]] = deque()
        for frame in frames:
            waiting.append(ahead.submit(make, frame))
            if len(waiting) > _AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def read_cloud(chain: DepthChain, reader: FrameReader, frame: int) -> tuple[Cloud, float]:
    """Cloud of a frame, and the seconds that reading its images took; empty without any view."""
    if not (chain.view_names or chain.silhouettes):
        return cloudless(frame), 0.0
    begun = time.perf_counter()
    frame_set = reader.frame_set(frame)
    read = time.perf_counter() - begun
    return chain.process(frame_set), read


def chain_of(
    recording: Recording, spec: RunSpec, views: Sequence[str], reader: FrameReader | None = None
) -> tuple[DepthChain, FrameReader]:
    """What makes the clouds of a run over these views, and the reader, a new one where not given.

    Of mono views, clouds have the silhouettes at most.
    """
    deep = tuple(name for name in views if recording.view(name).kind != "mono")
    coloured = spec.settings.tracking.wants_colour and has_colours(recording, deep)
    colour = coloured if spec.colour is None else spec.colour
    reader = reader or FrameReader(recording, views=views, colour=colour)
    depth = settled(recording, spec.settings.depth, reader, deep)
    mono = silhouette_views(
        recording, views, detector=spec.detector and spec.settings.uses_detector
    )
    return DepthChain(recording, depth, views=deep, mono=mono, colour=coloured), reader


class CloudSource(Protocol):
    """Where a run takes clouds that are not its own."""

    chain: DepthChain
    reader: FrameReader

    def learn(self, frames: range) -> None:
        """Learn the background from these frames, unless that is done already."""

    def take(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took."""


class SharedClouds:
    """Clouds that are made once, and forgotten when every run that is left has taken them.

    Runs that go forward together keep only the few clouds that some have taken and others not.
    May be used by the threads of all runs at once.
    """

    def __init__(self, chain: DepthChain, reader: FrameReader) -> None:
        self.chain = chain
        self.reader = reader
        self._lock = threading.Lock()
        self._held: dict[int, tuple[Cloud, float]] = {}
        self._waiting: dict[int, set[CloudTaker]] = {}
        self._takers: set[CloudTaker] = set()
        self._learned = False

    def __len__(self) -> int:
        return len(self._held)

    def taker(self) -> CloudTaker:
        """What one run takes clouds from; to be made before any run begins."""
        taker = CloudTaker(self)
        self._takers.add(taker)
        return taker

    def learn(self, frames: range) -> None:
        """Learn the background from these frames, once for all."""
        with self._lock:
            if not self._learned:
                self.chain.learn_background(self.reader, frames)
                self._learned = True

    def take(self, taker: CloudTaker, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took."""
        with self._lock:
            if frame not in self._held:
                self._held[frame] = read_cloud(self.chain, self.reader, frame)
                self._waiting[frame] = set(self._takers)
            found = self._held[frame]
            self._give_up(taker, frame)
            return found

    def again(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame that the run has taken before."""
        with self._lock:
            held = self._held.get(frame)
            return held if held is not None else read_cloud(self.chain, self.reader, frame)

    def leave(self, taker: CloudTaker) -> None:
        """A run takes no more clouds; those that were kept for it alone are forgotten."""
        with self._lock:
            self._takers.discard(taker)
            for frame in tuple(self._held):
                self._give_up(taker, frame)

    def _give_up(self, taker: CloudTaker, frame: int) -> None:
        waiting = self._waiting[frame]
        waiting.discard(taker)
        if not waiting:
            del self._held[frame], self._waiting[frame]


class CloudTaker:
    """One run's way to clouds that it shares with others."""

    def __init__(self, clouds: SharedClouds) -> None:
        self.chain = clouds.chain
        self.reader = clouds.reader
        self._clouds = clouds
        self._taken = -1

    def learn(self, frames: range) -> None:
        """Learn the background from these frames, unless another run has done so."""
        self._clouds.learn(frames)

    def take(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took.

        One that this run has taken before is made again, and not kept for others.
        """
        if frame <= self._taken:
            return self._clouds.again(frame)
        self._taken = frame
        return self._clouds.take(self, frame)

    def leave(self) -> None:
        """Take no more."""
        self._clouds.leave(self)
