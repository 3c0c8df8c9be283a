"""The sources of a recording that is made, videos or numbered images, and their roles in views.

Roles are proposed by names and decided by a person.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Cameras

SourceKind: TypeAlias = Literal["video", "images", "depth"]

AGAIN = "Use another copy of the file."

METRIC_UNIT = 0.0005  # metres per count of depth maps that were floating-point metres: up to 32 m


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
    created: float | None = None  # time in seconds since 1970 that a video states, even if whole
    start: float | None = None  # time of the first frame, seconds since 1970, if the file states it
    sound: bool = False
    turned: int = 0  # degrees clockwise to look upright: 0, 90, 180 or 270
    images: tuple[Path, ...] = ()  # image files in their order; none for a video
    pattern: str = ""  # printf pattern of the images' names; empty if there is none
    numbers: tuple[int, ...] = ()  # frame of each image, from 0; left-out numbers have no image
    lowest: int | None = None  # the number in the first image's name, where numbers count frames
    times: tuple[float, ...] = ()  # seconds since 1970 of each frame, where names state them
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


Role: TypeAlias = Literal[
    "mono",
    "left",
    "right",
    "side by side",
    "side by side, swapped",
    "depth",
    "image",
    "mask",
    "unused",
]
"""Role of a source in its view. ``side by side`` holds both images of a stereo camera, ``swapped``
right | left; ``image`` and ``mask`` belong to the depth source of the same view.
"""

ROLES: Mapping[Role, str] = {
    "mono": "single camera",
    "left": "left image of a stereo camera",
    "right": "right image of a stereo camera",
    "side by side": "both images of a stereo camera, left | right",
    "side by side, swapped": "both images of a stereo camera, right | left",
    "depth": "depth map",
    "image": "image of a depth camera",
    "mask": "mask of the person for a depth camera",
    "unused": "not used",
}
"""Every role in words."""

_USUAL_UNIT = 0.001  # metres per count of a Kinect, RealSense and most others


@dataclass(frozen=True)
class Use:
    """Role and view of one source."""

    source: Source
    role: Role = "mono"
    view: str = ""  # name of the view that it belongs to
    mirrored: bool = False  # whether its images, mirrored as those of a Kinect v1, are turned back
    background: Path | None = None  # a picture or video of the empty scene, as this source shows it
    lead: float = 0.0  # the source's own frame at the common instant; with fractions, also negative


@dataclass(frozen=True)
class Choices:
    """Everything that decides what recording is made."""

    name: str
    uses: tuple[Use, ...]
    fps: float | None  # frame sets per second
    calibration: Path | None = None  # without it, cameras are guessed from the images' size
    given: Cameras | None = None
    """The cameras of the calibration by name, where it is no calibration.toml."""
    cameras: Mapping[str, str] = field(default_factory=dict)
    """Name of the camera in the calibration by camera name here, where they differ."""
    depth_unit: float = _USUAL_UNIT  # metres per count of the depth maps that do not state it
    resample: bool = True  # whether frames are picked by their times if rates differ or are uneven

    def used(self) -> tuple[Use, ...]:
        """The uses that are not ``unused``."""
        return tuple(use for use in self.uses if use.role != "unused")

    def guessed(self) -> bool:
        """Whether the cameras are guessed from the size of the images."""
        return self.calibration is None

    def camera_names(self) -> tuple[str, ...]:
        """Names that the cameras get, in order of their views."""
        names = [name for use in self.used() for name in cameras_of(use)]
        return tuple(dict.fromkeys(names))


def cameras_of(use: Use) -> tuple[str, ...]:
    """Names of the cameras that a source shows."""
    if use.role == "side by side":
        return f"{use.view}_left", f"{use.view}_right"
    if use.role == "side by side, swapped":
        return f"{use.view}_right", f"{use.view}_left"
    return (f"{use.view}_{use.role}" if use.role in ("left", "right") else use.view,)


def view_for(use: Use, role: Role) -> str:
    """The view that a source belongs to when it gets another role, unless another is named."""
    return use.view if role in ("left", "right", "depth", "image", "mask") else use.source.name


def size_of(use: Use) -> tuple[int, int]:
    """Width and height of the images of each camera that a source shows."""
    halves = 2 if use.role.startswith("side") else 1
    return use.source.width // halves, use.source.height


def problems_of(choices: Choices) -> Iterator[InputError]:
    """Everything about choices that keeps a recording from being made of them."""
    used = choices.used()
    if not used:
        yield InputError("no source is used", remedy="Choose what at least one source shows.")
    if choices.fps is None:
        yield InputError(
            "the files do not state their frame rate", remedy="Give the frames per second."
        )
    elif not 0 < choices.fps < 10000:
        what = f"{choices.fps:g} frames per second is not possible"
        yield InputError(what, remedy="Use more than 0 and less than 10000.")
    for view in dict.fromkeys(use.view for use in used):
        yield from _problems_of_view(view, [use for use in used if use.view == view])
    if choices.depth_unit <= 0 or choices.depth_unit > 1:
        what = f"{choices.depth_unit:g} metres per count is not possible"
        yield InputError(what, remedy="0.001 means millimetres.")


_NO_DEPTH = "the depth map is missing"
_TOGETHER: Mapping[frozenset[str], str] = {
    **{frozenset({one}): "" for one in ("mono", "side by side", "side by side, swapped", "depth")},
    **{frozenset({"depth", *more}): "" for more in (("image",), ("mask",), ("image", "mask"))},
    frozenset({"left", "right"}): "",
    frozenset({"left"}): "the right image is missing",
    frozenset({"right"}): "the left image is missing",
    **{frozenset(some): _NO_DEPTH for some in (("image",), ("mask",), ("image", "mask"))},
}
"""Roles that make a view, or the part that they lack."""


def _problems_of_view(view: str, uses: Sequence[Use]) -> Iterator[InputError]:
    where = f"view {view}"
    if not re.fullmatch(r"[\w-]+", view):
        yield InputError("a view needs a name of letters, digits, _ or -", where, "Rename it.")
    roles = [use.role for use in uses]
    lack = _TOGETHER.get(frozenset(roles), "its sources do not fit together")
    if not lack and len(set(roles)) < len(roles):
        lack = f"{len(roles)} sources show the same part of it"
    if lack:
        names = ", ".join(use.source.name for use in uses)
        remedy = "Change what they show, or their views."
        yield InputError(f"{lack} ({names})", where, remedy)
        return
    sizes = {use.source.size for use in uses}
    if len(sizes) > 1:
        both = " and ".join(f"{w} x {h}" for w, h in sorted(sizes))
        remedy = "Use images of one size, registered to each other."
        if "depth" in roles:
            remedy = "Use depth that is aligned to the image, or leave the image out."
        yield InputError(f"its images have different sizes, {both} pixels", where, remedy)
    for use in uses:
        if use.role.startswith("side") and use.source.width % 2:
            what = f"an image {use.source.width} pixels wide has no two equal halves"
            yield InputError(what, where, "Use it as a single camera.")
        if use.role == "depth" and use.source.kind != "depth":
            what = f"{use.source.name} is no depth map of 16 bits or floating-point numbers"
            yield InputError(what, where, "Change what it shows.")


_MUCH_SATURATED = 0.02  # of the pixels
_PAUSE = 3.0  # frames
_MOST_DRIFT = 0.5  # frames over the length of a source


def doubts_about(choices: Choices) -> tuple[str, ...]:
    """Doubts about choices of which a recording can be made, in sentences."""
    used = choices.used()
    doubts = [*_doubts_about_rates(choices), *_doubts_about_numbers(used)]
    for one in (use.source for use in used if use.source.bits > 8 and use.role != "depth"):
        levels = f"Black is 0, white is {one.white}, in all its images."
        if one.saturated > _MUCH_SATURATED:
            share = f"{100 * one.saturated:.0f} % of its pixels are white"
            levels += f" {share}: it was overexposed, or has more bits."
        doubts.append(f"{one.name} has 16 bits: it is written again with 8. {levels}")
    if choices.guessed():
        doubts.append(GUESS)
    return tuple(doubts)


def _doubts_about_rates(choices: Choices) -> Iterator[str]:
    used, fps = choices.used(), choices.fps or 1.0
    rates = [use.source.fps for use in used if use.source.fps is not None]
    for use in used:
        source = use.source
        if source.rate is not None:
            why = f"at {source.fps or fps:.4g} frames per second"
            if source.uneven > _MOST_DRIFT:
                why = f"up to {source.uneven:.1f} frames from even"
            rate = f"{source.rate:.4g} frames per second, each the nearest in time"
            yield f"The frames of {source.name} are {why}. It is written again with {rate}."
            if source.pause * source.rate > _PAUSE:
                gap = f"{source.name} has no frame for up to {source.pause:.2f} s"
                yield f"{gap}. The last one is repeated there."
            continue
        if source.fps is None and rates:
            taken = f"its frames are taken one for one, {fps:.5g} per second as in the other files"
            yield f"{source.name} does not state its frame rate: {taken}."
        drift = 0.0 if source.fps is None else source.frames * abs(source.fps / rates[0] - 1.0)
        if drift > _MOST_DRIFT and source.fps is not None:
            states = f"{source.name} states {source.fps:.5g} frames per second"
            off = f"at its end it may be {drift:.0f} frames off"
            yield f"{states} and {rates[0]:.5g} would be needed: {off}."
        elif source.uneven > _MOST_DRIFT:
            yield f"The frames of {source.name} are up to {source.uneven:.1f} frames from even."


def _doubts_about_numbers(used: Sequence[Use]) -> Iterator[str]:
    """Images whose numbers begin elsewhere, or that have gaps."""
    sources = [use.source for use in used if use.source.images]
    begins = {one.name: one.lowest for one in sources if one.lowest is not None}
    if len(set(begins.values())) > 1:
        listed = ", ".join(f"{name} with {number}" for name, number in begins.items())
        taken = "The first image of each is taken for the same instant."
        remedy = "If equal numbers are, set the first frames."
        yield f"The numbers of the images begin differently: {listed}. {taken} {remedy}"
    for one in sources:
        if missing := one.frames - len(one.images):
            lack = f"{one.name} lacks {missing} of {one.frames} numbers"
            yield f"{lack}: these frames have no image."


GUESS = (
    "Without a calibration, the cameras are guessed from the size of the images. The recording "
    "can be viewed and landmarks can be clicked. 3-D positions, suggested positions in other "
    "views, fitting and tracking need a calibration."
)
