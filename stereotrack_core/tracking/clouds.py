"""Clouds of a recording: read, matched and fused frame by frame, ahead of who works on them."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache, partial
from typing import TypeAlias

from stereotrack_core.depth.chain import DepthChain, OnPart
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.mono_silhouettes import silhouette_views
from stereotrack_core.depth.volume import settled
from stereotrack_core.one_thread import one_blas_thread, one_opencv_thread
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections, own_detections
from stereotrack_core.recording.reader import FrameReader, has_colours
from stereotrack_core.recording.selection import tracked_views
from stereotrack_core.recording.sighted_keypoints import keypoints_in_views
from stereotrack_core.tracking.detecting import seen_keypoints
from stereotrack_core.tracking.frame import cloudless
from stereotrack_core.tracking.run_spec import Hooks, RunSpec

_AHEAD = 2  # clouds that are made while the tracker works on an earlier one
_SHARED = 16  # clouds, some 10 MB each, by which runs side by side may be apart
ReadCloud: TypeAlias = tuple[Cloud, float]  # a cloud, and the seconds that reading its images took


def chain_of(
    recording: Recording, spec: RunSpec, views: Sequence[str], reader: FrameReader | None = None
) -> tuple[DepthChain, FrameReader]:
    """Depth chain and reader of a run over these views, of mono views for silhouettes at most."""
    deep = tuple(name for name in views if recording.view(name).kind != "mono")
    coloured = spec.settings.tracking.wants_colour and has_colours(recording, deep)
    colour = coloured if spec.colour is None else spec.colour
    reader = reader or FrameReader(recording, views=views, colour=colour)
    depth = settled(recording, spec.settings.depth, reader, deep)
    mono = silhouette_views(
        recording, views, detector=spec.detector and spec.settings.uses_detector
    )
    return DepthChain(recording, depth, views=deep, mono=mono, colour=coloured), reader


class CloudSource:
    """Bare clouds, each made on demand."""

    def __init__(self, chain: DepthChain, reader: FrameReader) -> None:
        self.chain, self.reader = chain, reader

    def learn(self, frames: range, told: OnPart) -> None:
        """Learn the background from these frames, unless that is done already."""
        self.chain.learn_background(self.reader, frames, told)

    def take(self, frame: int) -> ReadCloud:
        """Cloud of a frame, and the seconds that reading its images took; empty without a view."""
        if not (self.chain.view_names or self.chain.silhouettes):
            return cloudless(frame), 0.0
        begun = time.perf_counter()
        frame_set = self.reader.frame_set(frame)
        read = time.perf_counter() - begun
        return self.chain.process(frame_set), read


class Clouds(AbstractContextManager["Clouds"]):
    """Clouds of a recording's frames, with keypoints and clicks; matrices use one thread meanwhile.

    A given `source` is not closed by :meth:`close`. `settings` have the depth parameters that fit
    the recording; `detector` is the pose detector that looks at the pictures, or None. Raises
    InputError if a view is unknown or no view gives depth.
    """

    def __init__(
        self, recording: Recording, spec: RunSpec, source: CloudSource | None = None
    ) -> None:
        self.recording, self.spec = recording, spec
        self.views = tracked_views(recording, spec.views, spec.keypoints)
        self._keypoints = keypoints_in_views(recording, self.views, spec.keypoints)
        self.detections = own_detections(recording) or Detections()
        self._is_own = source is None
        self._source = source or CloudSource(*chain_of(recording, spec, self.views))
        self.frames = spec.frames_of(self.reader.frame_count)
        self.settings = dataclasses.replace(spec.settings, depth=self.chain.parameters)
        looks = spec.detector and spec.keypoints is None
        given = recording, self.views, self.reader, self.settings, spec.seen
        self.detector = seen_keypoints(*given) if looks else None
        self._kept: dict[int, ReadCloud] = {}
        self._releases = one_blas_thread.hold(), one_opencv_thread.hold()

    @property
    def chain(self) -> DepthChain:
        """From images to bare clouds."""
        return self._source.chain

    @property
    def reader(self) -> FrameReader:
        """Reader of the recording."""
        return self._source.reader

    @property
    def have_depth(self) -> bool:
        """Whether any view gives depth; else keypoints alone are followed."""
        return bool(self.chain.view_names)

    def learn(self, frames: range, hooks: Hooks) -> None:
        """Learn the background from these frames."""
        self._source.learn(frames, partial(hooks.on_preparing, "learning the background"))

    def take(self, frame: int) -> ReadCloud:
        """Cloud of a frame, and the seconds that reading its images took."""
        if frame in self._kept:
            return self._kept.pop(frame)
        cloud, read = self._source.take(frame)
        clicks = self.spec.clicks.until(frame) if self.spec.clicks else ()
        seen = self._keypoints(frame)
        if self.detector is not None:
            seen = self.detector.of(cloud, self.frames.start)
        return dataclasses.replace(cloud, keypoints=seen, clicks=clicks), read

    def keep(self, frame: int) -> Cloud:
        """Cloud of a frame, which is kept until it is taken."""
        if frame not in self._kept:
            self._kept[frame] = self.take(frame)
        return self._kept[frame][0]

    def drop(self, frame: int) -> bool:
        """Forget a kept cloud; whether there was one."""
        return self._kept.pop(frame, None) is not None

    def forget(self, before: int | None = None) -> None:
        """Forget kept clouds of frames before one, or all."""
        self._kept = {k: c for k, c in self._kept.items() if before is not None and k >= before}

    @contextmanager
    def ahead(self, frames: range) -> Iterator[Iterator[ReadCloud]]:
        """Clouds of frames in their order; while one is worked on, the next ones are made."""
        with ThreadPoolExecutor(1, thread_name_prefix="cloud") as pool:
            yield self._made_in(pool, frames)

    def _made_in(self, pool: ThreadPoolExecutor, frames: range) -> Iterator[ReadCloud]:
        waiting: deque[Future[ReadCloud]] = deque()
        for frame in frames:
            waiting.append(pool.submit(self.take, frame))
            if len(waiting) > _AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()

    def close(self) -> None:
        """Close what is its own."""
        if self._is_own:
            self.chain.close()
            self.reader.close()
        for release in self._releases:
            release()

    def __exit__(self, *_: object) -> None:
        self.close()


class SharedClouds(CloudSource):
    """Clouds of runs that are made side by side; each cloud is made once, and kept for a while."""

    def __init__(self, chain: DepthChain, reader: FrameReader) -> None:
        super().__init__(chain, reader)
        self._lock = threading.Lock()
        self._made = lru_cache(_SHARED)(super().take)
        self._learned = False

    def learn(self, frames: range, told: OnPart) -> None:
        """Learn the background from these frames, once for all."""
        with self._lock:
            if not self._learned:
                super().learn(frames, told)
                self._learned = True

    def take(self, frame: int) -> ReadCloud:
        """Cloud of a frame."""
        with self._lock:
            return self._made(frame)
