"""Commands about workspaces, panels, theme, help and the window itself."""

from __future__ import annotations

from functools import partial

from PySide6.QtWidgets import QApplication

from ..context import Context
from ..services.actions import Command
from ..widgets.forms.message import MessageBar
from ..widgets.style.theme import THEME_NAMES, ThemeName, apply_theme, chosen_theme
from .dialogs import Dialogs

MENUS = ("&File", "&Edit", "&View", "&Go", "&Annotate", "&Track", "T&une", "&Review")
"""Menus that features fill, in their order; those of the shell come behind."""

_MENU = "&Window"


def commands(context: Context, dialogs: Dialogs, messages: MessageBar) -> list[Command]:
    """Commands of the menus Window and Help, and the last ones of the menu File."""
    return [
        *_workspaces(context),
        *_panels(context),
        *_themes(context),
        *_help(dialogs, messages),
        *_file(dialogs),
    ]


def _workspaces(context: Context) -> list[Command]:
    docks = context.docks
    spaces = [
        Command(
            f"workspace_{space.name}", f"{_MENU}/Workspace", space.title, space.tip,
            partial(docks.show_workspace, space.name), f"Alt+{number}", space.icon, space.why_not,
            lambda name=space.name: docks.workspace == name,  # type: ignore[misc]
        )
        for number, space in enumerate(docks.workspaces, start=1)
    ]  # fmt: skip
    reset = Command(
        "workspace_reset", f"{_MENU}/Workspace", "Reset workspace",
        "Restore the default layout of the panels.", docks.reset, icon="reset",
        why_not=context.session.no_recording, section=True,
    )  # fmt: skip
    return [*spaces, reset]


def _panels(context: Context) -> list[Command]:
    docks = context.docks
    return [
        Command(
            f"panel_{name}", f"{_MENU}/Panel", title, f"Show or hide the {title} panel.",
            partial(docks.toggle, name), why_not=context.session.no_recording,
            checked=partial(docks.is_shown, name),
        )
        for name, title in docks.titles().items()
    ]  # fmt: skip


def _themes(context: Context) -> list[Command]:
    def choose(name: ThemeName) -> None:
        """Change the look, and keep it for next time."""
        app = QApplication.instance()
        if isinstance(app, QApplication):
            apply_theme(app, name)
            context.settings.setValue("theme", name)
            context.session.instant.tell_soon()

    def theme(name: ThemeName) -> Command:
        return Command(
            f"theme_{name}", f"{_MENU}/Theme", name.capitalize(),
            "Follow the system theme." if name == "system" else f"Use the {name} theme.",
            partial(choose, name), icon="theme", checked=lambda: chosen_theme() == name,
        )  # fmt: skip

    return [theme(name) for name in THEME_NAMES]


def _help(dialogs: Dialogs, messages: MessageBar) -> list[Command]:
    return [
        Command(
            "palette", "&Help", "Command palette …", "Search all commands.",
            dialogs.show_palette, "Ctrl+K", "palette-of-commands",
        ),
        Command(
            "shortcuts", "&Help", "Shortcuts …", "Change the keyboard shortcuts of "
            "commands.",
            dialogs.show_shortcuts, "Ctrl+Alt+K", "settings",
        ),
        Command(
            "close_message", "&Help", "Dismiss message", "Dismiss the message above the views.",
            messages.dismiss, "Esc", "close",
            lambda: "" if messages.message is not None else "No message is shown.",
        ),
        Command(
            "about", "&Help", "About stereotrack", "Version, and the location of the log file.",
            dialogs.show_about, icon="info",
        ),
    ]  # fmt: skip


def _file(dialogs: Dialogs) -> list[Command]:
    return [
        Command(
            "picture", "&File", "Save screenshot …", "Save the window as a PNG image.",
            dialogs.ask_for_picture, "Ctrl+Shift+P", "picture",
        ),
        Command(
            "quit", "&File", "Quit", "Stop all tasks and close the window.",
            dialogs.close_later, "Ctrl+Q", "close", section=True,
        ),
    ]  # fmt: skip
