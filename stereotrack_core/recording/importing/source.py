"""One source of a recording that is made: a video, or numbered images."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

from numpy.typing import NDArray

from stereotrack_core.recording.images import Keep

SourceKind: TypeAlias = Literal["video", "images", "depth"]

AGAIN = "Use another copy of the file."

METRIC_UNIT = 0.0005  # metres per count of depth maps that were floating-point metres: up to 32 m


class Pictures(Protocol):
    """Pictures of a source by number; used by one thread at a time."""

    def count(self) -> int:
        """Number of frames."""

    def read(self, k: int, keep: Keep) -> NDArray[Any]:
        """Picture of frame k; DamagedFrame where there is none."""

    def close(self) -> None:
        """Close what is open."""


@dataclass(frozen=True)
class Source:
    """One video, or the numbered images of one folder."""

    name: str  # unique among all sources that were found
    path: Path  # the video, its first chapter, or the first image
    kind: SourceKind
    width: int
    height: int  # size in pixels, as stored
    frames: int  # number of frames; for a video as far as its header states it
    fps: float | None = None  # frames per second; None where the files do not state it
    clock: bool = True  # whether a video states the times of its frames; a raw stream does not
    chapters: tuple[Path, ...] = ()
    """The files of a video that the camera split, in their order; none of other videos."""
    track: int = 0  # index of the video track in the file
    tracks: int = 1  # number of video tracks in the file
    bits: int = 8  # bits of a stored value: 16 of depth maps and of pictures with more than 8 bits
    white: int = 0  # stored value that becomes white in a picture of 8 bits; 0 until it is measured
    saturated: float = 0.0
    """Share of the pixels of the measured pictures that are as bright as white, or brighter."""
    created: float | None = None
    """Time in seconds since 1970 that a video states, even of whole seconds."""
    start: float | None = None
    """Time of the first frame in seconds since 1970, where the file states it."""
    sound: bool = False
    turned: int = 0  # degrees clockwise to look upright: 0, 90, 180 or 270
    images: tuple[Path, ...] = ()  # image files in their order; none for a video
    pattern: str = ""
    """printf pattern that the images' names fit; empty where the format cannot express them."""
    numbers: tuple[int, ...] = ()
    """Frame of each image, from 0; a number that is left out has no image."""
    lowest: int | None = None  # the number in the first image's name, where numbers count frames
    times: tuple[float, ...] = ()
    """Seconds since 1970 of each frame, where names state them."""
    uneven: float = 0.0  # largest distance of a frame from its place at a constant rate, in frames
    pause: float = 0.0  # longest time between two frames in seconds; 0 where it is not known
    unit: float | None = None  # metres per count, where the depth maps state it
    rate: float | None = None
    """Frames per second at which frames are picked by their times; None: all are taken."""
    begin: float = 0.0  # seconds after the first frame at which picking begins

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.width, self.height

    def says(self) -> str:
        """Size, length and rate in words."""
        rate = "" if self.fps is None else f", {self.fps:.4g} fps"
        chapters = f" in {len(self.chapters)} chapters" if self.chapters else ""
        return f"{self.width} x {self.height}, {self.frames} frames{rate}{chapters}"
