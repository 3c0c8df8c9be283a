"""From a calibration in its own convention to cameras in metres: what is open is decided or asked.

The convention and the unit that a format documents are kept unless measured points contradict them;
how cameras usually stand is only a note. What is open is tried on the data; where these cannot
decide, the person is asked, and sees what was tried.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import PADDED, Camera, is_padded
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.evidence import Evidence, joins_all, names_in
from stereotrack_core.interop.calibrations.foreign import (
    METRES_PER_UNIT,
    ForeignCalibration,
)
from stereotrack_core.interop.calibrations.readings import (
    CONVENTIONS,
    MEANINGS,
    Fit,
    Scale,
    fit_of,
    fits,
    lengths_of,
    moved,
    scale_of,
)
from stereotrack_core.recording.camera_checks import world_camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.tables import Table

_MUCH_PX = 1000
_DOUBTFUL, _DOUBTFUL_PX = 0.01, 4.0  # of the image's diagonal; pixels

DOCUMENTED = "world-to-camera"
"""The convention that every reader gives its cameras in, as its format documents them."""


@dataclass(frozen=True, eq=False)
class Decided:
    """Cameras in metres, and how the file was read.

    `tables` show what was tried; `reasons` say why one reading was chosen, and `notes` what else
    has to be known about the cameras.
    """

    cameras: Mapping[str, Camera]
    convention: str
    unit: str
    tables: tuple[Table, ...]
    reasons: tuple[str, ...]
    notes: tuple[str, ...]


class Undecided(InputError):
    """Neither file nor data tell how to read a calibration; `table` is what was tried."""

    def __init__(self, what: str, table: Table, *, where: str, remedy: str) -> None:
        super().__init__(what, where=where, remedy=remedy)
        self.table = table


Size: TypeAlias = tuple[int, int]


def completed(
    foreign: ForeignCalibration,
    recording: Recording | None = None,
    *,
    names: Sequence[str] = (),
    size: Size | None = None,
) -> ForeignCalibration:
    """The calibration with a name and an image size for every camera.

    `names` are given by the person, in the order of the file, and `size` for cameras of which the
    file does not state it; else it is the recording's, whose cameras need to have sizes only.
    Raises InputError where a name or a size is missing or contradicts the recording.
    """
    known = {} if recording is None else recording.cameras
    sizes = {(camera.width, camera.height) for camera in known.values()}
    foreign = foreign.of_size(size or (sizes.pop() if len(sizes) == 1 else None))
    chosen = _names(foreign, recording, names)
    notes = []
    cameras = []
    for one, name in zip(foreign.cameras, chosen, strict=True):
        shown = (known[name].width, known[name].height) if name in known else None
        own = one.size or shown or size
        if own is None:
            raise InputError(
                f"the file does not state the image size of {name}",
                where=foreign.where,
                remedy="Give the recording with --recording, or the size with --size WIDTHxHEIGHT.",
            )
        if shown is not None and is_padded(own, shown):
            notes.append(PADDED.format(name, *own, *shown))
            own = shown
        if shown is not None and own != shown:
            raise InputError(
                f"the calibration of {name} is for images of {own[0]} x {own[1]} pixels, those of "
                f"the recording have {shown[0]} x {shown[1]}",
                where=foreign.where,
                remedy="Use a calibration made with images of this size, or the original images.",
            )
        cameras.append(replace(one, name=name, size=own))
    lacking = [name for name in known if name not in chosen]
    if lacking:
        notes.append(f"the file lacks {', '.join(lacking)} of the recording")
    return replace(foreign, cameras=tuple(cameras), notes=(*foreign.notes, *notes))


def _names(
    foreign: ForeignCalibration, recording: Recording | None, given: Sequence[str]
) -> list[str]:
    own = [one.name or f"cam_{i}" for i, one in enumerate(foreign.cameras)]
    if given:
        if len(given) != len(own) or len(set(given)) < len(given):
            raise InputError(
                f"the file has {len(own)} cameras: {', '.join(own)}",
                where="--names",
                remedy="Give a different name for each, in this order, separated by commas.",
            )
        return list(given)
    if recording is None or set(own) & set(recording.cameras):
        return own
    pairs = [(view.left.camera, view.image.camera) for view in recording.views if view.left]
    if own == ["left", "right"] and len(pairs) == 1:
        return list(pairs[0])
    raise InputError(
        f"its cameras are named {', '.join(own)}, but those of the recording "
        f"{', '.join(recording.cameras)}",
        where=foreign.where,
        remedy="Give the recording's names in the order of the file: --names A,B,...",
    )


def cameras_read(foreign: ForeignCalibration, convention: str) -> dict[str, Camera]:
    """Cameras of a completed calibration by a convention, in the file's unit of length."""
    placed = CONVENTIONS[convention]
    cameras = {}
    for one in foreign.cameras:
        assert one.size is not None  # noqa: S101 - it was completed
        there = (
            RigidTransform.identity()
            if one.rotation is None or one.translation is None
            else placed(one.rotation, one.translation)
        )
        cameras[one.name] = Camera(
            one.name, *one.size, one.matrix, one.distortions, one.fisheye, there
        )
    return cameras


