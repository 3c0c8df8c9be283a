"""Curves drawn by matplotlib, without a window and without its global state."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.evaluation.summary import LOST_ANGLE
from stereotrack_core.recording.description import Segment
from stereotrack_core.tracking.frame import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Kind: TypeAlias = Literal["svg", "png"]

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
_DPI = 144


def drawn_axes(rows: int, columns: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of so many inches with its axes, row by row."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        made = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    return figure, list(made.ravel())


def image_of(figure: Figure, kind: str, dpi: int = _DPI) -> bytes:
    """The figure as a file (svg, png or pdf), the same bytes for the same figure."""
    import matplotlib
    from matplotlib.text import Text

    buffer = BytesIO()
    dated = {"svg": "Date", "pdf": "CreationDate"}
    for text in figure.findobj(Text):
        text.set_parse_math(False)  # a dollar sign is one: names from files are no formulas
    with matplotlib.rc_context(_STYLE):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata={dated.get(kind, "Software"): None})
    return buffer.getvalue()


_ORDER = ("torso", "left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm")
_WIDTH, _HEIGHT = 9.0, 1.25


def limb_curves(
    run: Run,
    errors: LimbErrors | None,
    failures: Sequence[FailureSegment],
    segments: Sequence[Segment],
    kind: Kind = "svg",
) -> bytes:
    """One panel per limb below each other.

    With a reference: the error, and what the run states to be its standard deviation. Without
    one: the standard deviation, and the probability that the limb is lost on the right axis.
    Failures are shaded; segments are named above.
    """
    figure, axes = drawn_axes(len(_ORDER), 1, _WIDTH, _HEIGHT * len(_ORDER) + 0.5)
    highest = _highest(run, errors)
    for ax, limb in zip(axes, _ORDER, strict=True):
        place, colour = LIMBS.index(limb), LIMB_COLOURS[limb]
        sigma = _with_gaps(run.frame, run.limb_sigma_deg[:, place])
        if errors is None:
            ax.plot(*sigma, color=colour, linewidth=1.4)
            _chance(ax, run.frame, run.limb_lost[:, place])
        else:
            ax.fill_between(*sigma, color="#57606a", alpha=0.18, linewidth=0)
            degrees = np.degrees(errors.of_limb(limb))
            ax.plot(*_with_gaps(errors.frame, degrees), color=colour, linewidth=1.4)
            ax.axhline(float(np.degrees(LOST_ANGLE)), color="#57606a", linewidth=0.7, linestyle=":")
        for failure in failures:
            if limb in failure.limbs:
                ax.axvspan(failure.first, failure.last + 1, color="#f3d9c9", linewidth=0, zorder=0)
        ax.set_title(limb.replace("_", " "), loc="left", fontsize=9)
        ax.set_ylim(0, highest)
        ax.set_ylabel("deg")
    _name_segments(axes[0], segments)
    axes[-1].set_xlabel("frame")
    return image_of(figure, kind)


def _highest(run: Run, errors: LimbErrors | None) -> float:
    """Where all panels end: at the largest value, 60 at least and 180 at most."""
    values = [run.limb_sigma_deg.ravel()]
    if errors is not None:
        values = [np.degrees(errors.of_limb(limb)) for limb in _ORDER]
    known = np.concatenate(values)
    known = known[np.isfinite(known)]
    most = float(known.max()) if known.size else 0.0
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
