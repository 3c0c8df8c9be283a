"""Pages from templates: every text that is put into one is escaped."""

from __future__ import annotations

import base64
import os
import shlex
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.calibrate.verdict import Verdict
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.evaluation.accuracy import Accuracy, stated_means
from stereotrack_core.evaluation.failure_segments.segment import FOUND_WORDS, limbs_words
from stereotrack_core.evaluation.summary import LOST_ANGLE
from stereotrack_core.own_program import module_command
from stereotrack_core.recording.consistency import FILES
from stereotrack_core.recording.description import Recording
from stereotrack_core.report import run_tables
from stereotrack_core.report.drawing import Kind, limb_curves
from stereotrack_core.report.reported import Reported, ShownFailure
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import PRESETS

if TYPE_CHECKING:
    from jinja2 import Environment


def embedded(data: bytes, kind: str) -> str:
    """Address of a picture that stands in the page; `kind` ``svg``, ``png`` or ``jpeg``."""
    kind = "svg+xml" if kind == "svg" else kind
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def code(text: str) -> Markup:
    """A text as a program reads it."""
    return Markup("<code>{}</code>").format(text)


def page(template: str, title: str, *, for_print: bool = False, **content: object) -> str:
    """A whole page, of what a file in ``templates`` speaks of, that needs no other file.

    One that is for print has a plain style that simple renderers understand.
    """
    drawn = _environment().get_template(template)
    return drawn.render(title=title, for_print=for_print, **content)


@cache
def _environment() -> Environment:
    # the window asks for reports, but should not wait for what writes them before it shows
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


_OF_CAMERAS = ("calibration", "camera", "view")


def run_page(reported: Reported, kind: Kind = "svg", *, for_print: bool = False) -> str:
    """The whole report as HTML, its curves of this kind; see :func:`page`."""
    source, run, accuracy = reported.source, reported.source.run, reported.accuracy
    shown = reported.failures
    errors = None if accuracy is None else accuracy.errors
    failures = [one.failure for one in shown]
    return page(
        "run.html",
        f"Report on {source.name}",
        for_print=for_print,
        reported=reported,
        source=source,
        accuracy=accuracy,
        lead=_lead(reported),
        views=[str(name) for name in run.meta.get("views", [])],
        subject=run.meta.get("subject"),
        preset=str(run.meta.get("preset") or ""),
        known_preset=str(run.meta.get("preset") or "") in PRESETS,
        curves=embedded(limb_curves(run, errors, failures, reported.segments, kind), kind),
        found=FOUND_WORDS[shown[0].failure.found] if shown else "",
        strips=[_strip(one) for one in shown if one.strip is not None],
        doubts=None if accuracy is None else accuracy.doubts,
        within_two=[] if accuracy is None else _within_two(run, accuracy),
        **_of_cameras(reported),
        **_of_reference(reported),
        **run_tables.tables(reported),
    )


def _lead(reported: Reported) -> str:
    """The most important in two or three sentences."""
    source = reported.source
    run = source.run
    tracked = int(run.tracked.sum())
    seconds = len(run.frame) / source.fps
    name = run.meta.get("recording") or "an unnamed recording"
    said = [
        f"Recording {name}, frames {run.frame[0]} to {run.frame[-1]} ({seconds:.0f} s at "
        f"{source.fps:g} per second), tracked with preset {run.meta.get('preset') or 'unknown'}: "
        f"{tracked} of {len(run.frame)} frames have a pose."
    ]
    accuracy = reported.accuracy
    if accuracy is not None:
        said.append(f"Mean errors: {'; '.join(stated_means(accuracy))}.")
        said.append(f"{100.0 * accuracy.summary.lost:.1f} % of the arm segments are lost.")
    else:
        said.append(
            "There is no reference, so the errors are unknown. The report shows the run's own "
            "failure probabilities instead."
        )
    count = len(reported.failures)
    said.append(f"{count or 'No'} failure{'' if count == 1 else 's'} detected.")
    if run.meta.get("started_at_reference"):
        said.append(
            "This run was initialised with the reference's pose, so it knows part of the truth."
        )
    return " ".join(said)


def _strip(shown: ShownFailure) -> dict[str, str]:
    failure = shown.failure
    words = limbs_words(failure.limbs)
    return {
        "source": embedded(shown.strip or b"", "jpeg"),
        "alt": f"Failure: {words}",
        "caption": f"Frames {failure.first} to {failure.last}, {words}: {failure.verdict.words}.",
    }


def _within_two(run: Run, accuracy: Accuracy) -> list[str]:
    """Share of errors within twice the stated error by limb, limbs that are lost left out."""
    found = accuracy.errors
    _, own, other = np.intersect1d(run.frame, found.frame, return_indices=True)
    shares = []
    for i, limb in enumerate(LIMBS):
        degrees, sigma = np.degrees(found.of_limb(limb))[other], run.limb_sigma_deg[own, i]
        known = np.isfinite(degrees) & np.isfinite(sigma) & (degrees <= np.degrees(LOST_ANGLE))
        if known.any():
            share = 100.0 * float((degrees[known] <= 2.0 * sigma[known]).mean())
            shares.append(f"{limb.replace('_', ' ')} {share:.0f} %")
    return shares


def _of_cameras(reported: Reported) -> dict[str, Any]:
    """The recording, what was found about its cameras and elsewhere, and a verdict in words."""
    own = reported.source.recording
    about_cameras = [one for one in reported.findings if _about_cameras(one)]
    others = [one for one in reported.findings if not _about_cameras(one)]
    # whether pixels that several views have seen were there to compare the cameras by
    files = [] if own is None else [name for name, _ in FILES if (own.folder / name).is_file()]
    return {
        "recording": own,
        "findings": [_finding(one) for one in others],
        "camera_findings": [_finding(one) for one in about_cameras],
        "compared_by": files,
        "verdict": "" if own is None else _verdict(own, about_cameras),
    }


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
            f"Usable: no inconsistencies between its {cameras} cameras. Lenses, stereo pairs, "
            "viewing directions and the size of the rig are plausible."
        )
    errors = sum(finding.severity == "error" for finding in grave)
    word = "Wrong" if errors else "Doubtful"
    return f"{word}: {len(grave)} of the checks of its {cameras} cameras failed."


def _of_reference(reported: Reported) -> dict[str, int]:
    """How many frames the reference states its uncertainty of, and how many were filled in."""
    states = reported.source.states
    if states is None:
        return {"stated_frames": 0, "filled_frames": 0}
    inside = np.isin(states.frame, reported.source.run.frame)
    filled = 0 if states.filled is None else int(states.filled[inside].sum())
    return {"stated_frames": int(inside.sum()), "filled_frames": filled}


_PDF_SECONDS = 300.0


def write_page(path: Path, reported: Reported) -> None:
    """Write a report as HTML."""
    write_file(path, run_page(reported))


def write_calibration_page(
    path: Path, name: str, verdict: Verdict, tables: Sequence[Table]
) -> None:
    """Write the page about a calibration: verdict, errors of cameras and pairs, what was left out.

    Raises InputError where it cannot be written.
    """
    title = f"Calibration {name}"
    write_file(path, page("calibration.html", title, verdict=verdict, tables=list(tables)))


def write_pdf(path: Path, reported: Reported, window_package: str | None) -> None:
    """Write a report as PDF; the window's package does it, in a process of its own.

    Raises InputError where that package is missing or fails.
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
        command = module_command(f"{window_package}.pdf", [str(page), str(made)])
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
