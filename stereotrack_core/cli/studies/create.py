"""``stereotrack study create``: list recordings in a study file, with the settings of all runs."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_output, option
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.cli.studies.shared import SETTINGS, say_findings, settings_of
from stereotrack_core.study.create import Pattern, with_recordings
from stereotrack_core.study.description import Study, check_name, read_study, write_study
from stereotrack_core.tables import Table

DESCRIPTION = (
    "List all recordings below folders, with their projects, in a text file that can be edited, "
    "with the settings of all runs and the values to try. Other keys of a recording are factors "
    "such as subject or condition; --pattern fills them from the names of the folders. The same "
    "command adds new recordings and changes settings; everything else stays."
)

OPTIONS = (
    option("folders FOLDER", "folders with recordings in or below them", type=Path, nargs="+"),
    option(
        "-o --output STUDY.study.toml",
        "study file to write, or to add to",
        type=Path,
        required=True,
    ),
    option(
        "--pattern PATTERN",
        "factors in the folders' names below FOLDER, for example subject/condition/repetition or "
        "{subject}/{condition}_{day}; * stands for a part without a meaning",
    ),
    *SETTINGS,
    JSON,
)


def run(args: Namespace) -> int:
    """Look for recordings and write the list."""
    path: Path = args.output
    check_name(path)
    check_output(path)
    pattern = None if args.pattern is None else Pattern(args.pattern)
    before = read_study(path) if path.exists() else Study(path)
    before = dataclasses.replace(before, settings=settings_of(args, before.settings))
    with stoppable("Nothing was written.") as stopped:
        listed = with_recordings(before, args.folders, pattern, cancelled=stopped)
    study = listed.study
    write_study(study)
    say_findings(listed.findings)
    facts = {
        "study": study.path,
        "recordings": len(study.rows),
        "projects": sum(bool(row.project) for row in study.rows),
        "added": list(listed.added),
        "factors": list(study.factors),
    }
    rows = [
        ("recordings", str(len(study.rows))),
        ("with a project", str(facts["projects"])),
        ("added now", str(len(listed.added))),
        ("factors", ", ".join(study.factors) or "none"),
    ]
    put_result(facts, Table(f"Study {study.path}", ("what", ">value"), rows), as_json=args.json)
    return OK
