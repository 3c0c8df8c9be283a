"""Commands that take edits back and make them again, and say who makes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.actions import Command
from ...shell.reasons import no_edit

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Edit"


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menu Edit."""

    def said(verb: str, words: str) -> str:
        return f"{verb}: {words}" if words else verb

    def nothing(words: str, verb: str) -> str:
        return no_edit(w) or ("" if words else f"There is no edit to {verb}.")

    return [
        Command(
            "undo", _MENU, "Undo", "Take the last edit back and show where it was; works without "
            "limit, also for edits of earlier days.", w.project.undo, "Ctrl+Z", "undo",
            lambda: nothing(w.project.to_undo(), "undo"),
            says=lambda: said("Undo", w.project.to_undo()),
        ),
        Command(
            "redo", _MENU, "Redo", "Make the edit again that was taken back last.",
            w.project.redo, "Ctrl+Shift+Z", "redo",
            lambda: nothing(w.project.to_redo(), "redo"),
            says=lambda: said("Redo", w.project.to_redo()),
        ),
        Command(
            "annotator", _MENU, "Who annotates …", "Say whose name edits are signed with.",
            w.projects.ask_annotator, icon="settings", section=True,
        ),
    ]  # fmt: skip
