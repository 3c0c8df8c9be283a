"""Commands about workspaces, panels, theme and help."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ..services.actions import Command
from ..widgets.style.theme import THEME_NAMES, ThemeName, chosen_theme
from .reasons import no_depth, no_recording
from .workspaces.layout import WORKSPACES, Workspace

if TYPE_CHECKING:
    from .main_window import MainWindow

_MENU = "&Window"


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menus Window and Help."""
    return [*_workspaces(w), *_panels(w), *_themes(w), *_help(w)]


def why_no_workspace(w: MainWindow, space: Workspace) -> str:
    """Why a workspace has nothing to show now."""
    return no_depth(w) if space.name in {"track", "review", "tune"} else no_recording(w)


def _workspaces(w: MainWindow) -> list[Command]:
    spaces = [
        Command(
            f"workspace_{space.name}", f"{_MENU}/Workspace", space.title, space.tip,
            partial(w.spaces.show, space), f"Alt+{number}", space.icon,
            partial(why_no_workspace, w, space),
            partial(w.spaces.is_shown, space),
        )
        for number, space in enumerate(WORKSPACES, start=1)
    ]  # fmt: skip
    reset = Command(
        "workspace_reset", f"{_MENU}/Workspace", "Reset this workspace",
        "Put the panels back where they belong.", w.spaces.reset, icon="reset",
        why_not=lambda: no_recording(w), section=True,
    )  # fmt: skip
    return [*spaces, reset]


def _panels(w: MainWindow) -> list[Command]:
    return [
        Command(
            f"panel_{name}", f"{_MENU}/Panel", dock.windowTitle(),
            f"Show or hide the panel {dock.windowTitle()}.",
            partial(w.spaces.toggle_panel, name), why_not=lambda: no_recording(w),
            checked=partial(w.spaces.panel_shown, name),
        )
        for name, dock in w.docks.items()
    ]  # fmt: skip


def _themes(w: MainWindow) -> list[Command]:
    def theme(name: ThemeName) -> Command:
        return Command(
            f"theme_{name}", f"{_MENU}/Theme", name.capitalize(),
            "Follow the system's theme." if name == "system" else f"Use the {name} theme.",
            lambda: w.choose_theme(name), icon="theme", checked=lambda: chosen_theme() == name,
        )  # fmt: skip

    return [theme(name) for name in THEME_NAMES]


def _help(w: MainWindow) -> list[Command]:
    return [
        Command(
            "palette", "&Help", "All commands …", "Search everything that can be done.",
            w.dialogs.show_palette, "Ctrl+K", "palette-of-commands",
        ),
        Command(
            "shortcuts", "&Help", "Change shortcuts …", "Give commands other keys.",
            w.dialogs.show_shortcuts, "Ctrl+Alt+K", "settings",
        ),
        Command(
            "close_message", "&Help", "Close the message", "Close the message above the views.",
            w.messages.dismiss, "Esc", "close",
            lambda: "" if w.messages.message is not None else "No message is shown.",
        ),
        Command(
            "about", "&Help", "About stereotrack", "Version, and where the log is.",
            w.dialogs.show_about, icon="info",
        ),
    ]  # fmt: skip
