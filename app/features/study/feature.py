"""Studies: many recordings in one table, tracked and evaluated together."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from .controller import StudyController


def register(context: Context) -> StudyController:
    """Offer studies."""
    studies = StudyController(context)
    new = Command(
        "new_study", "&File", "New study …",
        "Make a study file (.study.csv): a table of recordings with their subjects and "
        "conditions. Recordings are added in its window.",
        studies.ask_for_new, "Ctrl+Alt+Shift+N", "add", section=True,
    )  # fmt: skip
    command = Command(
        "open_study", "&File", "Open a study …",
        "Show the recordings of a study file (.study.csv) in one table: annotation, runs, errors, "
        "failures and problems. Track, evaluate and export them together.",
        studies.ask_for_study, "Ctrl+Alt+Shift+O", "table",
    )  # fmt: skip
    context.actions.add([new, command])
    return studies
