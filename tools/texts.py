"""Print every text that a person may read, with its place: window, messages, help and commands.

Usage: python tools/texts.py [FOLDER ...]    (default: app and stereotrack_core)

Texts are the string literals with a space in them, or beside an upper-case first letter, that are
neither docstrings nor code: keys, SQL, formats and style sheets are left out. Literals that stand
side by side, and f-strings with their placeholders, are one text.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

_WORDS = re.compile(r"[A-Za-z]{2,}[^\n]* [^\n]*[A-Za-z]{2,}|[A-Z][a-z]{2,}[.…]?$")
_CODE = re.compile(
    r"^\s*(SELECT|INSERT|UPDATE|DELETE|CREATE|DROP|PRAGMA|BEGIN|ATTACH|DETACH|VACUUM|ALTER)\b"
    r"|[{;]\s*[\w-]+:\s|::|^Q[A-Z]\w+$|^[\w.]+Error$"
)


def texts(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of every literal of a module that a person may read."""
    tree = ast.parse(source)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    inside = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in ast.walk(node)
        if part is not node
    }
    bare = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    left_out = docstrings | inside | bare
    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or id(node) in left_out:
            continue
        text = _text(node)
        if text and _WORDS.search(text) and not _CODE.search(text):
            yield node.lineno, " ".join(text.split())


def _text(node: ast.expr) -> str:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if not isinstance(node, ast.JoinedStr):
        return ""
    return "".join(
        str(part.value) if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)}}}"
        for part in node.values
        if isinstance(part, ast.Constant | ast.FormattedValue)
    )


def main(folders: list[str]) -> None:
    """Print the texts of folders of the project."""
    for folder in folders or ["app", "stereotrack_core"]:
        for path in sorted((ROOT / folder).rglob("*.py")):
            for line, text in sorted(texts(path.read_text(encoding="utf-8"))):
                print(f"{path.relative_to(ROOT)}:{line}\t{text}")


if __name__ == "__main__":
    main(sys.argv[1:])
