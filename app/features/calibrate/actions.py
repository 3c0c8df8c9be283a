"""Commands of the calibration."""

from __future__ import annotations

from functools import partial

from ...context import Context
from ...services.actions import Command, Menu
from .checking import RecordingChecks
from .controller import CalibrationController
from .panels.page import CalibrationPage
from .saving import why_not_into

_MENU = "&File/&Calibration"


def commands(
    context: Context,
    calibration: CalibrationController,
    page: CalibrationPage,
    checks: RecordingChecks,
) -> list[Command]:
    """Commands of the menu File, Calibration."""

    def in_page() -> str:
        shown = context.docks.workspace == "calibrate"
        return "" if shown else "Open the workspace Calibrate first."

    def why_no_file() -> str:
        return in_page() or calibration.state.why_not("save")

    def why_not_recording() -> str:
        return in_page() or why_not_into(calibration.state)

    command = Menu(_MENU).command
    return [
        command("calibrate", "Calibrate cameras", "Calibrate cameras with pictures of a board, "
                "with or without a recording.", partial(context.docks.show_named, "calibrate"),
                icon="calibrate"),
        command("check_thoroughly", "Check thoroughly", "Measure whether images, clocks, cameras "
                "and reference of the open recording fit each other; takes some seconds to "
                "minutes.", checks.measure, why_not=checks.why_not_measure),
        command("calibrate_save", "Save calibration …", "Write the calibration.toml and a report.",
                page.save.ask, icon="save", why_not=why_no_file, section=True),
        command("calibrate_into", "Save into the recording", "Replace the calibration of the open "
                "recording; the one before is kept beside it.", calibration.save_into_recording,
                why_not=why_not_recording),
    ]  # fmt: skip
