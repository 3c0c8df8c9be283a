"""What a calibration is worth, as plain facts and as tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.pictures import LeftOut, Sightings
from stereotrack_core.calibrate.world import World
from stereotrack_core.calibrate.world_checks import distances
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.tables import Table, number

_LISTED = 12
"""Pictures left out that a table lists one by one."""


def lens_facts(one: Intrinsics) -> dict[str, Any]:
    """What is known about a lens, with its error in every picture."""
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
    """What is known about cameras in one world."""
    cameras = []
    for i, camera in enumerate(world.cameras):
        lens = world.lenses[i]
        own = picture_facts(world.sightings[i], [rms_of(error) for error in world.errors[i]])
        cameras.append(
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
                **own,
            }
        )
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
    whole = [
        ("rms of all corners", f"{world.rms_px:.3f} px"),
        ("held out", f"{number(world.held_out_px, 3)} px"),
        ("boards", str(len(world.boards))),
        (
            "squares measured / given",
            f"{number(100 * world.scale.ratio, 2)} %, spread "
            f"{number(1000 * world.scale.spread_m, 2)} mm",
        ),
    ]
    whole += [
        (f"from {a} to {b}", f"{1000 * length:.0f} mm")
        for a, b, length in distances(world.cameras)[:_LISTED]
    ]
    return [
        *([lens_table(lenses)] if lenses else []),
        Table("Cameras", headings, rows),
        Table("All together", ("what", ">value"), whole),
    ]


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
    rows = [
        (one.camera, one.picture, one.reason)
        for one in everything
        if (one.camera, one.reason) not in grouped
    ]
    if len(rows) > _LISTED:
        rows = [*rows[:_LISTED], ("", f"{len(rows) - _LISTED} more", "see --json")]
    rows += [(camera, f"{common[camera, why]} pictures", why) for camera, why in grouped]
    return Table("Pictures left out", ("camera", "picture", "reason"), rows) if rows else None


def finding_table(findings: Sequence[Finding]) -> Table | None:
    """What looks wrong, and what to do."""
    rows = [(one.severity, one.where, one.what, one.remedy) for one in findings]
    heads = ("severity", "where", "what", "remedy")
    return Table("Remarks", heads, rows) if rows else None


def place_table(before: Mapping[str, Camera], after: Mapping[str, Camera]) -> Table:
    """Where cameras stand in the world before it was turned, and in the new one."""
    rows = [
        (name, *(text for world in (before, after) for text in _place(world[name])))
        for name in after
        if name in before
    ]
    headings = (
        "camera", ">place before (m)", ">looks down (°)", ">place after (m)", ">looks down (°)",
    )  # fmt: skip
    return Table("The world before and after", headings, rows)


def _place(camera: Camera) -> tuple[str, str]:
    down = float(np.degrees(np.arcsin(np.clip(-camera.camera_from_world.rotation[2, 2], -1, 1))))
    place = np.round(camera.position_world, 2) + 0.0  # no minus before a zero
    return "  ".join(f"{value:.2f}" for value in place), f"{np.round(down, 1) + 0.0:.1f}"
