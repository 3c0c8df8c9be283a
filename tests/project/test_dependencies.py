"""What the code imports and what pyproject.toml declares are the same."""

import re
import sys
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
OWN = {path.stem for path in (ROOT / "tools").iterdir()} | {
    *("app", "benchmarks", "stereotrack_app", "stereotrack_core", "tests")
}


IMPORT = re.compile(
    r"^\s*from (\w+)[\w.]* import\b|^\s*import (\w+)[\w.]*(?: as \w+)?$"
    r"|\b(?:import_module|importorskip|extra_library)\(\s*\"(\w+)",
    re.MULTILINE,
)


@cache
def imported(*folders: str) -> frozenset[str]:
    """Top-level modules from outside that the code in these folders imports."""
    paths = (path for folder in folders for path in (ROOT / folder).rglob("*.py"))
    found = (one for path in paths for one in IMPORT.findall(path.read_text(encoding="utf-8")))
    return frozenset({"".join(names) for names in found} - sys.stdlib_module_names - OWN)


@cache
def installed() -> Mapping[str, list[str]]:
    return packages_distributions()


def distributions(module: str) -> set[str]:
    """The distributions that bring a module; one of its own name where it is not installed."""
    return {canonicalize_name(name) for name in installed().get(module, [module])}


def declared(*extras: str) -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    optional = project["optional-dependencies"]
    rows = [*project["dependencies"], *(row for extra in extras for row in optional[extra])]
    return {canonicalize_name(Requirement(row).name) for row in rows}


PROGRAM = ("app", "stereotrack_core")
CHOSEN = ("cluster", "detect", "sleap")


@pytest.mark.parametrize(
    ("folders", "extras"),
    [(PROGRAM, CHOSEN), (("tests", "tools", "benchmarks"), (*CHOSEN, "dev", "readers"))],
)
def test_what_is_imported_is_declared(folders, extras):
    modules = imported(*folders)
    assert modules
    declaration = declared(*extras)
    assert {name for name in modules if not distributions(name) & declaration} == set()


def test_what_is_declared_for_the_program_is_imported():
    used = {name for module in imported(*PROGRAM) for name in distributions(module)}
    assert declared(*CHOSEN) - used == set()
