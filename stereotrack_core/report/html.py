"""A small writer of HTML: everything that is not an element itself is escaped."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape
from typing import TypeAlias

from stereotrack_core.report.style import PRINT_STYLE, STYLE

_VOID = frozenset({"br", "hr", "img", "meta", "col"})
_OWN_LINE = frozenset(
    {"body", "details", "div", "figure", "h1", "h2", "h3", "head", "html", "li", "main", "nav"}
    | {"p", "section", "summary", "table", "tbody", "thead", "title", "tr", "ul", "style"}
)


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


Content: TypeAlias = "str | Html | Iterable[Content]"


def element(tag: str, /, *content: Content, **attributes: str | int | None) -> Html:
    """An element with its content; texts are escaped, :class:`Html` is not.

    Attributes are written as they are called, ``class_`` as ``class``, underscores as hyphens;
    those that are None are left out.
    """
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(str(value), quote=True)}"'
        for key, value in attributes.items()
        if value is not None
    )
    if tag in _VOID:
        return Html(f"<{tag}{given}>")
    end = "\n" if tag in _OWN_LINE else ""
    return Html(f"<{tag}{given}>{joined(content)}</{tag}>{end}")


def joined(content: Iterable[Content]) -> Html:
    """Contents after each other."""
    return Html("".join(_written(part) for part in content))


def document(title: str, *body: Content, for_print: bool = False) -> str:
    """A whole page that needs no other file; for print in a style for simple renderers."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", title),
        element("style", Html(PRINT_STYLE if for_print else STYLE)),
    )
    page = element("html", head, element("body", element("main", *body)), lang="en")
    return f"<!DOCTYPE html>\n{page}"


def heading(level: int, text: Content, key: str | None = None, kind: str | None = None) -> Html:
    """A heading that can be linked to; of kind ``new-page`` it begins a page where printed."""
    return element(f"h{level}", text, id=key, class_=kind)


def paragraph(*content: Content, kind: str | None = None) -> Html:
    """A paragraph; `kind` is a class of the style, such as ``note``."""
    return element("p", *content, class_=kind)


def bullets(items: Iterable[Content]) -> Html:
    """A list."""
    return element("ul", *(element("li", item) for item in items))


def fold(summary: str, *content: Content) -> Html:
    """Content that is shown when asked for; printed in full."""
    return element("details", element("summary", summary), *content)


def link(text: str, target: str) -> Html:
    """A link within the page."""
    return element("a", text, href=f"#{target}")


def picture(data: bytes, kind: str, alt: str, caption: Content = "", width: int = 960) -> Html:
    """A picture with a caption, embedded.

    Parameters
    ----------
    data : bytes
        Of the file.
    kind : str
        ``svg+xml``, ``png`` or ``jpeg``.
    alt : str
        What it shows, for those who do not see it.
    caption : str or Html
    width : int, pixels
        At most; it shrinks with the page.
    """
    source = f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"
    image = element("img", src=source, alt=alt, width=width)
    under = element("p", caption, class_="caption") if caption else ""
    return element("div", image, under, class_="figure")


def _written(part: Content) -> str:
    if isinstance(part, Html):
        return str(part)
    if isinstance(part, str):
        return escape(part, quote=False)
    return joined(part)
