"""Rules of the house that neither ruff nor the import contract can check."""

from __future__ import annotations

import ast
import re
import statistics
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("app", "stereotrack_core")
LONGEST_FILE = 450
LONGEST_FUNCTION = 45


def sources(*folders: str) -> list[Path]:
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def nodes(*folders: str) -> Iterator[tuple[Path, ast.AST]]:
    """Every piece of syntax with the file that it is in."""
    for path in sources(*folders):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            yield path, node


def lines_of(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def functions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function's code: without the docstring, and without a table that it returns.

    What has to fit on a screen is what must be followed; the rows of a table are read one by one.
    """
    statements = function.body
    if ast.get_docstring(function) is not None:
        statements = statements[1:]
    if statements and _returns_a_table(statements[-1]):
        statements = statements[:-1]
    if not statements:
        return 0
    return statements[-1].end_lineno - statements[0].lineno + 1


def _returns_a_table(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Return) and isinstance(statement.value, ast.List | ast.Tuple)


def test_every_error_for_a_person_says_what_to_do():
    silent = [
        f"{name_of(path)}:{node.lineno}"
        for path, node in nodes("stereotrack_core")
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "InputError"
        and not any(keyword.arg == "remedy" for keyword in node.keywords)
    ]
    assert not silent


def test_files_have_one_subject_and_stay_short():
    long = {
        name_of(path): count
        for path in sources(*PACKAGES, "tests", "tools")
        if (count := len(lines_of(path))) > LONGEST_FILE
    }
    assert not long


def test_the_median_file_is_short():
    counts = [len(lines_of(path)) for path in sources(*PACKAGES) if path.name != "__init__.py"]
    assert statistics.median(counts) <= 180


def test_functions_fit_on_a_screen():
    long = {
        f"{name_of(path)}:{function.lineno} {function.name}": count
        for path in sources(*PACKAGES, "tools")
        for function in functions(path)
        if (count := body_lines(function)) > LONGEST_FUNCTION
    }
    assert not long


def test_nothing_is_left_unfinished():
    unfinished = re.compile(r"\b(TODO|FIXME|XXX|NotImplementedError)\b")
    found = [
        f"{name_of(path)}:{number}"
        for path in sources(*PACKAGES, "tools")
        for number, line in enumerate(lines_of(path), start=1)
        if unfinished.search(line)
    ]
    assert not found


def test_the_core_keeps_no_global_state():
    """No ``global`` statement: what lives longer than a call belongs to an object."""
    found = [
        f"{name_of(path)}:{node.lineno}"
        for path, node in nodes("stereotrack_core")
        if isinstance(node, ast.Global)
    ]
    assert not found


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_of_code_says_what_it_is_for(package: str):
    silent = [
        name_of(folder)
        for folder in {path.parent for path in sources(package)}
        if not (folder / "__init__.py").is_file()
        or ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8"))) is None
    ]
    assert not silent


def test_every_room_of_the_core_has_tests():
    rooms = {path.parent.name for path in (ROOT / "stereotrack_core").glob("*/__init__.py")}
    tested = {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")}
    assert rooms - tested == set()


def test_no_file_names_a_place_on_one_machine():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("not a checkout of git")
    place = re.compile(r"(?<![\w.}])/(work|root|home/\w+|Users/\w+)/")
    found = [
        name
        for name in listed.stdout.split("\0")
        if name and (ROOT / name).suffix in TEXT and place.search(_text(ROOT / name))
    ]
    assert not found


TEXT = {".py", ".toml", ".md", ".lock", ".qss", ".svg", ".csv", ""}


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
