"""``stereotrack study status``: how far every recording of a study is."""

from __future__ import annotations

from argparse import Namespace

from stereotrack_core.cli.arguments import JSON
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.cli.studies.shared import SELECT, STUDY, read_status, say_findings
from stereotrack_core.study.file import read_study, selected
from stereotrack_core.study.shown import COLUMNS, row_facts, text_of
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Print a table of all recordings of a study: frames and views, problems, progress of the "
    "annotation, runs, and errors and failures of the newest run. Files that have not changed "
    "since the last call are not read again."
)

OPTIONS = (STUDY, SELECT, JSON)


def run(args: Namespace) -> int:
    """Read what has changed and print."""
    study = read_study(args.study)
    status = read_status(study, selected(study, args.select))
    shown = [one for one in COLUMNS if any(one.value(row) is not None for row in status)]
    headings = [f">{one.label}" if one.is_number else one.label for one in shown]
    columns = ("recording", *study.factors, *headings)
    rows = [
        [
            row.row.recording,
            *(row.row.factors.get(name, "") for name in study.factors),
            *(text_of(column, row) for column in shown),
        ]
        for row in status
    ]
    table = Table(f"Study {study.path}: {len(rows)} recordings", columns, rows)
    facts = {"study": study.path, "recordings": [row_facts(row) for row in status]}
    put_result(facts, table, as_json=args.json)
    say_findings(finding for row in status for finding in row.findings)
    return OK
