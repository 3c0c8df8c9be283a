"""The lock: everything the project names is in it, at one version."""

import re
import tomllib
from functools import cache
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]


@cache
def locked() -> list[Requirement]:
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    return [Requirement(line.split(" #")[0]) for line in lines if line and line[0] != "#"]


def declared() -> list[Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    rows = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    return [Requirement(row) for row in rows]


def locked_version(python: str, name: str) -> str | None:
    environment = {
        **default_environment(),
        "python_version": python,
        "python_full_version": f"{python}.0",
    }
    for row in locked():
        if canonicalize_name(row.name) == name and (
            row.marker is None or row.marker.evaluate(environment)
        ):
            return next(iter(row.specifier)).version
    return None


def test_every_line_pins_one_version_and_names_no_place():
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert "://" not in text
    assert "/" not in re.sub(r"#.*", "", text)
    for row in locked():
        assert [specifier.operator for specifier in row.specifier] == ["=="], row


def test_what_the_project_needs_is_locked_on_every_python():
    for python in ("3.11", "3.12", "3.13", "3.14"):
        for row in declared():
            if row.marker is not None and not row.marker.evaluate():
                continue
            version = locked_version(python, canonicalize_name(row.name))
            assert version is not None, (python, row.name)
            assert row.specifier.contains(version), (python, row.name, version)


def test_the_opencv_that_breaks_qt_is_not_in_the_lock():
    names = {canonicalize_name(row.name) for row in locked()}
    assert "opencv-python-headless" in names
    assert not names & {"opencv-python", "opencv-contrib-python"}