def decide(
    foreign: ForeignCalibration,
    evidence: Evidence,
    *,
    convention: str | None = None,
    unit: str | None = None,
) -> Decided:
    """Decide what is open about a completed calibration; a choice of the person's is kept.

    Raises InputError, with what was tried, where neither file nor data tell.
    """
    if not foreign.placed:
        note = "the file does not say where the cameras are: each is at the origin of the world"
        cameras = cameras_read(foreign, DOCUMENTED)
        return Decided(cameras, DOCUMENTED, unit or "m", (), (), (*foreign.notes, note))
    chosen, tried, why, doubts = _convention(foreign, evidence, convention)
    cameras = cameras_read(foreign, chosen)
    scale, scales, because, odd = _unit(foreign, cameras, evidence, unit)
    cameras = moved(cameras, METRES_PER_UNIT[scale])
    return Decided(
        cameras,
        chosen,
        scale,
        (tried, scales),
        (why, because),
        (*foreign.notes, *doubts, *odd, *_notes(cameras)),
    )


def _notes(cameras: Mapping[str, Camera]) -> tuple[str, ...]:
    own = world_camera(cameras.values())
    if own is None:
        return ()
    return (
        f"the world is the frame of camera {own.name}: z is its viewing direction, not up. "
        "Tracking takes the axis that points up in its images; `stereotrack calibrate align` "
        "makes a world whose z does",
    )


def _convention(
    foreign: ForeignCalibration, evidence: Evidence, given: str | None
) -> tuple[str, Table, str, tuple[str, ...]]:
    """The convention, what was tried, why it was chosen, and what is doubtful about it."""
    tried = [fit_of(name, cameras_read(foreign, name), evidence) for name in CONVENTIONS]
    seen = evidence.seen and any(math.isfinite(one.error_px) for one in tried)
    best = min((one.error_px for one in tried if one.in_front > 0.5), default=math.inf)
    diagonal = max(math.hypot(*one.size) for one in foreign.cameras if one.size is not None)
    held = seen and joins_all(evidence, {one.name for one in foreign.cameras})
    fitting = [
        one.convention
        for one in tried
        if (not seen or fits(one, best, diagonal)) and (held or one.in_order is not False)
    ]
    table = _table_of_fits(tried, fitting)
    if given is not None:
        return given, table, f"convention {given}: given with --convention", ()
    where = ", ".join(f"{count} points of {name}" for name, count in names_in(evidence).items())
    doubts: tuple[str, ...] = ()
    if seen and best > max(_DOUBTFUL_PX, _DOUBTFUL * diagonal):
        doubts = (
            f"the cameras miss {where} by {best:.0f} px (median): check that every camera has its"
            " own name and calibration",
        )
    documented = next(one for one in tried if one.convention == DOCUMENTED)
    measured = not seen or fits(documented, best, diagonal)
    if DOCUMENTED not in fitting and foreign.documented and measured:
        reason = f"as {foreign.format} documents it"
        doubts = (*doubts, _unusual(fitting))
        return DOCUMENTED, table, f"convention {DOCUMENTED}: {reason}", doubts
    if DOCUMENTED in fitting:
        reason = (
            f"nothing else fits {where}"
            if len(fitting) == 1 and seen
            else f"as {foreign.format} documents it, and nothing contradicts it"
        )
        return DOCUMENTED, table, f"convention {DOCUMENTED}: {reason}", doubts
    if len(fitting) == 1 and seen:
        return fitting[0], table, f"convention {fitting[0]}: only this fits {where}", doubts
    raise _no_convention(foreign, tried, fitting, table, seen=bool(seen))


