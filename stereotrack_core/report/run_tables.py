"""The tables of a report on a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import CAUSE_WORDS, limbs_words
from stereotrack_core.evaluation.summary import CALLED, root_mean
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.report.pages import Row, Table, number
from stereotrack_core.report.reported import Reported
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import changed_parameters


def tables(reported: Reported) -> dict[str, Table | None]:
    """All of them by their name in the template; None for those that there is nothing to tell."""
    run = reported.source.run
    stored: dict[str, Any] = dict(run.meta.get("parameters") or {})
    return {
        "lengths": _lengths(run),
        "cameras": _cameras(reported.source.recording),
        "errors": _errors(reported),
        "segments": _segments(reported),
        "episodes": _episodes(reported),
        "honesty": _honesty(run),
        "motion": _motion(reported),
        "sides": _sides(reported),
        "reference_sigma": _reference_sigma(reported),
        "parameters": _parameters(stored),
        "changed": _changed(stored, str(run.meta.get("preset") or "")),
        "versions": _versions(reported),
    }


def _lengths(run: Run) -> Table:
    """The person's measured lengths."""
    stated = run.meta.get("subject") or {}
    known = {key.replace("_", " "): value for key, value in stated.items() if key != "name"}
    values = ["average" if value is None else f"{1000.0 * value:.0f}" for value in known.values()]
    columns = ("", *(f">{key.removesuffix(' length')}" for key in known))
    return Table(columns, [("length [mm]", *values)])


def _cameras(recording: Recording | None) -> Table:
    columns = (
        *("view", "kind", ">image [px]", ">focal length [px]", ">field of view [deg]"),
        *(">baseline [mm]", ">height [m]", ">distance [m]"),
    )
    views = () if recording is None else recording.views
    return Table(columns, [_camera(recording, view) for view in views if recording is not None])


def _camera(recording: Recording, view: View) -> tuple[str, ...]:
    camera = recording.reference_camera(view)
    focal = float(camera.matrix[0, 0])
    field = 2.0 * np.degrees(np.arctan(camera.width / (2.0 * focal)))
    base = float("nan")
    if view.left is not None:
        left = recording.cameras[view.left.camera]
        base = 1000.0 * float(np.linalg.norm(left.position_world - camera.position_world))
    places = [recording.reference_camera(one).position_world for one in recording.views]
    away = float(np.linalg.norm((camera.position_world - np.mean(places, axis=0))[:2]))
    return (
        view.name,
        view.kind,
        f"{camera.width} × {camera.height}",
        number(focal, 0),
        number(float(field), 0),
        number(base, 0),
        number(float(camera.position_world[2]), 2),
        number(away, 2),
    )


def _errors(reported: Reported) -> Table | None:
    """Errors, with how good the reference is."""
    accuracy = reported.accuracy
    if accuracy is None:
        return None
    good = bool(accuracy.quality)
    rows = []
    for measure in accuracy.summary.measures:
        figures = measure.statistics
        row = [f"{measure.label} [{measure.unit}]"]
        row += [number(value) for value in (figures.mean, figures.median, figures.p95)]
        row += [number(accuracy.quality.get(measure.name, float("nan")))] if good else []
        rows.append(row)
    lost = ["arm segments lost [%]", number(100.0 * accuracy.summary.lost), "", ""]
    rows.append([*lost, *([""] if good else [])])
    columns = ["", ">mean", ">median", ">95 %", *([">reference uncertainty"] if good else [])]
    return Table(columns, rows)


def _segments(reported: Reported) -> Table | None:
    if reported.accuracy is None:
        return None
    columns = (
        *("segment", ">frames", ">torso [mm]", ">long axis", ">cross axis", ">upper arms"),
        *(">forearms", ">lost [%]"),
    )
    rows = [
        (
            one.name,
            str(one.frames),
            *(number(measure.statistics.mean) for measure in one.measures[:5]),
            number(100.0 * one.lost),
        )
        for one in reported.accuracy.segments
    ]
    return Table(columns, rows)


