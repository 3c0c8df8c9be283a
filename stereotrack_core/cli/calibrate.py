"""``stereotrack calibrate``: calibrations of other tools, and for them."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = "Read calibrations of other tools, and write them for other tools."

SUBCOMMANDS = (
    Command("import", "read a calibration of another tool", "calibration.import_file"),
    Command("export", "write a calibration for another tool", "calibration.export_file"),
)
"""Each of these commands is a module of its own, as the commands themselves."""
