"""The pages that are made from the code say what the code says."""

import re
import runpy
import tomllib
from collections.abc import Iterator
from pathlib import Path

import yaml

from app.shell.help import anchor_of
from stereotrack_core import __version__
from stereotrack_core.cli.commands import COMMANDS
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.description import read_subject
from stereotrack_core.recording.folder import parse_view
from stereotrack_core.recording.toml_table import Table

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_of_parameters_is_up_to_date():
    tool = runpy.run_path(str(ROOT / "tools" / "write_parameters.py"))
    written = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert written == tool["parameters_page"](), "run: make docs"


def test_pages_and_paragraphs_can_be_read_in_one_go():
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = page.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= (150 if page.name == "README.md" else 450), page.name
        prose = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
        for part in re.split(r"\n\s*\n", prose):
            is_prose = not re.match(r"\s*(\||[-*] |\d+\. |#|!|<)", part)
            assert not (is_prose and len(part.splitlines()) > 6), f"{page.name}: {part[:60]}"


def sentences(page: str) -> Iterator[str]:
    """Sentences, headings and cells of tables of a page, without code and the targets of links."""
    text = re.sub(r"^```.*?^```", "", page, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"`[^`]*`", "Code", text)
    text = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(
        r"^( *\||#).*", lambda row: row[0].replace("|", "\n\n") + "\n\n", text, flags=re.MULTILINE
    )
    for block in re.split(r"\n\s*\n|\n(?= *(?:[-*]|\d+\.) )", text):
        yield from re.split(r"(?<=[.!?:])[)*_]*\s+(?=[*_(]*[A-Z])", block)


def test_sentences_can_be_read_in_one_go():
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
    long = [
        f"{page.name}: {' '.join(sentence.split())}"
        for page in pages
        for sentence in sentences(page.read_text(encoding="utf-8"))
        if len(re.findall(r"\S*\w\S*", sentence)) > 35
    ]
    assert long == []


def test_links_and_pictures_of_the_pages_lead_somewhere():
    lost = [
        f"{page.name}: {target}"
        for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
        if "://" not in target and not (page.parent / target).is_file()
    ]
    assert lost == []


def test_links_lead_to_headings_that_exist():
    known = {
        f"{page.name}#{anchor_of(heading)}"
        for page in (ROOT / "docs").glob("*.md")
        for heading in re.findall(r"^#+ +(.+?) *$", page.read_text("utf-8"), flags=re.MULTILINE)
    }
    lost = [
        f"{page.name}: {target}"
        for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
        for target in re.findall(r"\]\(([^):]*#[^)]+)\)", page.read_text(encoding="utf-8"))
        if f"{target.split('#')[0].removeprefix('docs/') or page.name}#{target.split('#')[1]}"
        not in known
    ]
    assert lost == []


def test_the_contents_page_names_every_page():
    listed = set(re.findall(r"\]\(([\w-]+\.md)\)", (ROOT / "docs/index.md").read_text("utf-8")))
    assert listed == {path.name for path in (ROOT / "docs").glob("*.md")} - {"index.md"}


def test_every_page_is_reached_from_the_readme():
    found, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        links = re.findall(r"\]\(([^)#]+\.md)\)", page.read_text(encoding="utf-8"))
        linked = {(page.parent / link).resolve() for link in links if "://" not in link} - found
        found |= linked
        waiting += linked
    assert set((ROOT / "docs").glob("*.md")) <= found


def test_the_page_of_commands_names_every_command():
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    missing = [one.name for one in COMMANDS if f"`stereotrack {one.name}" not in text]
    assert missing == []


def test_the_recording_that_is_described_can_be_read(tmp_path):
    text = (ROOT / "docs" / "recording.md").read_text(encoding="utf-8")
    described, calibration, lengths = re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    complaints: list[Exception] = []
    views = tomllib.loads(described)["views"]
    read = [parse_view(Table(view, "recording.md", complaints)) for view in views]
    assert complaints == []
    assert [view.kind for view in read] == ["stereo", "depth", "mono"]
    (tmp_path / "calibration.toml").write_text(calibration)
    assert list(read_calibration(tmp_path / "calibration.toml")) == ["N_left"]
    (tmp_path / "subject.toml").write_text(lengths)
    assert None not in vars(read_subject(tmp_path / "subject.toml")).values()


def test_the_citation_is_of_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["version"] == __version__
    assert citation["title"] == project["name"]
    assert citation["abstract"] == project["description"] + "."
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert citation["keywords"] == project["keywords"]


def test_the_code_cites_sections_of_the_method_that_exist():
    sections = set(
        re.findall(r"^#+ (\d[\d.]*\d|\d)\.? ", (ROOT / "docs/method.md").read_text(), re.MULTILINE)
    )
    cited = {
        (path.relative_to(ROOT).as_posix(), section)
        for path in (ROOT / "stereotrack_core").rglob("*.py")
        for place in re.findall(r"method\.md ([\d.]+(?: and [\d.]+)?)", path.read_text())
        for section in re.findall(r"\d(?:\.\d+)?", place)
    }
    assert len(cited) >= 10
    assert {place for place in cited if place[1] not in sections} == set()


def test_the_places_named_for_contributors_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    places = re.findall(r"`((?:app|stereotrack_core|docs)/[\w/.]*)`", text)
    assert len(places) >= 12
    assert [place for place in places if not (ROOT / place).exists()] == []


def test_the_tests_that_are_named_for_strangers_files_exist():
    text = (ROOT / "docs/security.md").read_text(encoding="utf-8")
    named = re.findall(r"`(tests/[\w/.]+)`", text)
    assert len(named) >= 7
    assert [name for name in named if not (ROOT / name).is_file()] == []
