"""Sections of a report about how its numbers came about: recording, calibration, parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stereotrack_core.recording.consistency import FILES
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.finding import Finding
from stereotrack_core.report.html import (
    Html,
    bullets,
    element,
    fold,
    heading,
    paragraph,
)
from stereotrack_core.report.reported import Reported
from stereotrack_core.report.tables import Row, number, table
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import PRESETS
from stereotrack_core.tracking.repeating import changed_parameters

_OF_CAMERAS = ("calibration", "camera", "view")


def recording(reported: Reported) -> list[Html]:
    """What was recorded, and what is worth telling about it."""
    source = reported.source
    parts = [heading(2, "Recording", "recording")]
    own = source.recording
    if own is None:
        return [*parts, paragraph("The recording is not there any more; pictures are left out.")]
    used = [str(name) for name in source.run.meta.get("views", [])]
    said = f"{own.name}, {own.fps:g} frame sets per second, {len(own.views)} views"
    said += f" of which {', '.join(used)} were used." if used else "."
    parts.append(paragraph(said))
    others = [f for f in reported.findings if not _about_cameras(f)]
    if others:
        parts.append(bullets(_finding(one) for one in others))
    return parts


def calibration(reported: Reported) -> list[Html]:
    """A verdict on the cameras in words, then what speaks for it, then the numbers."""
    own = reported.source.recording
    if own is None:
        return []
    findings = [finding for finding in reported.findings if _about_cameras(finding)]
    parts = [
        heading(2, "Calibration", "calibration"),
        paragraph(_verdict(own, findings)),
    ]
    parts.append(paragraph(_compared(own)))
    if findings:
        parts.append(bullets(_finding(one) for one in findings))
    rows = [_camera_row(own, view) for view in own.views]
    headings = (
        *("view", "kind", ">image [px]", ">focal length [px]", ">field of view [deg]"),
        *(">base line [mm]", ">height [m]", ">distance [m]"),
    )
    return [
        *parts,
        table(headings, rows),
        paragraph(
            "Base line: between the two lenses of a stereo camera. Height above the floor; "
            "distance from the middle of all views.",
            kind="soft",
        ),
    ]


def parameters(reported: Reported) -> list[Html]:
    """What differs from the preset first, everything else in a fold."""
    meta = reported.source.run.meta
    stored: dict[str, Any] = dict(meta.get("parameters") or {})
    parts = [heading(2, "Parameters", "parameters", "new-page")]
    if not stored:
        return [*parts, paragraph("The run does not state its parameters.")]
    name = str(meta.get("preset") or "")
    changed = changed_parameters(stored, name)
    rows = {row.name: row for row in Settings.rows()}
    if changed:
        parts.append(paragraph(f"Different from preset {name}:"))
        lines = [
            (key, str(value), _unit(rows, key), str(usual))
            for key, (usual, value) in changed.items()
        ]
        parts.append(table(("parameter", ">value", "unit", ">preset"), lines))
    elif name in PRESETS:
        parts.append(paragraph(f"All as in preset {name}."))
    else:
        said = f"preset {name}, which is not one of this program's" if name else "no preset"
        parts.append(paragraph(f"Made from {said}; coloured below is what is not the default."))
    every = []
    for key, value in stored.items():
        row = rows.get(key)
        default = "–" if row is None else str(row.default)
        kind = "" if row is None or value == row.default else "given"
        every.append(Row((key, str(value), _unit(rows, key), default), kind))
    shown = table(("parameter", ">value", "unit", ">default"), every)
    parts.append(fold(f"All {len(stored)} parameters (coloured: not the default)", shown))
    return parts


def made(reported: Reported) -> list[Html]:
    """Versions, and how to do it again."""
    source, meta = reported.source, reported.source.run.meta
    rows: list[tuple[str, str]] = [
        (key, str(value)) for key, value in dict(meta.get("versions") or {}).items()
    ]
    if not rows:
        rows = [("stereotrack", str(meta.get("version") or "unknown"))]
    rows += [
        ("tracked", str(meta.get("made") or "not known when")),
        ("seed", str(meta.get("seed", "unknown"))),
        ("first pose", str(meta.get("init", "unknown"))),
        ("recording's fingerprint", str(meta.get("fingerprint") or "unknown")),
    ]
    if source.note:
        rows.append(("note", source.note))
    parts = [
        heading(2, "Versions, and how to do it again", "again"),
        table(("", ""), rows),
    ]
    if source.repeat:
        parts += [paragraph("Track again, exactly as this run was:"), element("pre", source.repeat)]
    if source.command:
        parts += [paragraph("Make this report again:"), element("pre", source.command)]
    if reported.differs:
        parts += [
            paragraph("Why it may come out otherwise here and now:"),
            bullets(reported.differs),
        ]
    return parts


def _unit(rows: dict[str, Any], key: str) -> str:
    return str(rows[key].unit) if key in rows else ""


def _about_cameras(finding: Finding) -> bool:
    where = finding.where.lower()
    return any(word in where for word in _OF_CAMERAS) and "segments" not in where


def _finding(finding: Finding) -> str:
    what = f"{finding.what[:1].upper()}{finding.what[1:]}"
    return f"{finding.severity.capitalize()}, {finding.where}: {what}. {finding.remedy}"


def _verdict(recording: Recording, findings: Sequence[Finding]) -> str:
    grave = [finding for finding in findings if finding.severity != "note"]
    cameras = len(recording.cameras)
    if not grave:
        return (
            f"Usable: nothing contradicts in what is known of its {cameras} cameras. Lenses, pairs "
            "of stereo cameras, directions of view and the size of the rig are plausible."
        )
    errors = sum(finding.severity == "error" for finding in grave)
    word = "Wrong" if errors else "Doubtful"
    return f"{word}: {len(grave)} of the checks of its {cameras} cameras complain."


def _compared(recording: Recording) -> str:
    """Whether pixels that several views have seen were there to compare the cameras by."""
    found = [name for name, _ in FILES if (recording.folder / name).is_file()]
    if found:
        return f"The views were compared with each other by {' and '.join(found)}."
    return (
        "No clicks or board corners lie beside the recording, so how well the views agree to a "
        "pixel is not known."
    )


def _camera_row(recording: Recording, view: View) -> tuple[str, ...]:
    camera = recording.reference_camera(view)
    focal = float(camera.matrix[0, 0])
    field = 2.0 * np.degrees(np.arctan(camera.width / (2.0 * focal)))
    base = "–"
    if view.left is not None:
        left = recording.cameras[view.left.camera]
        base = number(
            1000.0 * float(np.linalg.norm(left.position_world - camera.position_world)), 0
        )
    places = [recording.reference_camera(one).position_world for one in recording.views]
    away = float(np.linalg.norm((camera.position_world - np.mean(places, axis=0))[:2]))
    return (
        view.name,
        view.kind,
        f"{camera.width} × {camera.height}",
        number(focal, 0),
        number(float(field), 0),
        base,
        number(float(camera.position_world[2]), 2),
        number(away, 2),
    )
