"""What the page about the project file says is what the tables have."""

import re
from pathlib import Path

from stereotrack_core.project.schema import APPLICATION, FORMAT

PAGE = Path(__file__).resolve().parents[2] / "docs" / "project-file.md"
ENTRIES = "as `reference`"


def columns(project, table: str) -> list[str]:
    return [row[1] for row in project._access.rows(f"PRAGMA table_info({table})")]


def tables(project) -> set[str]:
    found = project._access.rows(
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'"
    )
    return {name for (name,) in found}


def test_the_page_names_every_table_and_its_columns(project):
    text = PAGE.read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| [^|]* \| (.*) \|$", text, flags=re.MULTILINE))
    assert set(rows) == tables(project)
    for table, description in rows.items():
        if description.startswith((ENTRIES, "the same")):
            continue
        said = set(re.findall(r"`(\w+)`", description))
        if table == "repeat_click":
            said |= set(columns(project, "click"))
        assert set(columns(project, table)) <= said, table
    assert f"{APPLICATION:#x}".replace("0x", "").upper() in text.upper()
    assert f"the format, now {FORMAT}" in text
