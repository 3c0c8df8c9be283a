"""Reports: their command."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Menu
from .controller import ReportController


def register(context: Context) -> ReportController:
    """Offer reports."""
    reports = ReportController(context)

    def why_not() -> str:
        busy = "A report is already being written." if reports.working else ""
        return context.session.no_run() or busy

    report = Menu("&File", why_not).command(
        "report",
        "Report …",
        "Write a report on the active run as a web page or PDF: errors, curves, failures with "
        "images, calibration, parameters, and how to reproduce it.",
        reports.ask_where,
        "Ctrl+Shift+R",
        "export",
    )
    context.actions.add([report])
    return reports
