"""The title of the 3-D scene with switches for what it shows and where it is seen from."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QToolButton, QWidget

from ..style.building import action_button, hbox, label, tool_button

_ICON = QSize(16, 16)


class SceneBar(QWidget):
    """A row of buttons that stands where a panel has its title.

    Parameters
    ----------
    title : str
    layers : sequence of QAction
        A button each.
    menus : sequence of (str, str, sequence of QAction)
        Text, icon and entries of the menus behind them.
    """

    def __init__(
        self,
        title: str,
        layers: Sequence[QAction],
        menus: Sequence[tuple[str, str, Sequence[QAction]]],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setProperty("role", "title")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        buttons: list[QToolButton] = []
        for action in layers:
            buttons.append(action_button(action))
            buttons[-1].setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        for text, icon, actions in menus:
            buttons.append(tool_button(text, icon, text))
            buttons[-1].setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            menu = QMenu(buttons[-1])
            menu.addActions(list(actions))
            buttons[-1].setMenu(menu)
            buttons[-1].setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        for button in buttons:
            button.setIconSize(_ICON)
            button.setProperty("role", "plain")
        heading = label(title, "muted", wraps=False)
        self.setLayout(hbox(heading, None, *buttons, margins=(8, 1, 4, 1), spacing=1))
