"""Clouds of a stretch, made again only as far as a change reaches."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.depth.chain import DepthChain, MeasuredViews, rectification_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import Rectification
from stereotrack_core.depth.sources import DepthSource, StereoSource
from stereotrack_core.errors import Cancelled
from stereotrack_core.memory import Memory, bytes_of
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.tuning.sources import (
    NumberedReader,
    RememberingStereo,
    WatchedDepth,
)
from stereotrack_core.tracking.tuning.stages import Stage, stage_key
from stereotrack_core.tracking.tuning.work import Work

_CHAINS = 4
"""Chains that are kept with what they have learned of the empty scene."""


@dataclass(frozen=True)
class CloudKey:
    """What clouds depend on, beside their frame.

    Attributes
    ----------
    depth : DepthParameters
    learned_from : range
        Frames from which the background is learned where there are no images of the empty scene.
    colour : bool
        Whether points have colours.
    """

    depth: DepthParameters
    learned_from: range
    colour: bool = False

    def until(self, stage: Stage) -> Hashable:
        """What the result of a stage depends on."""
        if stage is Stage.MATCHING:
            return stage_key(self.depth, stage)
        learned = (self.learned_from.start, self.learned_from.stop)
        if stage is Stage.BACKGROUND:
            return stage_key(self.depth, stage), learned
        return stage_key(self.depth, stage), learned, self.colour


@dataclass(eq=False)
class _Made:
    """What all views have measured in one frame, and the clouds that it was fused to."""

    seen: MeasuredViews
    clouds: dict[Hashable, Cloud] = field(default_factory=dict)

    @property
    def bytes(self) -> int:
        points = sum(bytes_of(c.points) + bytes_of(c.pixels) for c in self.clouds.values())
        return bytes_of(self.seen) + points


class CloudStore:
    """Keeps disparities and clouds of a recording by the parameters on which each depends.

    May be asked from several threads; one of them is served at a time. What there would be to do
    (:meth:`work`) is told at any time.

    Parameters
    ----------
    recording : Recording
    reader : FrameReader
        May be shared; it is not closed.
    views : sequence of str, optional
        Views to use; all that give depth when not given.
    limit : int, optional
        Bytes that may be kept; see :class:`Memory`.

    Attributes
    ----------
    shapes : dict
        Shapes that were fitted, by what they depend on.
    """

    def __init__(
        self,
        recording: Recording,
        reader: FrameReader,
        *,
        views: Sequence[str] | None = None,
        limit: int | None = None,
    ) -> None:
        self.recording = recording
        self.reader = reader
        self.views = views
        self.memory = Memory(limit)
        self.pictures = NumberedReader(reader, self)
        self.lock = threading.Lock()
        self.shapes: dict[Hashable, BodyParameters] = {}
        self.cancelled: Callable[[], bool] = never
        self._rectified: dict[tuple[str, float], Rectification] = {}
        self._chains: OrderedDict[CloudKey, DepthChain] = OrderedDict()

    def close(self) -> None:
        """Forget everything and end the threads."""
        with self.lock:
            chains, self._chains = self._chains, OrderedDict()
            for chain in chains.values():
                chain.close()
            self.memory.clear()

    def go_on(self) -> None:
        """Raise :class:`Cancelled` where the work is no longer wanted."""
        if self.cancelled():
            raise Cancelled

    def clouds(
        self,
        key: CloudKey,
        stretch: range,
        cancelled: Callable[[], bool] | None = None,
    ) -> KeptClouds:
        """Clouds for a run over `stretch`, whose frames are kept before all others.

        Raises
        ------
        Cancelled
            Where `cancelled` says so while the background is learned.
        InputError
            For views without depth, and stereo cameras that cannot be rectified.
        """
        wanted = cancelled or never
        self.memory.hold(_is_of(key, stretch))
        with self.lock:
            self.cancelled = wanted
            chain = self._chain(key)
        return KeptClouds(self, key, chain, wanted)

    def work(self, key: CloudKey, stretch: range, *, shape: bool = False) -> Work:
        """What an attempt over a stretch has to do beyond what is kept; for words, not exact."""
        points, clouds = key.until(Stage.POINTS), key.until(Stage.FUSION)
        known = [self.memory.get(("points", points, frame)) for frame in stretch]
        measured = sum(made is None for made in known)
        fused = sum(made is None or clouds not in made.clouds for made in known)
        names = [view.name for view in self.recording.views if view.kind == "stereo"]
        used = [name for name in names if self.views is None or name in self.views]
        matching = key.until(Stage.MATCHING)
        matched = sum(
            made is None
            and any(("matching", (matching, name), frame) not in self.memory for name in used)
            for frame, made in zip(stretch, known, strict=True)
        )
        background = self._learned(key) is None
        return Work(len(stretch), matched, measured, fused, background, shape)

    # ---- inside; the lock is held

    def _chain(self, key: CloudKey) -> DepthChain:
        chain = self._chains.get(key)
        if chain is None or chain.learns:
            chain = self._new_chain(key)
        chains = OrderedDict(self._chains)  # others may be looking through those that are there
        chains[key] = chain
        chains.move_to_end(key)
        too_many = [chains.popitem(last=False)[1] for _ in range(len(chains) - _CHAINS)]
        self._chains = chains
        for old in too_many:
            old.close()
        return chain

    def _new_chain(self, key: CloudKey) -> DepthChain:
        learned = self._learned(key)
        old = self._chains.get(key)
        if old is not None:
            self._chains = OrderedDict(one for one in self._chains.items() if one[0] != key)
            old.close()

        def source(recording: Recording, view: View, p: DepthParameters) -> Any:
            return self._source(recording, view, p, key)

        chain = DepthChain(
            self.recording, key.depth, views=self.views, colour=key.colour, sources=source
        )
        try:
            if learned is not None:
                chain.take_background(learned, self.pictures, key.learned_from)
            else:
                chain.learn_background(self.pictures, key.learned_from)
        except BaseException:
            chain.close()
            raise
        return chain

    def _learned(self, key: CloudKey) -> DepthChain | None:
        """A chain that knows the same empty scene, once and for all."""
        wanted = key.until(Stage.BACKGROUND)
        for other, chain in self._chains.items():
            if other.until(Stage.BACKGROUND) == wanted and not chain.learns:
                return chain
        return None

    def _source(
        self, recording: Recording, view: View, p: DepthParameters, key: CloudKey
    ) -> StereoSource | DepthSource:
        place = view.name, p.least_focal
        if place not in self._rectified:
            self._rectified[place] = rectification_of(recording, view, p)
        rectified = self._rectified[place]
        if view.left is None:
            return WatchedDepth(rectified, self)
        matched = key.until(Stage.MATCHING), view.name
        return RememberingStereo(rectified, p, self.memory, matched, self.pictures.number, self)


class KeptClouds:
    """Clouds for one run, taken from the store or made for it."""

    def __init__(
        self, store: CloudStore, key: CloudKey, chain: DepthChain, cancelled: Callable[[], bool]
    ) -> None:
        self.chain, self.reader = chain, store.reader
        self._store, self._key, self._cancelled = store, key, cancelled

    def learn(self, _frames: range) -> None:
        """Do nothing: the store's chains have learned what they know."""

    def take(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took.

        Raises
        ------
        Cancelled
            Where the run is no longer wanted.
        """
        store = self._store
        with store.lock:
            store.cancelled = self._cancelled
            store.go_on()
            return self._learning(frame) if self.chain.learns else self._kept(frame)

    def _learning(self, frame: int) -> tuple[Cloud, float]:
        # depends on all frames before it, so that it is of no use to another run
        seen, read = self._measured(frame)
        return self.chain.fused(seen), read

    def _kept(self, frame: int) -> tuple[Cloud, float]:
        place = "points", self._key.until(Stage.POINTS), frame
        fusion = self._key.until(Stage.FUSION)
        made: _Made | None = self._store.memory.get(place)
        read = 0.0
        if made is None:
            seen, read = self._measured(frame)
            made = _Made(seen)
        if fusion not in made.clouds:
            made.clouds[fusion] = self.chain.fused(made.seen)
            self._store.memory.put(place, made, made.bytes)
        return made.clouds[fusion], read

    def _measured(self, frame: int) -> tuple[MeasuredViews, float]:
        begun = time.perf_counter()
        frame_set = self._store.pictures.frame_set(frame)
        read = time.perf_counter() - begun
        return self.chain.measured(frame_set), read


def _is_of(key: CloudKey, stretch: range) -> Callable[[Any], bool]:
    """Whether a place in the memory belongs to a stretch with these parameters."""
    points, matching = key.until(Stage.POINTS), key.until(Stage.MATCHING)

    def held(place: Any) -> bool:
        kind, of, frame = place
        if frame not in stretch:
            return False
        return bool(of == points if kind == "points" else of[0] == matching)

    return held


def never() -> bool:
    """What asks nobody whether to stop."""
    return False