def _episodes(reported: Reported) -> Table:
    """Stretches in which limbs fail."""
    fps = reported.source.fps
    rows = []
    for shown in reported.episodes:
        episode = shown.episode
        sure = episode.verdict.confidence
        rows.append(
            (
                f"{episode.first}–{episode.last}",
                f"{episode.first / fps:.1f}–{(episode.last + 1) / fps:.1f} s",
                limbs_words(episode.limbs),
                episode.peak_words,
                CAUSE_WORDS[episode.verdict.cause] + (f" ({100.0 * sure:.0f} %)" if sure else ""),
            )
        )
    return Table(("frames", "time", "limbs", ">peak", "probable cause"), rows)


def _honesty(run: Run) -> Table | None:
    """What the run says itself about lost limbs; None where it says nothing."""
    known = np.isfinite(run.limb_lost)
    rows = []
    for i, limb in enumerate(LIMBS):
        if known[:, i].any():
            share = 100.0 * float((run.limb_lost[known[:, i], i] > CALLED).mean())
            sigma = root_mean(np.square(run.limb_sigma_deg[run.tracked, i]))
            rows.append((limb.replace("_", " "), number(share), number(sigma)))
    columns = ("limb", ">flagged [% of frames]", ">predicted error [deg]")
    return Table(columns, rows) if rows else None


def _motion(reported: Reported) -> Table:
    """Range of motion of the joints."""
    names = ("minimum", "maximum", "range", "range_sigma", "mean", "peak_velocity")
    rows = []
    for one in reported.motions[0].ranges:
        degrees = one.degrees()
        if one.frames:
            rows.append((one.angle.words, *(number(degrees[name]) for name in names)))
    return Table(("angle", ">from", ">to", ">range", ">±", ">mean", ">peak speed [deg/s]"), rows)


def _sides(reported: Reported) -> Table:
    """Range of motion, left against right."""
    rows = [
        (
            "all frames" if stretch.name == "all" else stretch.name,
            side.left.angle.label,
            *map(number, side.degrees().values()),
        )
        for stretch in reported.motions
        for side in stretch.sides
        if side.left.frames and side.right.frames
    ]
    return Table(("stretch", "range of", ">left", ">right", ">left − right", ">±"), rows)


def _reference_sigma(reported: Reported) -> Table | None:
    """How good the reference says that it is; None where it does not."""
    states = reported.source.states
    if states is None or states.limb_sigma_deg is None:
        return None
    sigma = states.limb_sigma_deg[np.isin(states.frame, reported.source.run.frame)]
    rows = [
        (
            limb.replace("_", " "),
            number(root_mean(np.square(sigma[:, i]))),
            number(float(np.fmax.reduce(sigma[:, i], initial=np.nan))),
        )
        for i, limb in enumerate(LIMBS)
    ]
    return Table(("limb", ">uncertainty [deg]", ">worst frame [deg]"), rows)


def _parameters(stored: dict[str, Any]) -> Table:
    """All parameters; those that are not the default are set apart."""
    known = {row.name: row for row in Settings.rows()}
    rows = []
    for key, value in stored.items():
        row = known.get(key)
        default = "–" if row is None else str(row.default)
        kind = "" if row is None or value == row.default else "given"
        rows.append(Row((key, str(value), "" if row is None else row.unit, default), kind))
    return Table(("parameter", ">value", "unit", ">default"), rows)


def _changed(stored: dict[str, Any], preset: str) -> Table:
    """What differs from the preset."""
    units = {row.name: row.unit for row in Settings.rows()}
    rows = [
        (key, str(value), units.get(key, ""), str(usual))
        for key, (usual, value) in changed_parameters(stored, preset).items()
    ]
    return Table(("parameter", ">value", "unit", ">preset"), rows)


def _versions(reported: Reported) -> Table:
    meta = reported.source.run.meta
    rows = [(key, str(value)) for key, value in dict(meta.get("versions") or {}).items()]
    rows = rows or [("stereotrack", str(meta.get("version") or "unknown"))]
    rows += [
        ("tracked", str(meta.get("made") or "unknown time")),
        ("seed", str(meta.get("seed", "unknown"))),
        ("initial pose", str(meta.get("init", "unknown"))),
        ("recording's fingerprint", str(meta.get("fingerprint") or "unknown")),
    ]
    rows += [("note", reported.source.note)] if reported.source.note else []
    return Table(("", ""), rows)
