"""``stereotrack calibrate``: calibrations of other tools, and for them."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = "Read calibrations of other tools, and write them for other tools."

SUBCOMMANDS = (
    Command("import", "read a calibration of another tool", "calibration_import"),
    Command("export", "write a calibration for another tool", "calibration_export"),
)
