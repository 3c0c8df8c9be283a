"""Curves drawn by matplotlib, without a window and without its global state."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

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


def drawn_axes(
    rows: int, columns: int, width: float, height: float, *, share: bool = True
) -> tuple[Figure, list[Axes]]:
    """A figure of so many inches with its axes, row by row."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        made = figure.subplots(rows, columns, sharex=share, sharey=share, squeeze=False)
    return figure, list(made.ravel())


def image_of(figure: Figure, kind: Kind) -> bytes:
    """The figure as a file, the same bytes for the same figure."""
    import matplotlib

    buffer = BytesIO()
    metadata = {"Date": None} if kind == "svg" else {"Software": None}
    take_literally(figure)
    with matplotlib.rc_context(_STYLE):
        figure.savefig(buffer, format=kind, dpi=_DPI, metadata=metadata)
    return buffer.getvalue()


def take_literally(figure: Figure) -> None:
    """Let a dollar sign be one: names from files are no formulas."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        text.set_parse_math(False)


def mime(kind: Kind) -> str:
    """What comes after ``image/``."""
    return "svg+xml" if kind == "svg" else kind
