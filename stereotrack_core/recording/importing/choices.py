"""What is made of each source, and in what views: proposed by names, decided by a person."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.sources import Found, Source, open_source

Role: TypeAlias = Literal[
    "mono", "left", "right", "side by side", "side by side, swapped", "depth", "image", "unused"
]
"""What a source shows of its view.

``side by side`` holds the left and the right image of a stereo camera in its left and right half,
``swapped`` the other way round; ``image`` belongs to the depth source of the same view.
"""

ROLES: Mapping[Role, str] = {
    "mono": "single camera",
    "left": "left image of a stereo camera",
    "right": "right image of a stereo camera",
    "side by side": "both images of a stereo camera, left | right",
    "side by side, swapped": "both images of a stereo camera, right | left",
    "depth": "depth map",
    "image": "image of a depth camera",
    "unused": "not used",
}
"""Every role in words."""

_SIDE_BY_SIDE = 2.5
"""Width over height from which an image is taken for two; the widest films have 2.4."""

_SIDES: Mapping[str, Role] = {
    "left": "left", "l": "left", "links": "left", "right": "right", "r": "right", "rechts": "right",
}  # fmt: skip
_DEPTH_WORDS = frozenset({"depth", "d", "z", "tiefe"})
_IMAGE_WORDS = frozenset({"image", "color", "colour", "rgb", "ir", "grey", "gray", "img"})
_NO_STREAM = frozenset({"mask", "masks", "background", "empty"})
_PAIR = re.compile(r"(.*?)(cam|camera)[_-]?([01])", re.IGNORECASE)

_USUAL_UNIT = 0.001  # metres per count of a Kinect, RealSense and most others
_UNITS = (0.001, 0.00025, 0.0002, 0.0001)
_ROOM = (0.3, 8.0)  # metres; the middle distance of what a depth camera sees indoors


@dataclass(frozen=True)
class Use:
    """What one source is used as."""

    source: Source
    role: Role = "mono"
    view: str = ""
    """Name of the view that it belongs to."""
    mirrored: bool = False
    """Whether its images are mirror images, as those of the Kinect v1, to be turned back."""
    lead: float = 0.0
    """The source's own frame at the common instant; with fractions, also negative."""


@dataclass(frozen=True)
class Choices:
    """Everything that decides what recording is made."""

    name: str
    uses: tuple[Use, ...]
    fps: float | None
    """Frame sets per second."""
    calibration: Path | None = None
    """A calibration.toml; None: cameras are guessed from the size of the images."""
    cameras: Mapping[str, str] = field(default_factory=dict)
    """Name of the camera in the calibration by camera name here, where they differ."""
    depth_unit: float = _USUAL_UNIT
    """Metres per count of the depth maps."""

    def used(self) -> tuple[Use, ...]:
        """The uses that are not ``unused``."""
        return tuple(use for use in self.uses if use.role != "unused")

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
    return use.view if role in ("left", "right", "depth", "image") else use.source.name


def size_of(use: Use) -> tuple[int, int]:
    """Width and height of the images of each camera that a source shows."""
    halves = 2 if use.role.startswith("side") else 1
    return use.source.width // halves, use.source.height


def propose(found: Found) -> Choices:
    """What the sources probably are, by their names and sizes."""
    uses = [_by_itself(source) for source in found.sources]
    _pair_by_number(uses)
    uses = [_without_partner(use, uses) for use in uses]
    folder = found.folder
    calibration = None if folder is None else folder / "calibration.toml"
    return Choices(
        name=folder.resolve().name if folder is not None else "recording",
        uses=tuple(_renamed(uses)),
        fps=found.fps,
        calibration=calibration if calibration is not None and calibration.is_file() else None,
    )


