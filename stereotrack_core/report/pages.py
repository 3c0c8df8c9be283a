"""Pages from templates: every text that is put into one is escaped."""

from __future__ import annotations

import base64
import shlex
from collections.abc import Sequence
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import Finding
from stereotrack_core.evaluation.accuracy import stated_means
from stereotrack_core.evaluation.failure_segments.segment import (
    FOUND_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.evaluation.limbs import LIMB_COLOURS
from stereotrack_core.evaluation.summary import LOST_ANGLE, LimbErrors
from stereotrack_core.recording.description import Segment
from stereotrack_core.report.reported import Reported, ShownFailure, tables
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import PRESETS

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STYLE: Any = {
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#57606a",
    "axes.grid": True,
    "grid.color": "#e3e6e9",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "stereotrack",
}


def drawn_axes(rows: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of so many inches with its axes below each other."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        made = figure.subplots(rows, 1, sharex=True, sharey=True, squeeze=False)
    return figure, list(made.ravel())


def svg_of(figure: Figure) -> bytes:
    """The figure as a file, the same bytes for the same figure."""
    import matplotlib
    from matplotlib.text import Text

    buffer = BytesIO()
    for text in figure.findobj(Text):
        text.set_parse_math(False)  # a dollar sign is one: names from files are no formulas
    with matplotlib.rc_context(_STYLE):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


_ORDER = ("torso", "left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm")
_WIDTH, _HEIGHT = 9.0, 1.25


def limb_curves(
    run: Run,
    errors: LimbErrors | None,
    failures: Sequence[FailureSegment],
    segments: Sequence[Segment],
) -> bytes:
    """One panel per limb below each other.

    With a reference: the error, and what the run states to be its standard deviation. Without
    one: the standard deviation, and the probability that the limb is lost on the right axis.
    Failures are shaded; segments are named above.
    """
    figure, axes = drawn_axes(len(_ORDER), _WIDTH, _HEIGHT * len(_ORDER) + 0.5)
    highest = _highest(run, errors)
    for ax, limb in zip(axes, _ORDER, strict=True):
        place, colour = LIMBS.index(limb), LIMB_COLOURS[limb]
        sigma = _with_gaps(run.frame, run.limb_sigma_deg[:, place])
        if errors is None:
            ax.plot(*sigma, color=colour, linewidth=1.4)
            _chance(ax, run.frame, run.limb_lost[:, place])
        else:
            ax.fill_between(*sigma, color="#57606a", alpha=0.18, linewidth=0)
            ax.plot(
                *_with_gaps(errors.frame, errors.degrees[:, place]), color=colour, linewidth=1.4
            )
            ax.axhline(float(np.degrees(LOST_ANGLE)), color="#57606a", linewidth=0.7, linestyle=":")
        for failure in failures:
            if limb in failure.limbs:
                ax.axvspan(failure.first, failure.last + 1, color="#f3d9c9", linewidth=0, zorder=0)
        ax.set_title(limb.replace("_", " "), loc="left", fontsize=9)
        ax.set_ylim(0, highest)
        ax.set_ylabel("deg")
    _name_segments(axes[0], segments)
    axes[-1].set_xlabel("frame")
    return svg_of(figure)


def _highest(run: Run, errors: LimbErrors | None) -> float:
    """Where all panels end: at the largest value, 60 at least and 180 at most."""
    values = run.limb_sigma_deg if errors is None else errors.degrees
    most = float(np.max(values, initial=0.0, where=np.isfinite(values)))
    return float(np.clip(1.1 * most, 60.0, 180.0))


def _with_gaps(frame: IntArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same with NaN between frames that do not follow each other."""
    gaps = np.flatnonzero(np.diff(frame) > 1) + 1
    return (
        np.insert(frame.astype(np.float64), gaps, np.nan),
        np.insert(values.astype(np.float64), gaps, np.nan),
    )


def _chance(ax: Axes, frame: IntArray, chance: FloatArray) -> None:
    """Probability that the limb is lost, percent, on an axis of its own."""
    if not np.isfinite(chance).any():
        return
    right = ax.twinx()
    right.plot(*_with_gaps(frame, 100.0 * chance), color="#CC79A7", linewidth=0.9, linestyle="--")
    right.set_ylim(0, 100)
    right.set_ylabel("lost %", color="#8f4a70")
    right.grid(visible=False)


def _name_segments(ax: Axes, segments: Sequence[Segment]) -> None:
    for segment in segments:
        ax.annotate(
            segment.name,
            (segment.first, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, -9),
            textcoords="offset points",
            fontsize=7,
            color="#57606a",
            rotation=0,
            annotation_clip=True,
        )
        ax.axvline(segment.first, color="#c4ccd4", linewidth=0.7)


def embedded(data: bytes, kind: str) -> str:
    """Address of a picture that stands in the page; `kind` ``svg+xml`` or ``jpeg``."""
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


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


def run_page(reported: Reported) -> str:
    """The whole report as HTML."""
    source, run, accuracy = reported.source, reported.source.run, reported.accuracy
    shown = reported.failures
    errors = None if accuracy is None else accuracy.errors
    failures = [one.failure for one in shown]
    return (
        _environment()
        .get_template("run.html")
        .render(
            title=f"Report on {source.name}",
            reported=reported,
            source=source,
            accuracy=accuracy,
            lead=_lead(reported),
            views=[str(name) for name in run.meta.get("views", [])],
            subject=run.meta.get("subject"),
            preset=str(run.meta.get("preset") or ""),
            known_preset=str(run.meta.get("preset") or "") in PRESETS,
            curves=embedded(limb_curves(run, errors, failures, reported.segments), "svg+xml"),
            found=FOUND_WORDS[shown[0].failure.found] if shown else "",
            strips=[_strip(one) for one in shown if one.strip is not None],
            doubts=None if accuracy is None else accuracy.doubts,
            recording=source.recording,
            findings=[_finding(one) for one in reported.findings],
            **tables(reported),
        )
    )


def _lead(reported: Reported) -> str:
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


def _finding(finding: Finding) -> str:
    what = f"{finding.what[:1].upper()}{finding.what[1:]}"
    return f"{finding.severity.capitalize()}, {finding.where}: {what}. {finding.remedy}"


def write_page(path: Path, reported: Reported) -> None:
    """Write a report as HTML."""
    write_file(path, run_page(reported))


def repeat_command(recording: str, run_name: str) -> str:
    """Command that tracks again exactly as a run was tracked."""
    words = ["stereotrack", "track", recording, "--like", run_name, "-o", "again.npz"]
    return shlex.join(words)
