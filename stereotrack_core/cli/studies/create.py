"""``stereotrack study create``: list recordings in a study file."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_output, option
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.studies.shared import say_findings
from stereotrack_core.study.create import Pattern, create_study
from stereotrack_core.study.file import check_name
from stereotrack_core.tables import Table

DESCRIPTION = (
    "List all recordings below folders, with their projects, in a table that a spreadsheet can "
    "edit. Further columns are factors such as subject or condition; --pattern fills them from the "
    "names of the folders. The same command adds new recordings and writes the new places of moved "
    "ones; everything that a person wrote stays."
)

OPTIONS = (
    option("folders FOLDER", "folders with recordings in or below them", type=Path, nargs="+"),
    option(
        "-o --output STUDY.study.csv",
        "study file to write, or to add to",
        type=Path,
        required=True,
    ),
    option(
        "--pattern PATTERN",
        "factors in the folders' names below FOLDER, for example subject/condition/repetition or "
        "{subject}/{condition}_{day}; * stands for a part without a meaning",
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Look for recordings and write the list."""
    check_name(args.output)
    check_output(args.output)
    pattern = None if args.pattern is None else Pattern(args.pattern)
    with watched("Listing", "Nothing was written.") as (report, stopped):
        made = create_study(
            args.output, args.folders, pattern, on_progress=report, cancelled=stopped
        )
    say_findings(made.findings)
    study = made.study
    facts = {
        "study": study.path,
        "recordings": len(study.rows),
        "projects": sum(bool(row.project) for row in study.rows),
        "added": list(made.added),
        "moved": list(made.moved),
        "factors": list(study.factors),
    }
    rows = [
        ("recordings", str(len(study.rows))),
        ("with a project", str(facts["projects"])),
        ("added now", str(len(made.added))),
        ("moved", str(len(made.moved))),
        ("factors", ", ".join(study.factors) or "none"),
    ]
    put_result(facts, Table(f"Study {study.path}", ("what", ">value"), rows), as_json=args.json)
    return OK
