"""The page about a calibration: verdict, errors of cameras and pairs, what was left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.calibrate.verdict import Verdict
from stereotrack_core.report.pages import page
from stereotrack_core.tables import Table


def write_calibration_page(
    path: Path, name: str, verdict: Verdict, tables: Sequence[Table]
) -> None:
    """Write a page that needs no other file.

    Raises InputError where it cannot be written.
    """
    title = f"Calibration {name}"
    write_file(path, page("calibration.html", title, verdict=verdict, tables=list(tables)))
