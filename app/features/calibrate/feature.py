"""Calibrate: cameras by pictures of a board, and what looks wrong about a recording."""

from __future__ import annotations

from functools import partial

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.changes import RECORDING, Part
from ...widgets.forms.message import Message
from ...widgets.tables.panels import FindingsPanel
from .checking import RecordingChecks
from .controller import CalibrationController
from .panels.page import CalibrationPage
from .saving import why_not_into

_MENU = "&File/&Calibration"


def _commands(context: Context, calibrate: CalibrateController) -> list[Command]:
    calibration, page, checks = calibrate.calibration, calibrate.page, calibrate.checks

    def in_page() -> str:
        shown = context.docks.workspace == "calibrate"
        return "" if shown else "Open the workspace Calibrate first."

    command = Menu(_MENU).command
    return [
        command("calibrate", "Calibrate cameras", "Calibrate cameras with pictures of a board, "
                "with or without a recording.", partial(context.docks.show_named, "calibrate"),
                icon="calibrate"),
        command("check_thoroughly", "Check thoroughly", "Measure whether images, clocks, cameras "
                "and reference of the open recording fit each other; takes some seconds to "
                "minutes.", checks.measure, why_not=checks.why_not_measure),
        command("calibrate_save", "Save calibration …", "Write the calibration.toml and a report.",
                page.axes.ask, icon="save", section=True,
                why_not=lambda: in_page() or calibration.state.why_not_save()),
        command("calibrate_into", "Save into the recording", "Replace the calibration of the open "
                "recording; the one before is kept beside it.", calibration.save_into_recording,
                why_not=lambda: in_page() or why_not_into(calibration.state)),
    ]  # fmt: skip


_FINDINGS = "Recording checks"


class CalibrateController:
    """Shows the cameras and what looks wrong, be it by the files or by what is clicked."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.calibration = CalibrationController(context)
        self.page = CalibrationPage(self.calibration)
        self.checks = RecordingChecks(context, self._show_findings)
        self.findings = FindingsPanel(self.checks.ask)
        context.docks.add_page("calibration", self.page)
        self._dock = context.docks.add("findings", _FINDINGS, self.findings)
        self._told: Message | None = None
        self._told_cameras: tuple[str, ...] = ()
        context.session.changes.watch(RECORDING | Part.FINDINGS, self._show_findings)
        context.session.changes.watch(Part.DOUBTS, self._on_cameras)

    def _show_findings(self) -> None:
        known = self._session.document.findings
        if known is not None:
            known = (*known, *self._session.cameras.findings(), *self.checks.reach)
        self.findings.show_findings(known)
        serious = sum(finding.severity != "note" for finding in known or ())
        self._dock.setWindowTitle(f"{_FINDINGS} ({serious})" if serious else _FINDINGS)

    def _on_cameras(self) -> None:
        """Say which camera contradicts the others, before its clicks are blamed."""
        cameras, notifier = self._session.cameras, self._context.notifier
        found, doubtful = cameras.findings(), cameras.doubtful()
        self._show_findings()
        if doubtful != self._told_cameras:  # and not again while more is clicked
            self._told_cameras = doubtful
            if self._told is not None:
                notifier.take_back(self._told)
            self._told = None
            if found:
                self._told = Message("warning", found[0].what, remedy=found[0].remedy)
                notifier.show(self._told)


def register(context: Context) -> CalibrateController:
    """Offer the workspace Calibrate, its page, its panels and its commands."""
    calibrate = CalibrateController(context)
    loading = "The recording is still loading."
    space = Workspace(
        "calibrate", "Calibrate",
        "Calibrate cameras with pictures of a board; inspect problems of the recording.",
        "calibrate", side=(), bottom=("findings",), side_share=0.0, bottom_shares=(0.22,),
        side_heights=(), middle="calibration", no_panels=context.session.no_recording,
        why_not=lambda: loading if context.session.document.opening else "",
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context, calibrate))
    calibrate.findings.add_action_button(context.actions.action("check_thoroughly"))
    return calibrate
