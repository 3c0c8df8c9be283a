"""The stand-alone program: how it starts, and what is tried of it when it is made."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from stereotrack_core.cli.commands import command_named, parser_of
from stereotrack_core.version import __version__

ROOT = Path(__file__).parents[2]


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools")
    return importlib.import_module("make_bundle")


def test_it_starts_the_program(tmp_path):
    entry = ROOT / "tools" / "bundle" / "entry.py"
    done = subprocess.run(
        [sys.executable, entry, "--version"], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == (f"stereotrack {__version__}\n", "")


def test_what_is_tried_can_be_said_and_makes_what_is_looked_for(tool):
    for words in tool.TRIED:
        if not words[0].startswith("--"):
            parser_of(command_named(words[0])).parse_args(list(words[1:]))
    assert set(tool.MADE) <= {word for words in tool.TRIED for word in words}


def test_the_lock_is_given_without_its_reasons(tool):
    rows = tool.locked_versions().splitlines()
    assert any(row.startswith("numpy==") for row in rows)
    assert not any("#" in row for row in rows)
