"""Clouds of a recording, made again only as far as a change of parameters reaches."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from stereotrack_core.arrays import Float32Array
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.depth.chain import DepthChain, MeasuredViews, OnPart, rectification_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.mono_silhouettes import silhouette_views
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import Rectification
from stereotrack_core.depth.sources import DepthSource, StereoFrame, StereoSource
from stereotrack_core.depth.volume import settled
from stereotrack_core.errors import Cancelled
from stereotrack_core.memory import Memory, bytes_of
from stereotrack_core.parameters import Value
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader, ViewImages
from stereotrack_core.tracking.clouds import CloudSource
from stereotrack_core.tracking.frame import cloudless
from stereotrack_core.tracking.tuning.stages import Stage, stage_key

_CHAINS = 4  # chains that are kept with what they have learned of the empty scene


@dataclass(frozen=True)
class CloudKey:
    """What clouds depend on, beside their frame."""

    depth: DepthParameters
    learned_from: range  # of the background, without images of the empty scene
    detector: bool = False  # whether it makes the empty scene of mono views without one
    views: tuple[str, ...] = ()  # with depth that are used; empty: all

    def until(self, stage: Stage) -> Hashable:
        """What the result of a stage depends on."""
        if stage is Stage.MATCHING:
            return stage_key(self.depth, stage)
        learned = self.learned_from.start, self.learned_from.stop, self.detector, self.views
        return stage_key(self.depth, stage), learned


class CloudStore:
    """Keeps disparities and clouds of a recording by the parameters on which each depends.

    Serves one thread. The reader, in grey, is not closed; `limit` bytes are kept. `mono` views are
    tracked without depth.
    """

    def __init__(
        self,
        recording: Recording,
        reader: FrameReader,
        *,
        limit: int | None = None,
        mono: Sequence[str] = (),
    ) -> None:
        self._mono = tuple(mono)
        self._deep = tuple(view.name for view in recording.views if view.kind != "mono")
        self.has_depth = bool(self._deep)
        self.recording = recording
        self.reader = reader
        self.memory = Memory(limit)
        self.shapes: dict[Hashable, BodyShape] = {}
        """Shapes that were fitted, by what they depend on."""
        self.rows: dict[Hashable, float] = {}
        """By how much left images lie too low, by matching parameters, view and frames."""
        self.cancelled: Callable[[], bool] = lambda: False
        self._rectified: dict[tuple[str, float], Rectification] = {}
        self._chains: OrderedDict[CloudKey, DepthChain] = OrderedDict()
        self._fitting: dict[Hashable, dict[str, Value]] = {}

    def close(self) -> None:
        """Forget everything and end the threads."""
        for chain in self._chains.values():
            chain.close()
        self._chains.clear()
        self.memory.clear()

    def go_on(self, *_: object) -> None:
        """Raise :class:`Cancelled` where the work is no longer wanted."""
        if self.cancelled():
            raise Cancelled

    def clouds(
        self,
        key: CloudKey,
        stretch: range | None = None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> KeptClouds:
        """Clouds for a run over `stretch`, kept before all others. Raises Cancelled, InputError."""
        used = tuple(name for name in self._deep if name in key.views)
        key = replace(key, views=() if used == self._deep else used)
        points, matching = key.until(Stage.POINTS), key.until(Stage.MATCHING)

        def is_held(place: Any) -> bool:
            kind, of, frame = place
            of_key = of == points if kind == "points" else of[0] == matching
            return stretch is not None and frame in stretch and bool(of_key)

        if stretch is not None:
            self.memory.hold(is_held)
        self.cancelled = cancelled
        return KeptClouds(self, key, self.chain(key), self.reader, cancelled)

    def chain(self, key: CloudKey) -> DepthChain:
        """What makes these clouds."""
        chain = self._chains.get(key) or self._new_chain(key)
        if chain.learns:
            return chain  # it learns on from the frames of one run, and ends with that
        self._chains[key] = chain
        self._chains.move_to_end(key)
        while len(self._chains) > _CHAINS:
            self._chains.popitem(last=False)[1].close()
        return chain

    def _new_chain(self, key: CloudKey) -> DepthChain:
        def source(recording: Recording, view: View, p: DepthParameters) -> Any:
            place = view.name, p.least_focal
            if place not in self._rectified:
                self._rectified[place] = rectification_of(recording, view, p)
            if view.left is None:
                return DepthSource(self._rectified[place])
            of = key.until(Stage.MATCHING), view.name
            return _RememberingStereo(self._rectified[place], p, of, self)

        views = key.views or (None if self.has_depth or not self._mono else ())
        mono = silhouette_views(self.recording, self._mono, detector=key.detector)
        depth = self._settled(key)
        chain = DepthChain(self.recording, depth, views=views, mono=mono, sources=source)
        wanted = key.until(Stage.BACKGROUND)
        # a chain that knows the same empty scene, once and for all
        learned = next(
            (c for k, c in self._chains.items() if k.until(Stage.BACKGROUND) == wanted), None
        )
        try:
            if learned is not None:
                chain.take_background(learned, self.reader, key.learned_from)
            else:
                chain.learn_background(self.reader, key.learned_from, self.go_on)
        except BaseException:
            chain.close()
            raise
        return chain

    def _settled(self, key: CloudKey) -> DepthParameters:
        """Parameters that fit the recording, which is looked at once for all that do not differ."""
        before = key.depth.values()
        wanted = stage_key(key.depth, Stage.MATCHING), key.depth.background_empty_scene
        if wanted not in self._fitting:
            found = settled(self.recording, key.depth, self.reader, self._deep).values()
            self._fitting[wanted] = {k: v for k, v in found.items() if v != before[k]}
        return key.depth.replaced(**self._fitting[wanted])


@dataclass(eq=False)
class _Made:
    """What all views have measured in one frame, and the clouds that it was fused to."""

    seen: MeasuredViews
    clouds: dict[Hashable, Cloud] = field(default_factory=dict)

    @property
    def bytes(self) -> int:
        points = sum(bytes_of(c.points) + bytes_of(c.pixels) for c in self.clouds.values())
        return bytes_of(self.seen) + points


@dataclass(eq=False)
class KeptClouds(CloudSource):
    """Clouds for one run, taken from the store or made for it."""

    store: CloudStore
    key: CloudKey
    chain: DepthChain
    reader: FrameReader
    cancelled: Callable[[], bool]
    went_on: bool = False  # whether the background has learned from frames of this run

    def learn(self, _frames: range, _told: OnPart) -> None:
        """Forget what a background that goes on learning took from frames that come again."""
        if self.went_on:
            self.chain, self.went_on = self.store.chain(self.key), False

    def take(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of a frame, and the seconds that reading its images took. Raises Cancelled."""
        store = self.store
        store.cancelled = self.cancelled
        store.go_on()
        if not (store.has_depth or self.chain.silhouettes):
            return cloudless(frame), 0.0
        if not self.chain.learns:
            self.chain = store.chain(self.key)
            return self._kept(frame)
        # depends on all frames before it, so that it is of no use to another run
        self.went_on = True
        seen, read = self._measured(frame)
        return self.chain.fused(seen), read

    def _kept(self, frame: int) -> tuple[Cloud, float]:
        place = "points", self.key.until(Stage.POINTS), frame
        fusion = self.key.until(Stage.FUSION)
        made: _Made | None = self.store.memory.get(place)
        read = 0.0
        if made is None:
            seen, read = self._measured(frame)
            made = _Made(seen)
        if fusion not in made.clouds:
            made.clouds[fusion] = self.chain.fused(made.seen)
            self.store.memory.put(place, made, made.bytes)
        return made.clouds[fusion], read

    def _measured(self, frame: int) -> tuple[MeasuredViews, float]:
        begun = time.perf_counter()
        frame_set = self.store.reader.frame_set(frame)
        read = time.perf_counter() - begun
        return self.chain.measured(frame_set), read