def _unusual(fitting: Sequence[str]) -> str:
    """What is odd about how cameras stand that were read as their format documents."""
    others = " or ".join(f"--convention {name}" for name in fitting)
    return (
        "read as documented, the cameras do not stand as usual: they look at no common place, or "
        "left and right are exchanged"
        + (f". With {others} they would; check them in the workbench" if others else "")
    )


def _no_convention(
    foreign: ForeignCalibration,
    tried: Sequence[Fit],
    fitting: Sequence[str],
    table: Table,
    *,
    seen: bool,
) -> Undecided:
    """Why no convention could be chosen."""
    if fitting:
        against = "the points contradict" if seen else "the places of the cameras contradict"
        what = f"{against} the convention that {foreign.format} documents; these fit: "
        what += " or ".join(fitting)
    elif seen:
        errors = ", ".join(f"{one.convention} {_pixels(one.error_px)}" for one in tried)
        what = f"no way to read rotations and translations fits the points ({errors})"
    else:
        what = "the cameras look at no common place, however rotations and translations are read"
    return Undecided(
        what,
        table,
        where=foreign.where,
        remedy="Check that calibration and recording belong together."
        if seen and not fitting
        else "Choose one with --convention, and check the cameras in the workbench.",
    )


def _unit(
    foreign: ForeignCalibration,
    cameras: Mapping[str, Camera],
    evidence: Evidence,
    given: str | None,
) -> tuple[str, Table, str, tuple[str, ...]]:
    """The unit of length, what was tried, why it was chosen, and what is doubtful about it."""
    lengths = lengths_of(cameras, evidence, foreign.square)
    tried = [scale_of(unit, metres, lengths) for unit, metres in METRES_PER_UNIT.items()]
    possible = [one.unit for one in tried if one.possible]
    table = _table_of_scales(tried)
    if given is not None:
        return given, table, f"unit {given}: given with --units", ()
    stated = foreign.unit
    kept = foreign.documented and not any(one.measured for one in tried)
    if stated is not None and (stated in possible or not lengths or kept):
        source = "stated by the file" if foreign.stated else f"what {foreign.format} writes"
        doubts: tuple[str, ...] = ()
        if lengths and stated not in possible:
            text = _lengths(next(one for one in tried if one.unit == stated))
            doubts = (f"the lengths are unusual in {stated} ({text}): if they are wrong, give the "
                      "unit with --units",)  # fmt: skip
        return stated, table, f"unit {stated}: {source}", doubts
    if len(possible) == 1 and not foreign.stated:
        text = _lengths(next(one for one in tried if one.unit == possible[0]))
        usual = "" if stated is None else f"; {foreign.format} usually writes {stated}"
        return possible[0], table, f"unit {possible[0]}: the only possible one ({text}){usual}", ()
    lines = ", ".join(f"{one.unit}: {_lengths(one)}" for one in tried)
    raise Undecided(
        f"the unit of length is not stated, and the data do not tell it ({lines})"
        if stated is None
        else f"the lengths are not possible in {stated}, the unit of {foreign.format} ({lines})",
        table,
        where=foreign.where,
        remedy=f"Give it with --units {'|'.join(possible or METRES_PER_UNIT)}.",
    )


def _table_of_fits(tried: Sequence[Fit], fitting: Sequence[str]) -> Table:
    rows = [
        (
            one.convention,
            MEANINGS[one.convention],
            _pixels(one.error_px),
            "-" if math.isnan(one.in_front) else f"{100 * one.in_front:.0f} %",
            {None: "-", True: "yes", False: "no"}[one.in_order],
            "yes" if one.convention in fitting else "no",
        )
        for one in tried
    ]
    headings = ("convention", "meaning", ">error", ">in front", "cameras in order", "fits")
    return Table("Conventions tried", headings, rows)


def _table_of_scales(tried: Sequence[Scale]) -> Table:
    rows = [
        (
            one.unit,
            _lengths(one),
            {None: "-", True: "yes", False: "no"}[one.possible],
        )
        for one in tried
    ]
    return Table("Units tried", ("unit", "lengths", "possible"), rows)


def _pixels(error: float) -> str:
    if math.isnan(error):
        return "-"
    return f"{error:.1f} px" if error < _MUCH_PX else f"over {_MUCH_PX} px"


def _lengths(one: Scale) -> str:
    return ", ".join(f"{name} {_length(metres)}" for name, metres in one.lengths) or "-"


def _length(metres: float) -> str:
    if metres < 0.01:
        return f"{1000 * metres:.2g} mm"
    return f"{metres:,.0f} m" if metres >= 100 else f"{metres:.2f} m"
