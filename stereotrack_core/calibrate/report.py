"""What a calibration is worth, as plain facts and as tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.sightings import LeftOut, Sightings
from stereotrack_core.errors import Finding
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


def finite_mean(values: Sequence[float]) -> float:
    """Mean of what is known; NaN of nothing."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else float("nan")
