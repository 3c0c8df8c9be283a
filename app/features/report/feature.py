"""Reports: their command."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from .controller import ReportController


def register(context: Context) -> ReportController:
    """Offer reports."""
    reports = ReportController(context)

    def why_not() -> str:
        return context.session.no_run() or ("A report is being made." if reports.working else "")

    context.actions.add(
        [
            Command(
                "report",
                "&File",
                "Report …",
                "Write a page or a PDF about the active run: errors, curves, episodes with "
                "pictures, calibration, parameters, and how to do it again.",
                reports.ask_where,
                "Ctrl+Shift+R",
                "export",
                why_not,
            )
        ]
    )
    return reports
