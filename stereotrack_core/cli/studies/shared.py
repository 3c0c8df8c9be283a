"""What the commands about studies share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from stereotrack_core.cli.arguments import option
from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import watched
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.file import Study, StudyRow
from stereotrack_core.study.status import RowStatus, study_status

STUDY = option("study STUDY.study.csv", "study file", type=Path)
SELECT = option(
    "--select COLUMN=VALUE",
    "only recordings with this value, for example condition=slow; values are separated by commas, "
    "* stands for any letters; if given several times, all must agree",
    action="append",
    default=[],
)


def read_status(study: Study, rows: Sequence[StudyRow]) -> tuple[RowStatus, ...]:
    """The status of rows; what was read is remembered beside the study, also when stopped."""
    cache = StudyCache(study.cache)
    try:
        with watched("Reading", "What was read is remembered.") as (report, stopped):
            return study_status(study, cache, rows, on_progress=report, cancelled=stopped)
    finally:
        save_cache(cache, forget=len(rows) == len(study.rows))


def save_cache(cache: StudyCache, *, forget: bool) -> None:
    """Write what is known; a study on a drive that cannot be written to is read again next time."""
    try:
        cache.save(forget=forget)
    except InputError as error:
        say(f"note: {error} Files are read again next time.")


def say_findings(findings: Iterable[Finding]) -> None:
    """Say what a person should know."""
    for one in findings:
        say(f"{one.severity}: {one.where}: {one.what}. {one.remedy}".strip())
