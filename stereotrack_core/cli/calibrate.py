"""``stereotrack calibrate``: cameras from pictures of a board, their world, other tools' files."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = (
    "Calibrate cameras from pictures of a board, align a calibration to the room, or convert "
    "calibrations from and to other tools."
)

SUBCOMMANDS = (
    Command("intrinsics", "the lens of one camera", "calibration.intrinsics"),
    Command("stereo", "a pair of cameras side by side", "calibration.stereo"),
    Command("world", "all cameras in one world", "calibration.world"),
    Command("align", "z up, y north and the origin on the floor", "calibration.align"),
    Command("import", "read a calibration of another tool", "calibration.import_file"),
    Command("export", "write a calibration for another tool", "calibration.export_file"),
)
"""Each of these commands is a module of its own, as the commands themselves."""
