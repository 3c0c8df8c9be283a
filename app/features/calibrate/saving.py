"""Writes a calibration with its report: to a file, or into the open recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stereotrack_core.calibrate.changes import change_table, place_table
from stereotrack_core.calibrate.report import left_out_table, lens_table, world_tables
from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.folder import named_file
from stereotrack_core.recording.writing import keep_beside
from stereotrack_core.report.pages import write_calibration_page
from stereotrack_core.tables import Table

from .state import Calibration, Recorded, StepName


def write_to(state: Calibration, path: Path) -> Path:
    """Write the cameras to a file and the report beside it; where the report is.

    Raises InputError where one of them cannot be written.
    """
    path = path if path.suffix else path.with_suffix(".toml")
    _check(state)
    write_calibration(path, state.cameras)
    report = path.with_name(f"{path.stem}-report.html")
    step: StepName = "save" if state.of_recording else "lenses"
    verdict = state.verdict("world" if state.world is not None else step)
    assert verdict is not None  # noqa: S101 - there are cameras
    write_calibration_page(report, path.stem, verdict, report_tables(state))
    return report


def report_tables(state: Calibration) -> Sequence[Table]:
    """Everything that is known about the result."""
    turned = place_table(state.base, state.cameras) if state.alignment is not None else None
    if state.of_recording:
        tables: list[Table | None] = [turned]
    elif state.world is None:
        fits = list(state.fits.values())
        left_out = left_out_table([out for one in fits for out in one.sightings.left_out])
        tables = [lens_table(fits), left_out]
    else:
        world = state.world.result
        changed = change_table(state.changes) if state.changes else None
        left_out = left_out_table([out for one in world.sightings for out in one.left_out])
        tables = [*world_tables(world), turned, changed, left_out]
    return [one for one in tables if one is not None]


def why_not_into(state: Calibration) -> str:
    """Why the calibration cannot replace that of the open recording."""
    if state.recording is None:
        return "No recording is open."
    if state.recording.guessed:
        return "The cameras of the recording are guessed, so that there is nothing to replace."
    if state.world is None and not (state.of_recording and state.cameras):
        return "Place all cameras first, or choose what the world is turned by."
    missing = [name for name in state.recording.cameras if name not in state.cameras]
    if missing:
        return (
            f"The calibration lacks {', '.join(missing[:4])}. Name the cameras as the recording "
            "does: double-click a name in step 1."
        )
    for name, old in state.recording.cameras.items():
        new = state.cameras[name]
        if (new.width, new.height) != (old.width, old.height):
            return (
                f"{name} was calibrated with pictures of {new.width} × {new.height}, the recording "
                f"has {old.width} × {old.height}."
            )
    return ""


def save_into(state: Calibration, recording: Recorded) -> Path:
    """Replace the recording's calibration; the one before is kept beside it, and returned.

    Raises InputError where it cannot be written.
    """
    _check(state)
    target = named_file(recording.folder, "calibration")
    kept = keep_beside(target)
    write_to(state, target)
    return kept


def _check(state: Calibration) -> None:
    if isinstance(state.alignment, InputError):
        raise state.alignment
    if not state.cameras:
        raise InputError(
            "nothing is calculated that could be saved",
            where="calibration",
            remedy="Calculate the lenses, and place all cameras.",
        )
