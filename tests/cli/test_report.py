"""``stereotrack report``: one page that stands alone."""

import re
import shutil

import pytest

from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import keep_run

SECTIONS = (*("recording", "subject", "errors", "curves", "failures"), *("parameters", "again"))


@pytest.fixture(scope="session")
def page(recording, tracked, tmp_path_factory):
    """The page of the tiny run."""
    from stereotrack_core.program import main

    folder = tmp_path_factory.mktemp("report")
    path = folder / "report.html"
    assert main(["report", str(tracked), "-o", str(path), "--json"]) == 0
    return path.read_text("utf-8")


def test_the_page_has_all_its_sections(page):
    assert re.findall(r'<h2 id="([a-z]+)"', page) == list(SECTIONS)
    for words in ("does not state its uncertainty", "over 45 deg off", "--like", "flags"):
        assert words in page


def test_the_page_stands_alone(page):
    assert "<script" not in page
    assert "<link" not in page
    sources = re.findall(r'(?:src|href)="([^"]{0,30})', page)
    assert sources
    assert all(source.startswith(("data:image/", "#")) for source in sources)
    assert "url(" not in page


def test_without_the_recording_there_is_still_a_report(run, recording, tracked, tmp_path):
    moved = tmp_path / "elsewhere" / "run.npz"
    moved.parent.mkdir()
    from dataclasses import replace

    stored = read_npz(tracked)
    write_npz(moved, replace(stored, meta={**stored.meta, "recording_folder": "/gone/from/here"}))
    assert run("report", moved, "-o", tmp_path / "r.html", "--json").json["lost_percent"] is None
    text = (tmp_path / "r.html").read_text("utf-8")
    assert "The recording was not found" in text
    assert "the errors are unknown" in text


def test_a_run_of_a_project(run, recording, tracked, tmp_path):
    copied = tmp_path / "tiny"
    shutil.copytree(recording, copied)
    path = tmp_path / "own.stereotrack"
    with Project.create(path, copied) as project:
        project.apply(keep_run("first <try>", read_npz(tracked)))
    run("report", path, "-o", tmp_path / "r.html")
    text = (tmp_path / "r.html").read_text("utf-8")
    assert "Report on first &lt;try&gt;" in text
    wrong = run("report", path, "-o", tmp_path / "r.html", "--run", "second", status=2)
    assert "first <try>" in wrong.err


@pytest.mark.parametrize(
    "words",
    [
        ("-o", "r.txt"),
        ("-o", "r.html", "--frames", "50:60"),
        ("-o", "r.html", "--run", "x"),
        ("-o", "no/folder/r.html"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(run, tracked, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    assert run("report", tracked, *words, status=2).err.startswith("stereotrack: ")
    assert not list(tmp_path.iterdir())
