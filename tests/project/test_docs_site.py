"""The documentation site is built without a warning, and its links lead somewhere."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).resolve().parents[2]


class _Page(HTMLParser):
    """What a page links to, and the places in it that can be linked to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.targets: set[str] = set()
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value is not None and name in ("href", "src"):
                self.targets.add(value)
            elif value is not None and name == "id":
                self.places.add(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = ("-m", "sphinx", "-q", "-W", "--keep-going", "-c", "tools/docs_site", ".", folder)
    subprocess.run([sys.executable, *command], cwd=ROOT, check=True)
    return folder


@pytest.mark.slow
def test_every_link_of_the_site_leads_somewhere(site):
    pages = {path: _Page(path.read_text("utf-8")) for path in site.rglob("*.html")}
    lost = []
    for path, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            leads_to = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            known = pages.get(leads_to)
            if not leads_to.exists() or (
                parts.fragment and known and unquote(parts.fragment) not in known.places
            ):
                lost.append(f"{path.relative_to(site)}: {target}")
    assert len(pages) > 30
    assert lost == []


@pytest.mark.slow
def test_notebooks_show_what_they_computed(site):
    errors = (site / "examples/from_images_to_errors.html").read_text("utf-8")
    assert errors.count("<img") >= 2
    assert re.search(r"forearms +\d+\.\d deg", errors)
    clicks = (site / "examples/clicks_to_reference.html").read_text("utf-8")
    assert len(re.findall(r"mm off, stated", clicks)) >= 3


@pytest.mark.slow
def test_the_public_names_are_in_the_reference(site):
    page = (site / "docs/python.html").read_text("utf-8")
    for name in ("DepthChain", "evaluate", "open_recording", "track"):
        assert re.search(rf'id="stereotrack_core\.[\w.]+\.{name}"', page), name
