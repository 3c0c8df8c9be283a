"""The pages that are made from the code say what the code says."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def parameters_page() -> str:
    path = ROOT / "tools" / "write_parameters.py"
    spec = importlib.util.spec_from_file_location("write_parameters", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.parameters_page()


def test_the_page_of_parameters_is_up_to_date():
    written = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert written == parameters_page(), "run: make docs"


def test_links_and_pictures_of_the_readme_exist():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    targets = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    assert targets
    assert [target for target in targets if not (ROOT / target).is_file()] == []


def test_make_help_names_every_command_for_people():
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.search(r"^\.PHONY: (.*)$", text, flags=re.MULTILINE).group(1).split())
    explained = set(re.findall(r"echo 'make ([\w-]+)", text))
    assert explained == targets - {"help", "ready"}


def test_pictures_are_small_enough_for_a_repository():
    pictures = sorted((ROOT / "docs").glob("*.png"))
    assert [path.name for path in pictures if path.stat().st_size > 300_000] == []
