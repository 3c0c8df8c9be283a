"""Clouds that several runs over the same frames share."""

from __future__ import annotations

import threading
import time

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.reader import FrameReader


def read_cloud(chain: DepthChain, reader: FrameReader, frame: int) -> tuple[Cloud, float]:
    """Cloud of a frame, and the seconds that reading its images took."""
    begun = time.perf_counter()
    frame_set = reader.frame_set(frame)
    read = time.perf_counter() - begun
    return chain.process(frame_set), read


class SharedClouds:
    """Clouds that are made once, and forgotten when each of so many runs has taken them.

    Runs that go forward together keep only the few clouds that some have taken and others not.
    May be used by the threads of all runs at once.

    Parameters
    ----------
    chain : DepthChain
    reader : FrameReader
    takers : int
        Runs that will take every cloud exactly once.
    """

    def __init__(self, chain: DepthChain, reader: FrameReader, takers: int) -> None:
        self.chain = chain
        self.reader = reader
        self._takers = takers
        self._lock = threading.Lock()
        self._held: dict[int, tuple[tuple[Cloud, float], int]] = {}
        self._learned = False

    def __len__(self) -> int:
        return len(self._held)

    def learn(self, frames: range) -> None:
        """Learn the background from these frames, unless one of the runs has done so."""
        with self._lock:
            if not self._learned:
                self.chain.learn_background(self.reader, frames)
                self._learned = True

    def take(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took."""
        with self._lock:
            if frame in self._held:
                made, left = self._held.pop(frame)
            else:
                made, left = read_cloud(self.chain, self.reader, frame), self._takers
            if left > 1:
                self._held[frame] = made, left - 1
            return made