class _RememberingStereo(StereoSource):
    """A stereo source of a store, which keeps the frames that were opened."""

    def __init__(
        self,
        rectification: Rectification,
        parameters: DepthParameters,
        of: tuple[Hashable, str],
        store: CloudStore,
    ) -> None:
        super().__init__(rectification, parameters)
        self._store, self._of = store, of

    def align_rows(self, images: Sequence[ViewImages]) -> None:
        """Measure the rows, or take what was measured on the same pairs."""
        place = self._of, tuple(one.frame for one in images)
        if place not in self._store.rows:
            super().align_rows(images)
            self._store.rows[place] = self.rows
        self.rows = self._store.rows[place]

    def open(self, images: ViewImages) -> _RememberedFrame:
        """Rectify, or take what was rectified; see :class:`StereoSource`."""
        self._store.go_on()
        place = "matching", self._of, images.frame
        known: _RememberedFrame | None = self._store.memory.get(place)
        return known or _RememberedFrame(
            **vars(super().open(images)), store=self._store, place=place
        )


@dataclass(frozen=True, eq=False)
class _RememberedFrame(StereoFrame):
    """A rectified pair with the disparities of the regions that were matched."""

    store: CloudStore
    place: Hashable
    matched: dict[Region, Float32Array] = field(default_factory=dict)

    def disparity(self, region: Region) -> Float32Array:
        """Match the region, or take what was matched; the caller's own to change."""
        if region not in self.matched:
            self.store.go_on()
            self.matched[region] = super().disparity(region)
            size = self.left.nbytes + self.picture.nbytes
            size += sum(disparity.nbytes for disparity in self.matched.values())
            self.store.memory.put(self.place, self, size)
        return self.matched[region].copy()
