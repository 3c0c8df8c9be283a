"""``stereotrack project``: projects without the window."""

from __future__ import annotations

from stereotrack_core.cli.commands import Command

DESCRIPTION = "Make a project for the annotation of a recording."

SUBCOMMANDS = (Command("create", "a project of a recording folder", "project_create"),)
