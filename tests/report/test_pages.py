"""Pages from templates: well-formed, escaped, standing alone."""

from html.parser import HTMLParser

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.report.pages import _environment, drawn_axes, embedded, svg_of
from stereotrack_core.tables import Table

VOID = {"br", "hr", "img", "meta", "col"}


class Reader(HTMLParser):
    """Collects texts, and refuses what is not closed in its order."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.texts, self.attributes, self.seen = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.seen.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def read(html):
    reader = Reader()
    reader.feed(html)
    reader.close()
    assert reader.open == []
    return reader


def drawn(content: str, **values: object) -> str:
    """A page with this content."""
    parts = '{% extends "page.html" %}{% from "parts.html" import bullets, picture, table %}'
    template = _environment().from_string(f"{parts}{{% block content %}}{content}{{% endblock %}}")
    return template.render(title="A < B", **values)


PRINTED = st.text(alphabet=st.characters(codec="utf-8", exclude_categories=["Cc"]))


@settings(max_examples=30)
@given(PRINTED)
def test_any_text_comes_out_as_it_went_in(text):
    plain, page = (read(drawn("<p>{{ text }}</p>", text=one)) for one in ("", text))
    assert page.seen == plain.seen
    assert text in "".join(page.texts)


def test_a_page_is_well_formed_and_needs_nothing_else():
    page = drawn(
        "{{ bullets(items) }}{{ table(shown) }}{{ picture(source, alt, caption) }}",
        items=["one", "two <script>"],
        shown=Table("", ("", ">n"), [("a", "1"), ("b", "2")], ["first", ""]),
        source=embedded(b"abc", "png"),
        alt='a "quoted" picture',
        caption="caption",
    )
    reader = read(page)
    assert page.startswith("<!DOCTYPE html>")
    assert "script" not in reader.seen
    assert "link" not in reader.seen
    assert not [v for k, v in reader.attributes if k in ("src", "href") and "//" in (v or "")]
    assert "A < B" in reader.texts
    assert ("alt", 'a "quoted" picture') in reader.attributes
    assert reader.attributes.count(("class", "right")) == 3


@pytest.mark.parametrize("name", [r"$\foo$", "a $x_{$ b", "$$", "3 $ and 4 $"])
def test_dollar_signs_in_names_begin_no_formula(name):
    figure, axes = drawn_axes(1, 3.0, 2.0)
    axes[0].set_title(name)
    axes[0].annotate(name, (0.5, 0.5))
    axes[0].set_xticks([0.0, 1.0], [name, name])
    assert svg_of(figure)
