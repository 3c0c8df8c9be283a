"""``stereotrack study status``: how far every recording of a study is."""

from __future__ import annotations

from argparse import Namespace

from stereotrack_core.cli.arguments import JSON
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.studies.shared import SELECT, STUDY, say_findings
from stereotrack_core.study.description import read_study, selected
from stereotrack_core.study.status import COLUMNS, row_facts, study_status
from stereotrack_core.study.store import stored_results
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Print a table of all recordings of a study: frames and views, problems, progress of the "
    "annotation, and runs with their errors and failures."
)

OPTIONS = (STUDY, SELECT, JSON)


def run(args: Namespace) -> int:
    """Read all recordings and print."""
    study = read_study(args.study)
    rows, results = selected(study, args.select), stored_results(study.table)
    with watched("Reading", "Nothing was printed.") as (report, stopped):
        status = study_status(study, rows, results, on_progress=report, cancelled=stopped)
    shown = [one for one in COLUMNS if any(one.value(row) is not None for row in status)]
    headings = [one.label if one.name == "views" else f">{one.label}" for one in shown]
    cells = [
        [
            row.row.recording,
            *(row.row.cell(name) for name in study.factors),
            *(column.text(row) for column in shown),
        ]
        for row in status
    ]
    title = f"Study {study.path}: {len(cells)} recordings"
    facts = {"study": study.path, "recordings": [row_facts(row) for row in status]}
    table = Table(title, ("recording", *study.factors, *headings), cells)
    put_result(facts, table, as_json=args.json)
    say_findings(finding for row in status for finding in row.findings)
    return OK
