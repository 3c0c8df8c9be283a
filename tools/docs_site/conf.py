"""Settings of the documentation site, which ``make docs-site`` builds from README and docs.

The pages stay plain Markdown, as the window shows them too. What a site needs beyond is added while
it is built: the contents at the side, from the list on the first page, and the reference of the
Python interface, from the docstrings.
"""

import re
from pathlib import Path
from types import FunctionType
from typing import Any

import stereotrack_core

ROOT = Path(__file__).resolve().parents[2]

project = "stereotrack"
author = "the stereotrack authors"
project_copyright = author
release = version = stereotrack_core.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/index"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**", "examples/*.ipynb"]
html_theme = "furo"
html_title = "stereotrack"
html_theme_options: dict[str, Any] = {"top_of_page_buttons": []}
html_show_sourcelink = False
toc_object_entries = False

myst_heading_anchors = 6
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_show_tb = True
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_google_docstring = False
napoleon_use_rtype = False

_PYTHON = "docs/python"
_CLASS = "class:: {}\n   :members:"
_NOTEBOOKS = sorted(path.stem for path in (ROOT / "examples").glob("*.ipynb"))


def _contents(text: str) -> str:
    """One table of contents at the side for each heading of the first page."""
    trees = [
        (heading, re.findall(r"\]\(([\w-]+\.md)\)", part))
        for heading, part in re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    ]
    trees.append(("Notebooks", [f"../examples/{name}" for name in _NOTEBOOKS]))
    trees.append(("Project", ["../README.md", "../CONTRIBUTING.md", "../CHANGELOG.md"]))
    return "".join(
        "\n".join(["", "```{toctree}", ":hidden:", f":caption: {heading}", "", *pages, "```", ""])
        for heading, pages in trees
    )


def _reference() -> str:
    """The public names with their docstrings."""
    parts = ["\n## Reference\n"]
    for name in sorted(set(stereotrack_core.__all__) - {"__version__"}):
        found = getattr(stereotrack_core, name)
        place = f"{found.__module__}.{name}"
        entry = f"function:: {place}" if isinstance(found, FunctionType) else _CLASS.format(place)
        parts.append(f"### {name}\n\n```{{eval-rst}}\n.. auto{entry}\n```\n")
    return "\n".join(parts)


def _extend(_app: Any, page: str, source: list[str]) -> None:
    if page == root_doc:
        source[0] += _contents(source[0])
    elif page == _PYTHON:
        source[0] += _reference()


def _front_door(app: Any, problem: Exception | None) -> None:
    """Lead from the folder of the site to its first page."""
    if problem is None:
        to = f"{root_doc}.html"
        Path(app.outdir, "index.html").write_text(
            f'<!doctype html><meta http-equiv="refresh" content="0; url={to}">'
            f'<a href="{to}">{project}</a>\n',
            encoding="utf-8",
        )


def setup(app: Any) -> None:
    """Connect what is added while the site is built."""
    app.connect("source-read", _extend)
    app.connect("build-finished", _front_door)
