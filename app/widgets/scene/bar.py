"""The title of the 3-D scene with switches for what it shows and where it is seen from."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QToolButton, QWidget

from ..style.icons import set_icon

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
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 1, 4, 1)
        row.setSpacing(1)
        heading = QLabel(title, self)
        heading.setProperty("role", "muted")
        row.addWidget(heading)
        row.addStretch(1)
        for action in layers:
            button = self._button()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            row.addWidget(button)
        for text, icon, actions in menus:
            row.addWidget(self._menu_button(text, icon, actions))

    def _button(self) -> QToolButton:
        button = QToolButton(self)
        button.setIconSize(_ICON)
        button.setProperty("role", "plain")
        return button

    def _menu_button(self, text: str, icon: str, actions: Sequence[QAction]) -> QToolButton:
        button = self._button()
        menu = QMenu(button)
        menu.addActions(list(actions))
        button.setMenu(menu)
        button.setText(text)
        button.setToolTip(text)
        button.setAccessibleName(text)
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        set_icon(button, icon)
        return button
