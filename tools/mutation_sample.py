"""Do the fast tests find small faults? A sample of faults is planted, one at a time, and tested.

Usage: python tools/mutation_sample.py [--count 50] [--seed 0] [--rooms tracking depth]

Faults are signs, comparisons, factors, ``and`` for ``or``, ``min`` for ``max``, and constants that
are twice as large. Each is planted in a copy of the program. The tests that name the changed module
run first, then all fast tests of its room; the first failure ends them. Survivors are printed with
their places: some change nothing that could be seen, and the others lack a test.
"""

import argparse
import ast
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import environ
from pathlib import Path
from queue import SimpleQueue
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "stereotrack_core"

_MOST_SECONDS = 900
"""Time after which tests of a fault are ended; one that makes the program hang is found."""

_OPERATORS: dict[type[ast.AST], Any] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.Gt, ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
_NAMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}


@dataclass(frozen=True)
class Fault:
    """One place in a file (relative to the checkout), and what takes its place."""

    path: Path
    line: int
    columns: tuple[int, int]
    before: str
    after: str

    def planted(self, source: str) -> str:
        """The source with the fault."""
        lines = source.splitlines(keepends=True)
        line = lines[self.line - 1].encode()
        start, stop = self.columns
        lines[self.line - 1] = (line[:start] + self.after.encode() + line[stop:]).decode()
        return "".join(lines)


def faults_of(path: Path) -> Iterator[Fault]:
    """All faults that can be planted in a file, without those in texts and annotations."""
    source = (ROOT / path).read_text()
    for node in _computed(ast.parse(source)):
        changed = _changed(node) if node.lineno == node.end_lineno else None
        if changed is not None and node.end_col_offset is not None:
            columns = node.col_offset, node.end_col_offset
            yield Fault(path, node.lineno, columns, ast.unparse(node), f"({ast.unparse(changed)})")


def _computed(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions that compute something."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "msg"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.Assert | ast.Raise | ast.JoinedStr):
                continue
            if isinstance(child, ast.expr):
                yield child
            if isinstance(child, ast.AST):
                yield from _computed(child)


def _changed(node: ast.expr) -> ast.expr | None:
    match node:
        case ast.BinOp(left, op, right) if type(op) in _OPERATORS:
            if any(
                isinstance(one, ast.Constant) and isinstance(one.value, str)
                for one in (left, right)
            ):
                return None
            return ast.BinOp(left, _OPERATORS[type(op)](), right)
        case ast.Compare(left, [op], right) if type(op) in _OPERATORS:
            return ast.Compare(left, [_OPERATORS[type(op)]()], right)
        case ast.BoolOp(op, values):
            return ast.BoolOp(_OPERATORS[type(op)](), values)
        case ast.UnaryOp(ast.USub() | ast.Not(), operand):
            return operand
        case ast.Constant(float(value)) if abs(value) > 1e-6:
            return ast.Constant(2.0 * value)
        case ast.Call(ast.Name(name), arguments, keywords) if name in _NAMES:
            return ast.Call(ast.Name(_NAMES[name]), arguments, keywords)
        case ast.Call(ast.Attribute(owner, name), arguments, keywords) if name in _NAMES:
            return ast.Call(ast.Attribute(owner, _NAMES[name]), arguments, keywords)
    return None


def found_by_tests(fault: Fault, copy: Path) -> bool:
    """Whether fast tests fail in a copy of the checkout in which the fault is planted."""
    place = copy / fault.path
    source = place.read_text()
    place.write_text(fault.planted(source))
    try:
        module = ".".join(fault.path.with_suffix("").parts)
        tests = sorted((copy / "tests").rglob("test_*.py"))
        near = [str(test) for test in tests if f"{module} import" in test.read_text()]
        room = [str(copy / "tests" / fault.path.parts[1])]
        return any(_fails(chosen, copy) for chosen in (near, room) if chosen)
    finally:
        place.write_text(source)


def _fails(tests: list[str], copy: Path) -> bool:
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    command += ["--no-header", "-m", "not slow and not window", *tests]
    own = {"PYTHONPATH": str(copy), "OPENBLAS_NUM_THREADS": "1", "QT_QPA_PLATFORM": "offscreen"}
    try:
        done = subprocess.run(
            command, cwd=copy, env={**environ, **own}, capture_output=True, timeout=_MOST_SECONDS
        )
    except subprocess.TimeoutExpired:
        return True
    return done.returncode not in (0, 5)  # 5: there are no such tests


def main() -> int:
    """Plant a sample of faults and print which of them tests find."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rooms", nargs="+", default=["tracking", "depth"])
    parser.add_argument("--least", type=float, default=0.5, help="failing share; 0.9 is the goal")
    parser.add_argument("--jobs", type=int, default=2, help="faults that are tested at once")
    asked = parser.parse_args()
    files = [path for room in asked.rooms for path in sorted((ROOT / PACKAGE / room).rglob("*.py"))]
    every = [fault for path in files for fault in faults_of(path.relative_to(ROOT))]
    sample = random.Random(asked.seed).sample(every, min(asked.count, len(every)))
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(asked.jobs) as pool:
        copies: SimpleQueue[Path] = SimpleQueue()
        ignored = shutil.ignore_patterns(".git", ".venv", "build", "dist", "__pycache__")
        for job in range(asked.jobs):
            copies.put(Path(shutil.copytree(ROOT, Path(folder, str(job)), ignore=ignored)))

        def tried(fault: Fault) -> bool:
            copy, since = copies.get(), time.monotonic()
            try:
                found = found_by_tests(fault, copy)
            finally:
                copies.put(copy)
            how = "found   " if found else "SURVIVED"
            what = f"{fault.path}:{fault.line}  {fault.before} -> {fault.after}"
            print(f"{how} {what}  ({time.monotonic() - since:.0f} s)", flush=True)
            return found

        count = sum(pool.map(tried, sample))
    print(f"{count} of {len(sample)} faults found ({len(every)} could be planted)")
    return int(count < asked.least * len(sample))


if __name__ == "__main__":
    sys.exit(main())
