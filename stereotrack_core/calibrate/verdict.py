"""What a calibration is worth in a sentence, and what to film again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.work import Search
from stereotrack_core.calibrate.world import World
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera

Grade: TypeAlias = Literal["good", "doubtful", "bad"]

_GOOD_PX, _POOR_PX = 0.4, 1.0  # held-out error of sharp pictures; of pictures that are not
_UNEVEN_M = 0.015  # standard deviation of what an alignment rests on
_FEW_FOUND = 0.5  # share of the pictures in which the board should be found


@dataclass(frozen=True)
class Verdict:
    """`words` begin with what it comes to; `remarks` are sentences, with what to do."""

    grade: Grade
    words: str
    remarks: tuple[str, ...] = ()


def of_error(error: InputError) -> Verdict:
    """The verdict on what could not be calculated."""
    where = f"{error.where}: " if error.where else ""
    films = "film" in error.remedy.lower()
    begin = "Film again" if films else "Cannot be calibrated"
    return Verdict("bad", f"{begin}: {where}{error.what}.", (error.remedy,))


def of_alignment(found: Alignment, cameras: Mapping[str, Camera]) -> Verdict:
    """Whether a world can be turned so; `cameras` as they stand in the new one."""
    many = (
        f"up is tilted by {found.tilt_deg:.1f} degrees, north turned by "
        f"{abs(found.heading_deg):.1f} degrees, and the origin moved by {found.moved_m:.2f} m"
    )
    remarks = []
    low = min(cameras.values(), key=lambda one: one.position_world[2])
    height = float(low.position_world[2])
    if height < 0.0 and found.source != "cameras":
        remarks.append(
            f"{low.name} stands {-height:.2f} m below the floor: what shows the floor is wrong."
        )
    if found.source in ("floor", "cameras") and found.spread_m > _UNEVEN_M:
        remarks.append(
            f"What it rests on is off by {1000 * found.spread_m:.0f} mm in the mean. Another frame "
            "may show it better."
        )
    if remarks:
        return Verdict("doubtful", f"Usable, with doubts: {many}.", tuple(remarks))
    exact = _EXACT.get(found.source)
    return Verdict("good", f"Good: {many}.", (exact,) if exact else ())


_EXACT = {
    "person": "Up is as exact as the person is upright, and the floor's height to about 5 cm.",
    "points": "Three points leave no check. Compare the heights of the cameras with a tape "
    "measure.",
}
"""How exact what an alignment rests on is."""


def of_no_alignment(error: InputError) -> Verdict:
    """Why a world cannot be turned yet."""
    return Verdict("doubtful", f"Not turned yet: {error.what}.", (error.remedy,))


def of_search(search: Search, apart: InputError | None) -> Verdict:
    """Whether the board was found often enough."""
    found = {one.camera: len(one) for one in search.sightings}
    searched = {one.camera: one.searched for one in search.sightings}
    remarks = [_sentence(one) for one in search.findings]
    if search.mirrored:
        remarks.append(
            f"The pictures of {_listed(search.mirrored)} are mirrored. They have no place in a "
            "world: switch off mirroring in the recording software and film again."
        )
    if apart is not None:
        remarks.append(f"{_upper(apart.what)}. {apart.remedy}")
    rare = [name for name, count in found.items() if count < _FEW_FOUND * searched[name]]
    if rare:
        remarks.append(
            f"The board was found in few pictures of {_listed(rare)}. Check its size, the light "
            "and the sharpness, and that the whole board is seen."
        )
    all_found, all_searched = sum(found.values()), sum(searched.values())
    many = f"the board was found in {all_found} of {counted(all_searched, 'picture')}"
    if not all_found:
        return Verdict("bad", f"Film again, or name another board: {many}.", tuple(remarks))
    if remarks:
        return Verdict("doubtful", f"Usable, with doubts: {many}.", tuple(remarks))
    return Verdict("good", f"Good: {many}.")


def of_lenses(lenses: Mapping[str, Intrinsics | InputError]) -> Verdict:
    """Whether the lenses are known."""
    fits = [one for one in lenses.values() if isinstance(one, Intrinsics)]
    errors = [one for one in lenses.values() if isinstance(one, InputError)]
    if errors:
        names = [name for name, one in lenses.items() if isinstance(one, InputError)]
        remarks = [f"{_upper(one.where)}: {one.what}. {one.remedy}" for one in errors]
        return Verdict("bad", f"Film again with {_listed(names)}.", tuple(remarks))
    worst = max(fits, key=lambda one: np.nan_to_num(one.held_out_px, nan=one.rms_px))
    error = worst.held_out_px if np.isfinite(worst.held_out_px) else worst.rms_px
    count = len(fits)
    lens = {1: "the lens fits", 2: "both lenses fit"}.get(count, f"all {count} lenses fit")
    many = f"{lens} the board to {error:.2f} px or better in pictures that were left out"
    return _graded(many, error, [f for one in fits for f in one.findings])


def of_world(world: World) -> Verdict:
    """Whether all cameras agree on where the boards were."""
    error = world.held_out_px if np.isfinite(world.held_out_px) else world.rms_px
    many = (
        f"{counted(len(world.cameras), 'camera')} agree on "
        f"{counted(len(world.boards), 'board')} to {error:.2f} px"
    )
    places = max(world.position_sigma_m)
    many += f", and each is placed to {1000 * places:.1f} mm or better"
    return _graded(many, error, world.findings)


def _graded(many: str, error: float, findings: Iterable[Finding]) -> Verdict:
    remarks = list(dict.fromkeys(_sentence(one) for one in findings if one.severity != "note"))
    if error > _POOR_PX:
        remarks.insert(
            0, "The error is large. Check that the board is flat and the pictures are sharp, and "
            "untick the worst pictures.",
        )  # fmt: skip
        return Verdict("bad", f"Film again: {many}.", tuple(remarks))
    if remarks or error > _GOOD_PX:
        return Verdict("doubtful", f"Usable, with doubts: {many}.", tuple(remarks))
    return Verdict("good", f"Good: {many}.")


def _sentence(finding: Finding) -> str:
    where = f"{_upper(finding.where)}: " if finding.where else ""
    return f"{where}{finding.what}. {finding.remedy}".strip()


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)
