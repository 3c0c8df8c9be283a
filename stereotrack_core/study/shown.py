"""What a table shows of every recording of a study, in a terminal and in the window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stereotrack_core.study.status import RowStatus


@dataclass(frozen=True)
class Column:
    """A column of the table; `value` is what it is sorted by, None where nothing is known."""

    name: str
    label: str
    value: Callable[[RowStatus], float | str | None]
    help: str
    digits: int = 0

    @property
    def is_number(self) -> bool:
        """Whether its cells stand on the right."""
        return self.name not in ("views", "run")


def _error(measure: str, statistic: str) -> Callable[[RowStatus], float | None]:
    def value(row: RowStatus) -> float | None:
        return None if row.shown is None else row.shown.facts.value(measure, statistic)

    return value


def _annotated(row: RowStatus) -> float | None:
    project = row.project
    if project is None or not project.keyframes:
        return None
    return 100.0 * project.done / project.keyframes


def _tracked(row: RowStatus) -> float | None:
    run = row.shown
    return None if run is None or not run.facts.frames else 100.0 * (
        run.facts.tracked / run.facts.frames
    )  # fmt: skip


def _run(row: RowStatus) -> str | None:
    run = row.shown
    if run is None:
        return None
    return f"{run.place.name} (out of date)" if run.outdated else run.place.name


def _problems(row: RowStatus) -> float | None:
    own = sum(one.severity != "note" for one in row.findings)
    return own + (0 if row.recording is None else row.recording.errors + row.recording.warnings)


COLUMNS: tuple[Column, ...] = (
    Column(
        "frames", "frames", lambda row: None if row.recording is None else row.recording.frames,
        "Frame sets of the recording.",
    ),
    Column(
        "views", "views",
        lambda row: None if row.recording is None else " ".join(
            view.split()[0] for view in row.recording.views
        ),
        "Views of the recording.",
    ),
    Column("problems", "problems", _problems, "Errors and warnings about the recording, its "
           "project and its runs."),
    Column("annotated", "annotated %", _annotated, "Share of the keyframes that are done."),
    Column(
        "clicks", "clicks", lambda row: None if row.project is None else row.project.clicks,
        "Clicked landmarks in the project.",
    ),
    Column("runs", "runs", lambda row: len(row.runs), "Runs of the project and of the study."),
    Column(
        "run", "newest run", _run,
        "The run that the following columns are about.",
    ),
    Column("tracked", "tracked %", _tracked, "Share of the run's frames with a pose."),
    Column("torso_position", "torso mm", _error("torso_position", "mean"),
           "Mean error of the torso's position.", 1),
    Column("upper_arms", "upper arms deg", _error("upper_arms", "mean"),
           "Mean angular error of both upper arms.", 1),
    Column("forearms", "forearms deg", _error("forearms", "mean"),
           "Mean angular error of both forearms.", 1),
    Column("lost", "lost %", _error("lost", "share"),
           "Share of arm segments that are more than 45 degrees off.", 1),
    Column(
        "failures", "failures", lambda row: None if row.shown is None else row.shown.failures,
        "Failures by error where there is a reference, else by the run's own signs.",
    ),
)  # fmt: skip
"""Columns between the factors and the findings."""


def text_of(column: Column, row: RowStatus) -> str:
    """A cell; a dash where nothing is known."""
    value = column.value(row)
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.{column.digits}f}"


def messages_of(row: RowStatus) -> list[str]:
    """All that is wrong with a recording, its project and its runs, as sentences."""
    told = [f"{one.severity}: {one.where}: {one.what}. {one.remedy}" for one in row.findings]
    return [*told, *(() if row.recording is None else row.recording.diagnostics)]


def row_facts(row: RowStatus) -> dict[str, Any]:
    """A row for JSON."""
    return {
        "recording": row.row.recording,
        "folder": row.place.folder,
        "project": row.place.project,
        "factors": dict(row.row.factors),
        **{column.name: column.value(row) for column in COLUMNS},
        "messages": messages_of(row),
        "all_runs": [
            {
                "name": run.place.name,
                "kept_in": run.place.kept_in,
                "file": run.place.path,
                "preset": run.facts.preset,
                "changes": run.facts.changes,
                "seed": run.facts.seed,
                "reference": run.facts.reference,
                "failures": run.failures,
                "outdated": list(run.outdated),
            }
            for run in row.runs
        ],
    }
