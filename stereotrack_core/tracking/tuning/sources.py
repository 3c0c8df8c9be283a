"""Sources of disparities that remember what they have matched."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Protocol
from weakref import WeakKeyDictionary

from stereotrack_core.arrays import Float32Array, ImageArray
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import Rectification
from stereotrack_core.depth.sources import DepthFrame, DepthSource, StereoFrame, StereoSource
from stereotrack_core.memory import Memory
from stereotrack_core.recording.reader import FrameReader, FrameSet, ViewImages

EMPTY_SCENE = -1
"""Stands for the frame number of images without anybody."""


class Looking(Protocol):
    """What sources ask while they work."""

    def go_on(self) -> None:
        """Raise :class:`Cancelled` where the work is no longer wanted."""


class NumberedReader:
    """A reader that remembers which frame its images are of.

    Parameters
    ----------
    reader : FrameReader
        May be shared; it is not closed.
    work : Looking
    """

    def __init__(self, reader: FrameReader, work: Looking) -> None:
        self._reader, self._work = reader, work
        self._numbers: WeakKeyDictionary[ViewImages, int] = WeakKeyDictionary()

    def frame_set(self, k: int) -> FrameSet:
        """All images of one instant."""
        self._work.go_on()
        found = self._reader.frame_set(k)
        for images in found.views.values():
            self._numbers[images] = k
        return found

    def background(self, view: str) -> tuple[ImageArray | None, ImageArray] | None:
        """Left and reference image of a view without anybody, where there are any."""
        return self._reader.background(view)

    def number(self, images: ViewImages) -> int:
        """Frame that the images are of; :data:`EMPTY_SCENE` where they are of none."""
        return self._numbers.get(images, EMPTY_SCENE)


@dataclass(frozen=True, eq=False)
class RememberedFrame(StereoFrame):
    """A rectified pair with the disparities of the regions that were matched."""

    work: Looking | None = None
    grew: Callable[[RememberedFrame], None] = lambda _frame: None
    matched: dict[Region, Float32Array] = field(default_factory=dict)

    def disparity(self, region: Region) -> Float32Array:
        """Match the region, or take what was matched; the caller's own to change."""
        known = self.matched.get(region)
        if known is None:
            if self.work is not None:
                self.work.go_on()
            known = super().disparity(region)
            self.matched[region] = known
            self.grew(self)
        return known.copy()

    @property
    def bytes(self) -> int:
        """Bytes of images and disparities."""
        own = self.left.nbytes + self.picture.nbytes
        return own + sum(disparity.nbytes for disparity in self.matched.values())


class RememberingStereo(StereoSource):
    """A stereo source whose opened frames are kept.

    Parameters
    ----------
    rectification, parameters
        See :class:`StereoSource`.
    memory : Memory
    key : hashable
        Of the view and the parameters of matching.
    number : callable
        From images to the number of their frame.
    work : Looking
    """

    def __init__(
        self,
        rectification: Rectification,
        parameters: DepthParameters,
        memory: Memory,
        key: Hashable,
        number: Callable[[ViewImages], int],
        work: Looking,
    ) -> None:
        super().__init__(rectification, parameters)
        self._memory, self._key, self._number, self._work = memory, key, number, work

    def open(self, images: ViewImages) -> RememberedFrame:
        """Rectify, or take what was rectified; see :class:`StereoSource`."""
        self._work.go_on()
        key = ("matching", self._key, self._number(images))
        known: RememberedFrame | None = self._memory.get(key)
        if known is not None:
            return known
        new = super().open(images)

        def keep(frame: RememberedFrame) -> None:
            self._memory.put(key, frame, frame.bytes)

        return RememberedFrame(
            new.left, new.picture, new.outside, new.matcher, new.window, self._work, keep
        )


class WatchedDepth(DepthSource):
    """A source of depth images that stops when the work is no longer wanted."""

    def __init__(self, rectification: Rectification, work: Looking) -> None:
        super().__init__(rectification)
        self._work = work

    def open(self, images: ViewImages) -> DepthFrame:
        """See :class:`DepthSource`."""
        self._work.go_on()
        return super().open(images)
