"""The toolbars, made from what is registered."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMainWindow, QToolBar, QToolButton, QWidget

from ..context import Context
from ..widgets.camera.click_marks import CLICK_OVERLAYS
from ..widgets.style.icons import set_icon

_ICON = QSize(20, 20)
_GO = ("first", "previous", "play", "next", "last")
_TRACK = (
    *("run", "pause", "step", "iterate", "run_here", "stop", ""),
    *("overlay_points", "overlay_correspondences"),
)
_ANNOTATE = ("undo", "redo", "accept", "", *(f"overlay_{name}" for name in CLICK_OVERLAYS))
_VIEWS = (
    *("overlay_outline", "overlay_reference", ""),
    *("arrange_grid", "arrange_one-and-more", "arrange_single", "keep_person", "loupe"),
)


_WORDS = {"run": "Run", "accept": "Accept"}
"""Written beside the icons of the main actions."""


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
        context.docks.workspace_changed.connect(self.follow)
        self.follow()

    @property
    def all(self) -> tuple[QToolBar, ...]:
        """All toolbars of the window."""
        return (self.workspaces, self.play, self.track, self.annotate, self.view)

    def follow(self) -> None:
        """Show what the workspace needs; nothing while nothing is open."""
        docks = self._context.docks
        workspace = "" if docks.is_alone else docks.workspace
        annotating = workspace == "annotate"
        for bar in self.all:
            fits = {self.annotate: annotating, self.track: not annotating}.get(bar, True)
            bar.setVisible(bool(workspace) and fits)

    def _bar(
        self,
        name: str,
        actions: Sequence[str],
        *,
        words: bool = False,
        widget: QWidget | None = None,
    ) -> QToolBar:
        """Add a toolbar with these actions (an empty name separates), with words or icons."""
        bar = QToolBar(name, self._window)
        bar.setObjectName(f"toolbar {name}")
        bar.setMovable(False)
        bar.setFloatable(False)
        bar.setIconSize(_ICON)
        style = Qt.ToolButtonStyle
        bar.setToolButtonStyle(style.ToolButtonTextOnly if words else style.ToolButtonIconOnly)
        for name in actions:
            self._add(bar, name)
        if widget is not None:
            bar.addWidget(widget)
        more = bar.findChild(QToolButton, "qt_toolbar_ext_button")
        if more is not None:
            more.setToolTip("Show the commands that there is no room for")
            more.setAccessibleName(f"More of the toolbar {bar.windowTitle()}")
            set_icon(more, "more")
        bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._window.addToolBar(bar)
        return bar

    def _add(self, bar: QToolBar, name: str) -> None:
        if not name:
            bar.addSeparator()
            return
        action = self._context.actions.action(name)
        bar.addAction(action)
        button = bar.widgetForAction(action)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        if name in _WORDS and isinstance(button, QToolButton):
            action.setIconText(_WORDS[name])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
