"""Frame sets of a recording: decoded in parallel, ahead of need, within a limit of memory."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.memory import Memory
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.images import DamagedFrame, PictureKind
from stereotrack_core.recording.stream_files import StreamSource, background_picture, open_stream


@dataclass(frozen=True, eq=False)
class ViewImages:
    """Images of one view at one instant, raw (distorted, not rotated)."""

    image: ImageArray  # (H, W) or (H, W, 3) uint8; reference image, grey or BGR
    left: ImageArray | None = None  # (H, W) or (H, W, 3) uint8; left image of a stereo view
    depth: Float32Array | None = None  # (H, W), metres along the camera's z; NaN where not measured
    mask: BoolArray | None = None  # (H, W); True on the person
    frame: int | None = None  # number in the recording; None if they show the empty scene


@dataclass(frozen=True, eq=False)
class FrameSet:
    """All images of one instant."""

    index: int  # frame number in the recording, from 0
    views: Mapping[str, ViewImages]
    """Mapping from view name to ViewImages; views whose images could not be read are absent."""
    problems: Mapping[str, str] = field(default_factory=dict)
    """Mapping from view name to str; why a view is absent, as a sentence."""


KINDS: dict[str, PictureKind] = {"depth": "depth", "mask": "grey"}
"""Of streams that are no images, by their key in ``recording.toml``."""

_MASK_THRESHOLD = 127
_READ_AHEAD_THREADS = 4
_NICE = 10


@dataclass(frozen=True, eq=False)
class _OpenStream:
    """A stream with the lock that keeps it to one thread at a time."""

    name: str
    stream: Stream
    source: StreamSource
    shift: int
    shape: tuple[int, int]
    lock: threading.Lock = field(default_factory=threading.Lock)


class FrameReader:
    """Frame sets by number, the same pictures in whatever order they are asked for.

    May be used from several threads. Pictures are shared with the cache and read-only; without
    `colour` all are grey (H, W). All views are read if none are named. So many frame sets are
    decoded in the background as `read_ahead` says. Raises InputError when a view is not known or a
    stream cannot be opened.
    """

    def __init__(
        self,
        recording: Recording,
        *,
        views: Sequence[str] | None = None,
        colour: bool = True,
        cache_bytes: int = 128 * 1024 * 1024,
        read_ahead: int = 4,
    ) -> None:
        self.recording = recording
        self.views = tuple(_chosen(recording, views))
        self._image_kind: PictureKind = "colour" if colour else "grey"
        self._cache = Memory(cache_bytes)
        self._read_ahead = read_ahead
        self._latest = -1
        self._closed = False
        self._streams: dict[tuple[str, str], _OpenStream] = {}
        try:
            for view in self.views:
                for key, stream in view.streams().items():
                    self._streams[view.name, key] = self._opened(view, key, stream)
        except InputError:
            self._close_streams()
            raise
        self._readers = ThreadPoolExecutor(len(self._streams), "read")
        threads = min(_READ_AHEAD_THREADS, len(self._streams))
        # whoever needs something now goes before; elsewhere the whole process would stand back
        nice = (lambda: os.nice(_NICE)) if sys.platform == "linux" else None
        self._ahead = ThreadPoolExecutor(threads, "read ahead", nice)
        self._backgrounds: dict[str, tuple[ImageArray | None, ImageArray] | None] = {}
        self._background_lock = threading.Lock()

    def __enter__(self) -> FrameReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def colour(self) -> bool:
        """Whether colour streams give pictures in colour."""
        return self._image_kind == "colour"

    def close(self) -> None:
        """Stop the threads, close the files, give up the cache."""
        if self._closed:
            return
        self._closed = True
        self._ahead.shutdown(wait=True, cancel_futures=True)
        self._readers.shutdown(wait=True, cancel_futures=True)
        self._close_streams()
        self._cache.clear()

    def _close_streams(self) -> None:
        for opened in self._streams.values():
            opened.source.close()

    def _opened(self, view: View, key: str, stream: Stream) -> _OpenStream:
        kind, folder = KINDS.get(key, self._image_kind), self.recording.folder
        where = f"{folder / 'recording.toml'}, view {view.name}, {key}.frames"
        source = open_stream(folder, stream.frames, kind, where)
        camera = self.recording.cameras[stream.camera or view.image.camera]
        shift, shape = stream.shift(self.recording.fps), (camera.height, camera.width)
        return _OpenStream(f"{view.name} {key}", stream, source, shift, shape)

    @property
    def frame_count(self) -> int:
        """Number of frame sets that all streams have; waits where a video has no full index."""
        return max(0, min(s.source.count() - s.shift for s in self._streams.values()))

    def frame_count_so_far(self) -> tuple[int, bool]:
        """Number of frame sets as far as it is known, and whether it is final; never waits."""
        counts = [(s.source.count_so_far(), s.shift) for s in self._streams.values()]
        count = min(known - shift for (known, _), shift in counts)
        return max(0, count), all(final for (_, final), _ in counts)

    def stream_counts(self) -> Mapping[tuple[str, str], int]:
        """Number of frames of each stream, by view name and key in ``recording.toml``."""
        return {key: s.source.count() for key, s in self._streams.items()}

    def frame_set(self, k: int) -> FrameSet:
        """All images of frame k; a view whose picture is damaged is absent. InputError for no
        frame.
        """
        self._check_number(k)
        forward = k >= self._latest
        self._latest = k
        missing = {p: s for p, s in self._streams.items() if (s.name, k) not in self._cache}
        futures = {p: self._readers.submit(self._picture, s, k) for p, s in missing.items()}
        views: dict[str, ViewImages] = {}
        problems: dict[str, str] = {}
        for view in self.views:
            places = {key: (view.name, key) for key in view.streams()}
            try:
                pictures = {
                    key: futures[place].result()
                    if place in futures
                    else self._picture(self._streams[place], k)
                    for key, place in places.items()
                }
                depth, mask = pictures.get("depth"), pictures.get("mask")
                views[view.name] = ViewImages(
                    image=pictures["right" if view.kind == "stereo" else "image"],
                    left=pictures.get("left"),
                    depth=None if depth is None else metres_of(depth, view.depth_unit),
                    mask=None if mask is None else mask > _MASK_THRESHOLD,
                    frame=k,
                )
            except DamagedFrame as problem:
                problems[view.name] = f"View {view.name}, frame {k}: {problem}."
        if problems:
            self._check_number(k, certainly=True)
        self._start_reading_ahead(k, 1 if forward else -1)
        return FrameSet(k, views, problems)

    def _check_number(self, k: int, *, certainly: bool = False) -> None:
        """Refuse what is no frame; by an estimate unless it has to be certain."""
        known, final = self.frame_count_so_far()
        if certainly or (k >= known and not final):
            known = self.frame_count
        if not 0 <= k < known:
            remedy = f"The frames are numbered 0 to {self.frame_count - 1}."
            raise InputError(f"there is no frame {k}", self.recording.name, remedy)

    def _picture(self, opened: _OpenStream, k: int) -> NDArray[Any]:
        """Picture of the recording's frame k, from the cache or decoded."""
        cached: NDArray[Any] | None = self._cache.get((opened.name, k))
        if cached is not None:
            return cached
        own = k + opened.shift
        if own < 0:
            raise DamagedFrame(f"{opened.name} starts {-own} frames later")

        def keep(number: int, picture: NDArray[Any]) -> None:
            if picture.shape[:2] == opened.shape:
                self._cache.put((opened.name, number - opened.shift), picture, picture.nbytes)

        with opened.lock:
            meanwhile: NDArray[Any] | None = self._cache.get((opened.name, k))
            if meanwhile is not None:
                return meanwhile
            try:
                picture = opened.source.read(own, keep)
            except DamagedFrame as problem:
                raise DamagedFrame(f"{opened.stream.frames}: {problem}") from None
            if picture.shape[:2] != opened.shape:
                raise DamagedFrame(
                    f"{opened.stream.frames}: the image has {picture.shape[1]} x "
                    f"{picture.shape[0]} pixels, expected {opened.shape[1]} x {opened.shape[0]}"
                )
            self._cache.put((opened.name, k), picture, picture.nbytes)
        return picture

    def _start_reading_ahead(self, k: int, step: int) -> None:
        if self._closed or self._read_ahead < 1:
            return
        known, _ = self.frame_count_so_far()
        wanted = [n for i in range(1, self._read_ahead + 1) if 0 <= (n := k + i * step) < known]
        for opened in self._streams.values():
            missing = [n for n in wanted if (opened.name, n) not in self._cache]
            if missing:
                self._ahead.submit(self._read_several, opened, missing, k)

    def _read_several(self, opened: _OpenStream, numbers: Sequence[int], asked: int) -> None:
        for n in numbers:
            if self._closed or abs(self._latest - asked) > self._read_ahead:
                return
            try:
                self._picture(opened, n)
            except DamagedFrame:
                return  # it is told when the frame itself is asked for

    def background(self, view: str) -> tuple[ImageArray | None, ImageArray] | None:
        """The empty scene (left or None, image), None if not stated; InputError if unreadable."""
        chosen = self.recording.view(view)
        with self._background_lock:
            if view not in self._backgrounds:
                self._backgrounds[view] = background_picture(
                    self.recording.folder, chosen, self._image_kind
                )
            return self._backgrounds[view]