def guessed_unit(source: Source) -> float:
    """Metres per count that put the scene of a depth source at the distance of a room."""
    reader = open_source(source, "depth")
    try:
        counts = reader.read(0, lambda _number, _picture: None)
    finally:
        reader.close()
    known = counts[counts > 0]
    if not known.size:
        return _USUAL_UNIT
    middle = float(np.median(known))
    fitting = [unit for unit in _UNITS if _ROOM[0] <= middle * unit <= _ROOM[1]]
    return fitting[0] if fitting else _USUAL_UNIT


def problems_of(choices: Choices) -> tuple[InputError, ...]:
    """Everything about choices that keeps a recording from being made of them."""
    return tuple(_problems(choices))


# ---- proposals


def _by_itself(source: Source) -> Use:
    """What a source is as far as its own name and size tell."""
    words = [word for word in re.split(r"[_\-. ]+", source.name) if word]
    for place, word in enumerate(words):
        rest = "_".join(words[:place] + words[place + 1 :])
        side = _SIDES.get(word.lower())
        at_end = place in (0, len(words) - 1)
        if side is not None and at_end and (len(word) > 1 or rest):
            return Use(source, side, rest or "stereo")
        if word.lower() in _NO_STREAM:
            return Use(source, "unused", source.name)
        if word.lower() in _DEPTH_WORDS and source.kind == "depth":
            return Use(source, "depth", rest or "depth")
        if word.lower() in _IMAGE_WORDS and source.kind != "depth":
            return Use(source, "image", rest or "depth")
    if source.kind == "depth":
        return Use(source, "depth", source.name)
    wide = source.width >= _SIDE_BY_SIDE * source.height and source.width % 2 == 0
    return Use(source, "side by side" if wide else "mono", source.name)


def _pair_by_number(uses: list[Use]) -> None:
    """Take ``cam0`` and ``cam1`` for a stereo camera where there is no third."""
    matches = {
        index: match
        for index, use in enumerate(uses)
        if use.role == "mono" and (match := _PAIR.fullmatch(use.source.name))
    }
    stems = [match.group(1) for match in matches.values()]
    for index, match in matches.items():
        stem = match.group(1)
        sizes = {uses[other].source.size for other, m in matches.items() if m.group(1) == stem}
        alone = sum(use.source.name.startswith(stem) for use in uses) == 2
        if stems.count(stem) == 2 and len(sizes) == 1 and alone:
            side: Role = "left" if match.group(3) == "0" else "right"
            uses[index] = replace(uses[index], role=side, view=stem.strip("_-. ") or "stereo")


def _without_partner(use: Use, uses: Sequence[Use]) -> Use:
    """A single camera where what its name promises has no partner of the same size."""
    partner: Mapping[Role, Role] = {"left": "right", "right": "left", "image": "depth"}
    wanted = partner.get(use.role)
    if wanted is None:
        return use
    for other in uses:
        if other.role == wanted and other.view == use.view and other.source.size == use.source.size:
            return use
    return replace(use, role="mono", view=use.source.name)


def _renamed(uses: Sequence[Use]) -> Iterator[Use]:
    """The same with names of views that differ where the views do."""
    taken: dict[tuple[str, str], str] = {}
    for use in uses:
        kind = use.role if use.role in ("mono", "side by side") else "several"
        key = (use.view, use.source.name if kind != "several" else kind)
        if key not in taken:
            name, number = use.view, 2
            while name in taken.values():
                name, number = f"{use.view}_{number}", number + 1
            taken[key] = name
        yield replace(use, view=taken[key])


# ---- problems


def _problems(choices: Choices) -> Iterator[InputError]:
    used = choices.used()
    if not used:
        yield InputError("no source is used", remedy="Choose what at least one source shows.")
    if choices.fps is None:
        yield InputError(
            "the files do not state their frame rate", remedy="Give the frames per second."
        )
    elif not 0 < choices.fps < 10000:
        yield InputError(
            f"{choices.fps:g} frames per second is not possible",
            remedy="Use more than 0 and less than 10000.",
        )
    for view in dict.fromkeys(use.view for use in used):
        yield from _problems_of_view(view, [use for use in used if use.view == view])
    yield from _other_rates(used)
    if choices.depth_unit <= 0 or choices.depth_unit > 1:
        yield InputError(
            f"{choices.depth_unit:g} metres per count is not possible",
            remedy="0.001 means millimetres.",
        )


