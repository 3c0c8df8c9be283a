"""``stereotrack study export``: all results of a study as one tidy table."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_output, check_suffix, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.studies.shared import SELECT, STUDY, say_findings
from stereotrack_core.counting import counted
from stereotrack_core.study.description import read_study, selected
from stereotrack_core.study.export import write_result_table
from stereotrack_core.study.run import plan_study
from stereotrack_core.study.store import stored_results
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Write the results of all runs of a study as one table with a value per row: factors, "
    "recording, run, measure, statistic, unit, value. It has errors, the tracker's own signs, the "
    "number of failures, and the range of motion of every joint angle."
)

OPTIONS = (
    STUDY,
    option("-o --output TABLE.csv", "table to write", type=Path, required=True),
    SELECT,
    JSON,
)


def run(args: Namespace) -> int:
    """Find the results of the study's runs and write the table."""
    study = read_study(args.study)
    check_suffix(args.output, ".csv")
    check_output(args.output)
    rows = selected(study, args.select)
    with watched("Reading", "Nothing was written.") as (report, stopped):
        plan = plan_study(study, rows, on_progress=report, cancelled=stopped)
    say_findings(plan.left_out)
    results = stored_results(study.table)
    done = [job for job in plan.jobs if job.identity in results and results[job.identity].done]
    there = {job.recording for job in done}
    without = [row.recording for row in rows if row.recording not in there]
    if without:
        say(f"{counted(len(without), 'recording')} without a run: {', '.join(without)}.")
    facts = {
        "file": args.output,
        "recordings": len(rows),
        "without_run": without,
        "runs": len(done),
        "values": write_result_table(args.output, study, done, results),
    }
    told = [(key.replace("_", " "), str(facts[key])) for key in ("recordings", "runs", "values")]
    table = Table(f"Results in {args.output}", ("what", ">value"), told)
    put_result(facts, table, as_json=args.json)
    return OK
