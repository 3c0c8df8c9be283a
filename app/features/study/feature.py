"""Studies: many recordings or many values at once."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from .controller import StudyController


def register(context: Context) -> StudyController:
    """Offer studies."""
    studies = StudyController(context)
    context.actions.add(
        [
            Command(
                "new_study", "&File", "New study …",
                "Make a study file (.study.toml): recordings with their subjects and conditions, "
                "and the settings that all are tracked with.",
                studies.ask_for_new, "Ctrl+Alt+Shift+N", "add", section=True,
            ),
            Command(
                "open_study", "&File", "Open a study …",
                "Show the recordings of a study file (.study.toml) in one table: annotation, runs, "
                "errors, failures and problems. Track, evaluate and export them together.",
                studies.ask_for_study, "Ctrl+Alt+Shift+O", "table",
            ),
            Command(
                "sweep", "&Track", "Sweep …",
                "Track the open recording with several parameter values and seeds in the "
                "background, and compare the results: a study of one recording.",
                studies.sweep, "Ctrl+Alt+S", "grid", section=True,
                why_not=context.session.no_recording,
            ),
        ]
    )  # fmt: skip
    return studies
