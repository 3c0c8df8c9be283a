"""``stereotrack import``: labels, predictions, or videos of which a recording is made."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = (
    "Import labels of another tool or predictions of a detector into a project, or make a "
    "recording of videos."
)

SUBCOMMANDS = (
    Command("labels", "clicks or a trajectory of another tool, into a project", "import_labels"),
    Command("predictions", "keypoints of a 2-D detector, into a project", "import_predictions"),
    Command("recording", "a recording folder of videos or images", "import_recording"),
)