_TOGETHER: Mapping[frozenset[str], str] = {
    frozenset({"mono"}): "",
    frozenset({"left", "right"}): "",
    frozenset({"side by side"}): "",
    frozenset({"side by side, swapped"}): "",
    frozenset({"depth"}): "",
    frozenset({"depth", "image"}): "",
    frozenset({"left"}): "the right image is missing",
    frozenset({"right"}): "the left image is missing",
    frozenset({"image"}): "the depth map is missing",
}
"""Roles that make a view, or what they lack."""


def _problems_of_view(view: str, uses: Sequence[Use]) -> Iterator[InputError]:
    where = f"view {view}"
    if not re.fullmatch(r"[\w-]+", view):
        yield InputError(
            "a view needs a name of letters, digits, _ or -", where=where, remedy="Rename it."
        )
    roles = [use.role for use in uses]
    lack = _TOGETHER.get(frozenset(roles), "its sources do not fit together")
    if not lack and len(set(roles)) < len(roles):
        lack = f"{len(roles)} sources show the same part of it"
    if lack:
        names = ", ".join(use.source.name for use in uses)
        yield InputError(
            f"{lack} ({names})", where=where, remedy="Change what they show, or their views."
        )
        return
    sizes = {use.source.size for use in uses}
    if len(sizes) > 1:
        both = " and ".join(f"{w} x {h}" for w, h in sorted(sizes))
        yield InputError(
            f"its images have different sizes, {both} pixels",
            where=where,
            remedy="Use images of one size, registered to each other.",
        )
    for use in uses:
        if use.role.startswith("side") and use.source.width % 2:
            yield InputError(
                f"an image {use.source.width} pixels wide has no two equal halves",
                where=where,
                remedy="Use it as a single camera.",
            )
        if (use.role == "depth") != (use.source.kind == "depth"):
            yield InputError(
                f"{use.source.name} {'is no' if use.role == 'depth' else 'is a'} 16-bit depth map",
                where=where,
                remedy="Change what it shows.",
            )


_RATES_AGREE = 0.005  # of the rate
_MOST_DRIFT = 0.5  # frames over the length of a source


def _other_rates(used: Sequence[Use]) -> Iterator[InputError]:
    """Sources that run at other rates, so that frame k of all cannot be the same instant."""
    rates = {use.source.name: use.source.fps for use in used if use.source.fps is not None}
    usual = max(sorted(rates.values()), key=list(rates.values()).count, default=None)
    for name, rate in rates.items():
        if usual is not None and abs(rate / usual - 1.0) > _RATES_AGREE:
            yield InputError(
                f"{name} has {rate:.4g} frames per second, others have {usual:.4g}",
                remedy="Convert all to the same frame rate first. Frame k of all sources must be "
                "the same instant.",
            )


def doubts_about(choices: Choices) -> tuple[str, ...]:
    """What may be wrong with choices of which a recording can be made, in sentences."""
    used = choices.used()
    rates = [use.source.fps for use in used if use.source.fps is not None]
    doubts = []
    for use in used:
        rate, frames = use.source.fps, use.source.frames
        drift = 0.0 if rate is None else frames * abs(rate / rates[0] - 1.0)
        if drift > _MOST_DRIFT:
            doubts.append(
                f"{use.source.name} states {rate:.5g} frames per second and {rates[0]:.5g} would "
                f"be needed: at its end it may be {drift:.0f} frames off."
            )
    if choices.calibration is None:
        doubts.append(GUESS)
    return tuple(doubts)


GUESS = (
    "Without a calibration, the cameras are guessed from the size of the images. The recording "
    "can be viewed and landmarks can be clicked. 3-D positions, suggested positions in other "
    "views, fitting and tracking need a calibration."
)
