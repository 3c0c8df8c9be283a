"""``stereotrack study``: many recordings with their conditions, tracked and evaluated together."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = (
    "List recordings and their conditions in a study file, see how far they are, track them, and "
    "export all results as one table."
)

SUBCOMMANDS = (
    Command("create", "list the recordings below folders, or add new ones", "studies.create"),
    Command("status", "annotation, runs, errors and problems of every recording", "studies.status"),
    Command("run", "track and evaluate recordings, on this machine or a cluster", "studies.run"),
    Command("export", "write all results as one tidy table", "studies.export"),
)
"""Each of these commands is a module of its own, as the commands themselves."""
