"""Recordings, projects and stored runs: opening, saving, undo."""

from __future__ import annotations

from ...context import Context
from .actions import commands
from .files import FileController
from .projects import ProjectController


def register(context: Context) -> FileController:
    """Offer files and edits."""
    files = FileController(context)
    context.actions.add(commands(context.session, files, ProjectController(context)))
    return files
