"""Rules of the house that neither ruff nor the import contract can check."""

import ast
import functools
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


@functools.cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def nodes(*folders: str) -> Iterator[tuple[Path, ast.AST]]:
    for path in sources(*folders):
        for node in nodes_of(path):
            yield path, node


def lines_of(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


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
        and len(node.args) < 3
        and not any(keyword.arg == "remedy" for keyword in node.keywords)
    ]
    assert not silent


def test_files_have_one_subject_and_stay_short():
    long = {
        name_of(path): count
        for path in sources(*PACKAGES, "benchmarks", "tests", "tools")
        if (count := len(lines_of(path))) > LONGEST_FILE
    }
    assert not long


def test_the_median_file_is_short():
    counts = [len(lines_of(path)) for path in sources(*PACKAGES) if path.name != "__init__.py"]
    assert statistics.median(counts) <= 220


def test_functions_fit_on_a_screen():
    long = {
        f"{name_of(path)}:{function.lineno} {function.name}": count
        for path, function in nodes(*PACKAGES, "benchmarks", "tools")
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        and (count := body_lines(function)) > LONGEST_FUNCTION
    }
    assert not long


def test_nothing_is_left_unfinished():
    unfinished = re.compile(r"\b(TODO|FIXME|XXX|NotImplementedError)\b")
    found = [
        f"{name_of(path)}:{number}"
        for path in sources(*PACKAGES, "benchmarks", "tools")
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


def test_what_is_open_is_known_without_widgets():
    """The import contracts see packages of others as a whole, not Qt's parts."""
    widgets = ("PySide6.QtWidgets", "pyqtgraph")
    found = [
        name_of(path)
        for path, node in nodes("app/session")
        if (isinstance(node, ast.ImportFrom) and (node.module or "").startswith(widgets))
        or (
            isinstance(node, ast.Import)
            and any(alias.name.startswith(widgets) for alias in node.names)
        )
    ]
    assert not found


WRITING = {
    *("write_text", "write_bytes", "tofile", "touch", "savetxt", "savez", "savez_compressed"),
    *("savefig", "save_slp", "imwrite", "imwritemulti", "FileStorage", "mkstemp"),
    *("NamedTemporaryFile", "TemporaryFile"),
    *("QSaveFile", "QFile", "QImageWriter", "copyfile", "copy2", "copytree"),
}
WRITES_BY_ITSELF = {
    "stereotrack_core/atomic.py": {"touch", "write_bytes", "open"},
    "stereotrack_core/interop/records.py": {"touch", "open"},  # they are only ever added to
    "stereotrack_core/project/runs.py": {"open"},  # to hold it, as nothing is written
    "stereotrack_core/locks.py": {"open"},  # a note for people who wait
    "stereotrack_core/interop/sleap.py": {"save_slp"},  # to a temporary file, and read back
    "stereotrack_core/interop/calibrations/opencv_storage.py": {"FileStorage"},  # into memory
    "stereotrack_core/interop/npz.py": {"savez", "savez_compressed"},  # into memory
    "stereotrack_core/report/pages.py": {"savefig"},
    "stereotrack_core/recording/importing/files.py": {"open"},  # to a temporary file
    "stereotrack_core/recording/writing.py": {"open"},  # to a temporary file, and read back
    "stereotrack_core/cli/options.py": {"TemporaryFile"},  # whether one can be made there
    "app/shell/dialogs.py": {"save"},
}
"""What does not go through :mod:`stereotrack_core.atomic`, and need not."""


def _writing_call(node: ast.AST) -> str:
    """Name of what writes a file in this call; empty for other syntax."""
    if not isinstance(node, ast.Call):
        return ""
    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
    if name == "open":
        at = 0 if isinstance(node.func, ast.Attribute) else 1
        modes = [*node.args[at:], *(word.value for word in node.keywords if word.arg == "mode")]
        texts = [mode.value for mode in modes if isinstance(mode, ast.Constant)]
        return name if any(isinstance(t, str) and set(t) & set("wax+") for t in texts) else ""
    if name == "save":  # QPainter's has no arguments
        return name if node.args else ""
    return name if name in WRITING else ""


def test_files_are_written_in_one_way():
    """Whatever the program writes replaces what was there when it is whole, and not before."""
    found: dict[str, set[str]] = {}
    for path, node in nodes(*PACKAGES):
        if name := _writing_call(node):
            found.setdefault(name_of(path), set()).add(name)
    assert found == WRITES_BY_ITSELF


def test_what_a_library_has_written_is_read_back():
    """Only SQLite notices by itself that a drive is full."""
    unchecked = [
        f"{name_of(path)}:{node.lineno}"
        for path, node in nodes(*PACKAGES)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "replacing"
        and len(node.args) < 2
        and not name_of(path).startswith("stereotrack_core/project/")
    ]
    assert not unchecked


ROOMS_THAT_READ = ("recording", "interop", "annotation", "tracking", "evaluation")
BESIDE = {
    *("interop/sleap.py", "interop/records.py"),
    *("recording/toml_table.py", "tracking/thesis.py"),
}
"""They read again what they have just written, or take a text that was read as it should be."""


def test_files_of_others_are_read_in_one_place():
    """``stereotrack_core.reading`` and ``interop.npz`` say what a file may be and what it lacks."""
    core = ROOT / "stereotrack_core"
    reads = re.compile(
        r"\.read_(text|bytes)\(\)|\.read_text\(enc|np\.(load|fromfile|genfromtxt)\(|json\.loads?\("
        r"|tomllib\.|\.open\((enc|\"r)|(?<!def )(?<![\w.])open\("
    )
    found = {
        path.relative_to(core).as_posix()
        for path in sources(*(f"stereotrack_core/{room}" for room in ROOMS_THAT_READ))
        if reads.search(path.read_text(encoding="utf-8"))
    }
    assert found - BESIDE == set()


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
    tested = {
        path.relative_to(ROOT / "tests").parts[0] for path in (ROOT / "tests").rglob("test_*.py")
    }
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
