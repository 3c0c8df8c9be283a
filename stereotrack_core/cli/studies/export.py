"""``stereotrack study export``: all results of a study as one tidy table."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_output, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.studies.shared import SELECT, STUDY, read_status, say_findings
from stereotrack_core.counting import counted
from stereotrack_core.study.file import read_study, selected
from stereotrack_core.study.results import check_results, write_result_table
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Write the results of all runs of a study as one table with a value per row: factors, "
    "recording, run, measure, statistic, unit, value. It has errors, the tracker's own signs, the "
    "number of failures, and the range of motion of every joint angle."
)

OPTIONS = (
    STUDY,
    option(
        "-o --output TABLE",
        "table to write: .csv, or .parquet (needs the extra `parquet`); several names may be given",
        type=Path,
        required=True,
        nargs="+",
    ),
    SELECT,
    JSON,
)


def run(args: Namespace) -> int:
    """Read what has changed and write the tables."""
    study = read_study(args.study)
    for path in args.output:
        check_results(path)
        check_output(path)
    status = read_status(study, selected(study, args.select))
    say_findings(finding for row in status for finding in row.findings)
    without = [row.row.recording for row in status if row.shown is None]
    if without:
        say(f"{counted(len(without), 'recording')} without a run: {', '.join(without)}.")
    rows = [write_result_table(path, study, status) for path in args.output]
    facts = {
        "files": list(args.output),
        "recordings": len(status),
        "without_run": without,
        "runs": sum(not run.facts.problem for row in status for run in row.runs),
        "values": rows[0],
    }
    told = [(key.replace("_", " "), str(facts[key])) for key in ("recordings", "runs", "values")]
    title = f"Results in {', '.join(map(str, args.output))}"
    put_result(facts, Table(title, ("what", ">value"), told), as_json=args.json)
    return OK
