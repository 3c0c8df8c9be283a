"""Pages from templates: every text that is put into one is escaped."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup


@dataclass(frozen=True)
class Row:
    """A line of a table.

    Attributes
    ----------
    cells : sequence of str
        Texts, or :class:`markupsafe.Markup`; the first one is the line's heading.
    kind : str
        Class of the style: ``given`` for numbers of somebody else, ``first`` for the first line
        of a group; several are joined by a space.
    """

    cells: Sequence[str]
    kind: str = ""


class Table:
    """A table; a heading that begins with ``>`` stands over right-aligned numbers.

    Raises
    ------
    ValueError
        Where a line has other cells than there are headings.
    """

    def __init__(self, columns: Sequence[str], rows: Sequence[Row | Sequence[str]]) -> None:
        self.columns = tuple(columns)
        self.rows = tuple(row if isinstance(row, Row) else Row(row) for row in rows)
        if any(len(row.cells) != len(self.columns) for row in self.rows):
            raise ValueError("a line has other cells than there are headings")


def number(value: float, digits: int = 1) -> str:
    """A number; a dash where it is not known."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


def embedded(data: bytes, kind: str) -> str:
    """Address of a picture that stands in the page; `kind` ``svg+xml``, ``png`` or ``jpeg``."""
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def code(text: str) -> Markup:
    """A text as a program reads it."""
    return Markup("<code>{}</code>").format(text)


def page(template: str, title: str, *, for_print: bool = False, **content: object) -> str:
    """A whole page that needs no other file.

    Parameters
    ----------
    template : str
        Name of a file in ``templates``.
    for_print : bool
        With a plain style that simple renderers understand.
    **content
        What the template speaks of, by name.
    """
    drawn = _environment().get_template(template)
    return drawn.render(title=title, for_print=for_print, **content)


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
