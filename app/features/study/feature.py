"""Studies: many recordings in one table, tracked and evaluated together."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from .controller import StudyController


def register(context: Context) -> StudyController:
    """Offer studies."""
    studies = StudyController(context)
    command = Command(
        "open_study", "&File", "Open a study …",
        "Show the recordings of a study file (.study.csv) in one table: annotation, runs, errors, "
        "failures and problems. Track, evaluate and export them together.",
        studies.ask_for_study, "Ctrl+Alt+Shift+O", "table", section=True,
    )  # fmt: skip
    context.actions.add([command])
    return studies
