"""Toolbars, and commands about workspaces, panels, theme, help and the window itself."""

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import QApplication, QMainWindow, QToolBar, QToolButton, QWidget

from ..context import Context
from ..services.actions import Command, Menu
from ..session.changes import Part
from ..session.view_state import CLICK_OVERLAYS
from ..widgets.forms.message import MessageBar
from ..widgets.style.theme import THEME_NAMES, ThemeName, apply_theme, chosen_theme, icon_named
from .dialogs import CommandPalette, ShortcutEditor, ask_for_picture, show_about
from .help import Help

MENUS = ("&File", "&Edit", "&View", "&Go", "&Annotate", "&Track", "T&une", "&Review")
"""Menus that features fill, in their order; those of the shell come behind."""

_MENU = "&Window"


def commands(
    context: Context, window: QMainWindow, messages: MessageBar, guide: Help
) -> list[Command]:
    """Commands of the menus Window and Help, and the last ones of the menu File."""
    return [
        *_workspaces(context),
        *_panels(context),
        *_themes(context),
        *_help_and_file(context, window, messages, guide),
    ]


def _workspaces(context: Context) -> list[Command]:
    docks, command = context.docks, Menu(f"{_MENU}/Workspace", context.session.no_recording).command

    spaces = [
        command(
            f"workspace_{space.name}", space.title, space.tip,
            partial(docks.show_workspace, space.name), f"Alt+{number}", space.icon,
            why_not=space.why_not, checked=lambda name=space.name: docks.workspace == name,
        )
        for number, space in enumerate(docks.workspaces, start=1)
    ]  # fmt: skip
    reset = command(
        "workspace_reset", "Reset workspace", "Restore the default layout of the panels.",
        docks.reset, icon="reset", section=True,
    )  # fmt: skip
    return [*spaces, reset]


def _panels(context: Context) -> list[Command]:
    docks, command = context.docks, Menu(f"{_MENU}/Panel", context.session.no_recording).command
    return [
        command(
            f"panel_{name}", title, f"Show or hide the {title} panel.",
            partial(docks.toggle, name), checked=partial(docks.is_shown, name),
        )
        for name, title in docks.titles().items()
    ] + [
        Command("next_panel", _MENU, "Next panel",
                "Move the keyboard focus to the next panel or view.",
                partial(docks.focus.walk, 1), "F6", section=True),
        Command("previous_panel", _MENU, "Previous panel",
                "Move the keyboard focus to the previous panel.",
                partial(docks.focus.walk, -1), "Shift+F6"),
    ]  # fmt: skip


def _themes(context: Context) -> list[Command]:
    def choose(name: ThemeName) -> None:
        app = QApplication.instance()
        if isinstance(app, QApplication):
            apply_theme(app, name)
            context.settings.setValue("theme", name)
            context.session.instant.tell_soon()

    return [
        Menu(f"{_MENU}/Theme").command(
            f"theme_{name}", name.capitalize(),
            "Follow the system theme." if name == "system" else f"Use the {name} theme.",
            partial(choose, name), icon="theme", checked=lambda name=name: chosen_theme() == name,
        )
        for name in THEME_NAMES
    ]  # fmt: skip