def reference_pictures(recording: Recording) -> Recording:
    """The recording with mono views alone: of a stereo or depth view, what is drawn upon."""
    views = (replace(v, kind="mono", left=None, depth=None, mask=None) for v in recording.views)
    return replace(recording, views=tuple(views))


def _chosen(recording: Recording, views: Sequence[str] | None) -> Sequence[View]:
    if views is None:
        return recording.views
    known = {view.name: view for view in recording.views}
    for name in views:
        if name not in known:
            remedy = f"Available views: {', '.join(known)}."
            raise InputError(f"there is no view {name!r}", recording.name, remedy)
    if not views:
        raise InputError("no view is selected", recording.name, "Select at least one.")
    return [known[name] for name in dict.fromkeys(views)]


def metres_of(counts: NDArray[Any], unit: float) -> Float32Array:
    """Depth in metres (H, W) of counts; NaN where a count is 0."""
    metres: Float32Array = counts.astype(np.float32) * np.float32(unit)
    metres[counts == 0] = np.nan
    return metres


_EVERY = 4  # only every so many columns and rows are looked at
_DIFFERENCE = 8  # levels between the channels of a pixel from which it has a colour
_SHARE = 0.01  # share of such pixels from which a picture has colours


def has_colours(recording: Recording, views: Sequence[str]) -> bool:
    """Whether reference pictures of any of the views have colours, by the first frame."""
    if not views:
        return False
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        known, _ = reader.frame_count_so_far()
        return known > 0 and shows_colours(reader.frame_set(0))


def shows_colours(frame_set: FrameSet) -> bool:
    """Whether any of the frame set's reference pictures has colours."""
    for images in frame_set.views.values():
        picture = images.image
        if picture.ndim < 3:
            continue
        thin = picture[::_EVERY, ::_EVERY].astype(np.int16)
        spread = thin.max(axis=2) - thin.min(axis=2)
        if np.mean(spread >= _DIFFERENCE) > _SHARE:
            return True
    return False


def frame_count(recording: Recording, views: Sequence[str] | None = None) -> int:
    """Number of frames that all these views have; raises InputError if they cannot be read."""
    with FrameReader(recording, views=views, read_ahead=0, colour=False) as reader:
        return reader.frame_count
