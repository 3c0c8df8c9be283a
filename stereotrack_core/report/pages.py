"""Pages from templates: every text that is put into one is escaped."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup


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
