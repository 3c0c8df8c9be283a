"""The quality of a calibration: facts, tables, and a verdict in a sentence with its remedy."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.pictures import LeftOut, Sightings
from stereotrack_core.calibrate.work import Search
from stereotrack_core.calibrate.world import World
from stereotrack_core.calibrate.world_checks import distances
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Cameras
from stereotrack_core.tables import Table, number

_LISTED = 12  # pictures left out that a table lists one by one


def lens_facts(one: Intrinsics) -> dict[str, Any]:
    """Facts about a lens, with its error in every picture."""
    return {
        "camera": one.camera.name,
        "size": one.sightings.size,
        "model": one.lens.model.name,
        "rms_px": one.rms_px,
        "held_out_px": one.held_out_px,
        "focal_px": one.lens.values[:2],
        "focal_sigma_px": one.sigma[:2],
        "principal_point_px": one.lens.values[2:4],
        "principal_point_sigma_px": one.sigma[2:],
        "distortions": one.camera.distortions,
        "coverage": one.coverage.share,
        "covered_cells": one.coverage.cells.astype(int),
        "tilt_deg": one.coverage.tilt_deg,
        "distance_m": [one.coverage.nearest_m, one.coverage.farthest_m],
        "candidates": [
            {
                "model": candidate.model.name,
                "coefficients": len(candidate.model.estimated),
                "rms_px": candidate.rms_px,
                "held_out_px": candidate.held_out_px,
            }
            for candidate in one.candidates
        ],
        **picture_facts(one.sightings, [rms_of(error) for error in one.errors]),
    }


def picture_facts(sightings: Sightings, rms: Sequence[float]) -> dict[str, Any]:
    """Errors of the pictures that were used, and the others with the reason."""
    return {
        "pictures": [
            {"frame": int(frame), "picture": name, "rms_px": error}
            for frame, name, error in zip(sightings.frames, sightings.pictures, rms, strict=True)
        ],
        "left_out": [
            {"frame": out.frame, "picture": out.picture, "reason": out.reason}
            for out in sightings.left_out
        ],
    }


def world_facts(world: World) -> dict[str, Any]:
    """Facts about cameras in one world."""
    cameras = [
        {
            "camera": camera.name,
            "rms_px": world.rms_by_camera[i],
            "held_out_px": world.held_out_by_camera[i],
            "position_m": camera.position_world,
            "position_sigma_m": world.position_sigma_m[i],
            "rotation_sigma_deg": np.degrees(world.rotation_sigma_rad[i]),
            "frames_shared": {
                other.name: int(count)
                for other, count in zip(world.cameras, world.shared[i], strict=True)
                if other is not camera
            },
            "focal_px": camera.matrix[[0, 1], [0, 1]],
            "distortions": camera.distortions,
            "lens": None if lens is None else lens_facts(lens),
            **picture_facts(world.sightings[i], [rms_of(error) for error in world.errors[i]]),
        }
        for i, (camera, lens) in enumerate(zip(world.cameras, world.lenses, strict=True))
    ]
    return {
        "board": world.board,
        "rms_px": world.rms_px,
        "held_out_px": world.held_out_px,
        "boards": len(world.boards),
        "scale": world.scale,
        "cameras": cameras,
        "distances_m": [
            {"from": a, "to": b, "distance": length} for a, b, length in distances(world.cameras)
        ],
    }


def world_tables(world: World) -> list[Table]:
    """Lenses, places and the whole."""
    lenses = [one for one in world.lenses if one is not None]
    rows = [
        (
            camera.name,
            str(len(world.sightings[i])),
            str(int(world.shared[i].max(initial=0))),
            number(world.rms_by_camera[i], 3),
            number(world.held_out_by_camera[i], 3),
            " ".join(f"{value:.3f}" for value in np.round(camera.position_world, 3) + 0.0),
            f"{1000 * world.position_sigma_m[i]:.1f}",
            f"{np.degrees(world.rotation_sigma_rad[i]):.3f}",
        )
        for i, camera in enumerate(world.cameras)
    ]
    headings = (
        "camera", ">pictures", ">shared", ">rms (px)", ">held out (px)", ">place (m)", ">± (mm)",
        ">± (°)",
    )  # fmt: skip
    ratio, spread = number(100 * world.scale.ratio, 2), number(1000 * world.scale.spread_m, 2)
    whole = [
        ("rms of all corners", f"{world.rms_px:.3f} px"),
        ("held out", f"{number(world.held_out_px, 3)} px"),
        ("boards", str(len(world.boards))),
        ("squares measured / given", f"{ratio} %, spread {spread} mm"),
    ]
    listed = distances(world.cameras)[:_LISTED]
    whole += [(f"from {a} to {b}", f"{1000 * length:.0f} mm") for a, b, length in listed]
    of_lenses = [lens_table(lenses)] if lenses else []
    together = Table("All together", ("what", ">value"), whole)
    return [*of_lenses, Table("Cameras", headings, rows), together]


def lens_table(lenses: Sequence[Intrinsics]) -> Table:
    """One row per camera."""
    rows = [
        (
            one.camera.name,
            one.lens.model.name,
            f"{len(one.sightings)} of {max(one.sightings.searched, len(one.sightings))}",
            number(one.rms_px, 3),
            number(one.held_out_px, 3),
            f"{one.lens.focal:.1f} ± {max(one.sigma[:2]):.1f}",
            f"{one.lens.values[2]:.1f}, {one.lens.values[3]:.1f}",
            f"{100 * one.coverage.share:.0f} %",
            f"{one.coverage.tilt_deg:.0f}°",
        )
        for one in lenses
    ]
    headings = (
        "camera", "model", ">pictures", ">rms (px)", ">held out (px)", ">focal (px)",
        ">principal point", ">covered", ">tilt",
    )  # fmt: skip
    return Table("Lenses", headings, rows)


def candidate_table(one: Intrinsics) -> Table:
    """The lens models that were tried."""
    rows = [
        (
            candidate.model.name,
            str(len(candidate.model.estimated)),
            number(candidate.rms_px, 3),
            number(candidate.held_out_px, 3),
            "taken" if candidate.model is one.lens.model else "",
        )
        for candidate in one.candidates
    ]
    headings = ("model", ">coefficients", ">rms (px)", ">held out (px)", "")
    return Table(f"Lens models for {one.camera.name}", headings, rows)


def left_out_table(left_out: Iterable[LeftOut]) -> Table | None:
    """Pictures left out although they show the board, and how many for the commonest reasons."""
    everything = list(left_out)
    common = Counter((one.camera, one.reason) for one in everything)
    grouped = [key for key, count in common.items() if count > 2]
    single = [one for one in everything if (one.camera, one.reason) not in grouped]
    rows = [(one.camera, one.picture, one.reason) for one in single]
    if len(rows) > _LISTED:
        rows = [*rows[:_LISTED], ("", f"{len(rows) - _LISTED} more", "see --json")]
    rows += [(camera, f"{common[camera, why]} pictures", why) for camera, why in grouped]
    return Table("Pictures left out", ("camera", "picture", "reason"), rows) if rows else None


def finding_table(findings: Sequence[Finding]) -> Table | None:
    """Findings with remedies."""
    rows = [(one.severity, one.where, one.what, one.remedy) for one in findings]
    heads = ("severity", "where", "what", "remedy")
    return Table("Remarks", heads, rows) if rows else None


def place_table(before: Cameras, after: Cameras) -> Table:
    """Where cameras stand in the world before it was turned, and in the new one."""
    both = {name: (before[name], after[name]) for name in after if name in before}
    rows = [(name, *_place(one), *_place(two)) for name, (one, two) in both.items()]
    headings = (
        "camera", ">place before (m)", ">looks down (°)", ">place after (m)", ">looks down (°)",
    )  # fmt: skip
    return Table("The world before and after", headings, rows)


def _place(camera: Camera) -> tuple[str, str]:
    down = float(np.degrees(np.arcsin(np.clip(-camera.camera_from_world.rotation[2, 2], -1, 1))))
    place = np.round(camera.position_world, 2) + 0.0  # no minus before a zero
    return "  ".join(f"{value:.2f}" for value in place), f"{np.round(down, 1) + 0.0:.1f}"


Grade: TypeAlias = Literal["good", "doubtful", "bad"]

_GOOD_PX, _POOR_PX = 0.4, 1.0  # held-out error of sharp pictures; of pictures that are not
_UNEVEN_M = 0.015  # standard deviation of what an alignment rests on
_BELOW_M = 0.1  # depth below the floor from which a board cannot have been above it
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


def of_alignment(
    found: Alignment, cameras: Cameras, boards: Sequence[RigidTransform] = ()
) -> Verdict:
    """Whether a world can be turned so; `cameras` and `boards` as they stand in the new one."""
    many = (
        f"up is tilted by {found.tilt_deg:.1f} degrees, north turned by "
        f"{abs(found.heading_deg):.1f} degrees, and the origin moved by {found.moved_m:.2f} m"
    )
    remarks = []
    low = min(cameras.values(), key=lambda one: one.position_world[2])
    height = float(low.position_world[2])
    if height < 0.0 and found.source != "cameras":
        what = f"{low.name} stands {-height:.2f} m below the floor"
        remarks.append(f"{what}: what shows the floor is wrong.")
    below = sum(board.translation[2] < -_BELOW_M for board in boards)
    if below:
        what = f"{counted(below, 'position')} of the board lie below this floor"
        remarks.append(f"{what}. Choose the one in which the board lies on the floor.")
    if found.source in ("floor", "cameras") and found.spread_m > _UNEVEN_M:
        off = f"What it rests on is off by {1000 * found.spread_m:.0f} mm in the mean"
        other = " Another frame may show it better." if found.source == "floor" else ""
        remarks.append(f"{off}.{other}")
    return _doubted(many, remarks)


def _doubted(many: str, remarks: Sequence[str], poor: bool = False) -> Verdict:
    """Usable with doubts where there are remarks or it is poor, else good."""
    if remarks or poor:
        return Verdict("doubtful", f"Usable, with doubts: {many}.", tuple(remarks))
    return Verdict("good", f"Good: {many}.")


def of_no_alignment(error: InputError) -> Verdict:
    """Why a world cannot be turned yet."""
    return Verdict("doubtful", f"Not turned yet: {error.what}.", (error.remedy,))


def of_search(search: Search) -> Verdict:
    """Whether the board was found often enough."""
    found = {one.camera: len(one) for one in search.sightings}
    searched = {one.camera: one.searched for one in search.sightings}
    remarks = [_sentence(one) for one in search.findings]
    if search.mirrored:
        remarks.append(
            f"The pictures of {', '.join(search.mirrored)} are mirrored. They have no place in a "
            "world: switch off mirroring in the recording software and film again."
        )
    if (apart := search.apart) is not None:
        remarks.append(f"{_upper(apart.what)}. {apart.remedy}")
    rare = [name for name, count in found.items() if count < _FEW_FOUND * searched[name]]
    if rare:
        remarks.append(
            f"The board was found in few pictures of {', '.join(rare)}. Check its size, the light "
            "and the sharpness, and that the whole board is seen."
        )
    all_found, all_searched = sum(found.values()), sum(searched.values())
    many = f"the board was found in {all_found} of {counted(all_searched, 'picture')}"
    if not all_found:
        return Verdict("bad", f"Film again, or name another board: {many}.", tuple(remarks))
    return _doubted(many, remarks)


def of_lenses(lenses: Mapping[str, Intrinsics | InputError]) -> Verdict:
    """Whether the lenses are known."""
    fits = [one for one in lenses.values() if isinstance(one, Intrinsics)]
    errors = [one for one in lenses.values() if isinstance(one, InputError)]
    if errors:
        names = [name for name, one in lenses.items() if isinstance(one, InputError)]
        remarks = [f"{_upper(one.where)}: {one.what}. {one.remedy}" for one in errors]
        return Verdict("bad", f"Film again with {', '.join(names)}.", tuple(remarks))
    worst = max(fits, key=lambda one: np.nan_to_num(one.held_out_px, nan=one.rms_px))
    error = worst.held_out_px if np.isfinite(worst.held_out_px) else worst.rms_px
    count = len(fits)
    lens = {1: "the lens fits", 2: "both lenses fit"}.get(count, f"all {count} lenses fit")
    many = f"{lens} the board to {error:.2f} px or better in pictures that were left out"
    return _graded(many, error, [f for one in fits for f in one.findings])


def of_world(world: World) -> Verdict:
    """Whether all cameras agree on where the boards were."""
    error = world.held_out_px if np.isfinite(world.held_out_px) else world.rms_px
    seen = Counter(int(frame) for one in world.sightings for frame in one.frames)
    cameras = counted(len(world.cameras), "camera")
    boards = counted(sum(count > 1 for count in seen.values()), "board")
    placed = f"each is placed to {1000 * max(world.position_sigma_m):.1f} mm or better"
    many = f"{cameras} agree on {boards} to {error:.2f} px, and {placed}"
    return _graded(many, error, world.findings)


def _graded(many: str, error: float, findings: Iterable[Finding]) -> Verdict:
    remarks = list(dict.fromkeys(_sentence(one) for one in findings if one.severity != "note"))
    if error > _POOR_PX:
        remarks.insert(
            0, "The error is large. Check that the board is flat and the pictures are sharp, and "
            "untick the worst pictures.",
        )  # fmt: skip
        return Verdict("bad", f"Film again: {many}.", tuple(remarks))
    return _doubted(many, remarks, error > _GOOD_PX)


def _sentence(finding: Finding) -> str:
    where = f"{_upper(finding.where)}: " if finding.where else ""
    return f"{where}{finding.what}. {finding.remedy}".strip()


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
