"""The toolbars: workspaces, playback, tracker, overlays."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QToolBar, QWidget

_ICON = QSize(20, 20)


def add_toolbar(
    window: QMainWindow,
    name: str,
    actions: Sequence[QAction | None],
    *,
    words: bool = False,
    widgets: Sequence[QWidget] = (),
) -> QToolBar:
    """Add a toolbar with actions (None is a separator) and widgets.

    Parameters
    ----------
    words : bool
        Whether the buttons show their names beside the icons.
    """
    bar = QToolBar(name, window)
    bar.setObjectName(f"toolbar {name}")
    bar.setMovable(False)
    bar.setFloatable(False)
    bar.setIconSize(_ICON)
    style = (
        Qt.ToolButtonStyle.ToolButtonTextOnly if words else Qt.ToolButtonStyle.ToolButtonIconOnly
    )
    bar.setToolButtonStyle(style)
    for action in actions:
        if action is None:
            bar.addSeparator()
        else:
            bar.addAction(action)
    for widget in widgets:
        bar.addWidget(widget)
    bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
    window.addToolBar(bar)
    return bar