def _help_and_file(
    context: Context, window: QMainWindow, messages: MessageBar, guide: Help
) -> list[Command]:
    book = context.actions
    command, file = Menu("&Help").command, Menu("&File").command
    return [
        command("help", "Help on this panel", "Open the user guide at the panel under the cursor, "
                "or at the one with the focus.", guide.show_for_panel, "F1", "help"),
        command("guide", "User guide", "Show the contents of the user guide.",
                guide.open, "Ctrl+F1"),
        command("palette", "Command palette …", "Search all commands.",
                lambda: CommandPalette(book, window).open(), "Ctrl+K", "palette-of-commands",
                section=True),
        command("shortcuts", "Shortcuts …", "Change the keyboard shortcuts of commands.",
                lambda: ShortcutEditor(book, window).open(), "Ctrl+Alt+K", "settings"),
        command("close_message", "Dismiss message", "Dismiss the message below the views.",
                messages.dismiss, "Esc", "close",
                why_not=lambda: "" if messages.message else "No message is shown."),
        command("about", "About stereotrack", "Version, and the location of the log file.",
                partial(show_about, window), icon="info"),
        file("picture", "Save screenshot …", "Save the window as a PNG image.",
             partial(ask_for_picture, window, context.notifier), "Ctrl+Shift+P", "picture"),
        file("quit", "Quit", "Stop all tasks and close the window.",  # after the command returns
             lambda: QTimer.singleShot(0, window.close), "Ctrl+Q", "close", section=True),
    ]  # fmt: skip


_ICON = QSize(20, 20)
_GO = ("first", "previous", "play", "next", "last")
_TRACK = (
    *("run", "pause", "step", "look_inside", "run_here", "stop", ""),
    *("overlay_points", "overlay_correspondences"),
)
_ANNOTATE = ("undo", "redo", "accept_frame", "", *(f"overlay_{name}" for name in CLICK_OVERLAYS))
_VIEWS = (
    *("overlay_outline", "overlay_reference", ""),
    *("arrange_grid", "arrange_one-and-more", "arrange_single", "keep_person", "loupe"),
)


_WORDS = {"run": "Run", "accept_frame": "Accept"}  # written beside the icons of the main actions


class Toolbars:
    """Workspaces, playback, tracker or annotation, and views."""

    def __init__(self, window: QMainWindow, context: Context) -> None:
        self._window, self._context = window, context
        spaces = [f"workspace_{space.name}" for space in context.docks.workspaces]
        self.workspaces = self._bar("Workspaces", spaces, words=True)
        self.play = self._bar("Playback", _GO, widget=context.docks.transport)
        self.track = self._bar("Tracker", _TRACK)
        self.annotate = self._bar("Annotation", _ANNOTATE)
        self.view = self._bar("Views", _VIEWS)
        context.session.changes.watch(Part.WORKSPACE, self.follow)
        self.follow()

    def follow(self) -> None:
        """Show what the workspace needs; nothing while nothing is open."""
        docks = self._context.docks
        shown = bool(docks.workspace) and not docks.is_alone
        annotating = docks.workspace == "annotate"
        for bar in (self.workspaces, self.play, self.view):
            bar.setVisible(shown)
        self.annotate.setVisible(shown and annotating)
        self.track.setVisible(shown and not annotating)

    def _bar(
        self, name: str, actions: Sequence[str], *, words: bool = False,
        widget: QWidget | None = None,
    ) -> QToolBar:  # fmt: skip
        """Add a toolbar with these actions (an empty name separates), with words or icons."""
        bar = QToolBar(name, self._window)
        bar.setObjectName(f"toolbar {name}")
        bar.setMovable(False)
        bar.setFloatable(False)
        bar.setIconSize(_ICON)
        style = Qt.ToolButtonStyle
        bar.setToolButtonStyle(style.ToolButtonTextOnly if words else style.ToolButtonIconOnly)
        for name in actions:
            if not name:
                bar.addSeparator()
                continue
            action = self._context.actions.action(name)
            bar.addAction(action)
            button = bar.widgetForAction(action)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            if name in _WORDS and isinstance(button, QToolButton):
                action.setIconText(_WORDS[name])
                button.setToolButtonStyle(style.ToolButtonTextBesideIcon)
        if widget is not None:
            bar.addWidget(widget)
        if more := bar.findChild(QToolButton, "qt_toolbar_ext_button"):
            more.setToolTip("Show the commands that there is no room for")
            more.setAccessibleName(f"More of the toolbar {bar.windowTitle()}")
            more.setIcon(icon_named("more"))
        bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._window.addToolBar(bar)
        return bar
