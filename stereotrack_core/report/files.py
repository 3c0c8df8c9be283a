"""A report as a file: a page for browsers, or a PDF."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.report.reported import Reported
from stereotrack_core.report.run_page import run_page

_PDF_SECONDS = 300.0


def write_page(path: Path, reported: Reported) -> None:
    """Write a report as HTML."""
    write_file(path, run_page(reported))


def write_pdf(path: Path, reported: Reported, window_package: str | None) -> None:
    """Write a report as PDF; the window's package does it, in a process of its own.

    Raises
    ------
    InputError
        Where that package is missing or fails.
    """
    if window_package is None:
        raise InputError(
            "PDFs need the workbench, which is not installed",
            where="--pdf",
            remedy="Print the page to PDF from a browser instead.",
        )
    environment = {**os.environ}
    environment.setdefault("QT_QPA_PLATFORM", "offscreen")
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        made = Path(folder) / "page.pdf"
        write_file(page, run_page(reported, "png", for_print=True))
        command = [sys.executable, "-m", f"{window_package}.pdf", str(page), str(made)]
        try:
            done = subprocess.run(  # noqa: S603 - our own program
                command, capture_output=True, text=True, env=environment, timeout=_PDF_SECONDS,
                check=False,
            )  # fmt: skip
            problem = done.stderr.strip() or "unknown reason" if done.returncode else ""
        except subprocess.TimeoutExpired:
            problem = f"not finished after {_PDF_SECONDS:.0f} s"
        if problem:
            raise InputError(
                f"the PDF could not be written ({problem.splitlines()[-1]})",
                where=str(path),
                remedy="Print the page to PDF from a browser instead.",
            )
        write_file(path, made.read_bytes())


def repeat_command(recording: str, run_name: str) -> str:
    """Command that tracks again exactly as a run was tracked."""
    words = ["stereotrack", "track", recording, "--like", run_name, "-o", "again.npz"]
    return shlex.join(words)
