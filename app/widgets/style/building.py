"""Layouts and small widgets that panels are built from, in one expression each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias, TypeVar

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QCompleter,
    QHBoxLayout,
    QLabel,
    QLayout,
    QProgressBar,
    QScrollArea,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from .theme import set_icon


def shortened(name: str, most: int) -> str:
    """A name of at most so many letters; those at both ends tell names apart best."""
    if len(name) <= most:
        return name
    behind = (most - 1) // 2
    return f"{name[: most - 1 - behind]}…{name[-behind:]}"


class ElidedLabel(QLabel):
    """Muted words on one line, whatever their length."""

    def __init__(self, words: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = ""
        """All words, also those that are cut."""
        self.setProperty("role", "muted")
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.set_words(words)

    def set_words(self, words: str) -> None:
        """Show these words."""
        self.words = words
        self.setToolTip(words)
        self.setAccessibleName(words)
        self._fit()

    def minimumSizeHint(self) -> QSize:
        return QSize(40, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        room = self.contentsRect().width() - 2 * self.margin()
        shown = self.fontMetrics().elidedText(self.words, Qt.TextElideMode.ElideRight, room)
        self.setText(shown)


class Raised(QWidget):
    """A strip (role ``bar``) or ``box`` with a coloured edge, see the style sheet's ``edge``."""

    def __init__(self, role: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setProperty("role", role)


Margins: TypeAlias = tuple[int, int, int, int]
Item: TypeAlias = QWidget | QLayout | tuple[QWidget | QLayout, int] | None
"""A widget or layout, alone or with its stretch; None is room that stretches."""

_Box = TypeVar("_Box", bound=QBoxLayout)


def hbox(*items: Item, margins: Margins = (0, 0, 0, 0), spacing: int | None = None) -> QHBoxLayout:
    """Put widgets and layouts beside each other; without `spacing` as the style has it."""
    return _filled(QHBoxLayout(), items, margins, spacing)


def vbox(*items: Item, margins: Margins = (0, 0, 0, 0), spacing: int | None = None) -> QVBoxLayout:
    """Put widgets and layouts below each other; without `spacing` as the style has it."""
    return _filled(QVBoxLayout(), items, margins, spacing)


def _filled(layout: _Box, items: Iterable[Item], margins: Margins, spacing: int | None) -> _Box:
    layout.setContentsMargins(*margins)
    if spacing is not None:
        layout.setSpacing(spacing)
    for item in items:
        part, stretch = item if isinstance(item, tuple) else (item, 0)
        if part is None:
            layout.addStretch(1)
        elif isinstance(part, QWidget):
            layout.addWidget(part, stretch)
        else:
            layout.addLayout(part, stretch)
    return layout


def label(
    text: str = "", role: str = "", *, wraps: bool = True, margins: Margins = (0, 0, 0, 0)
) -> QLabel:
    """Text in the look that the style sheet has for `role`, such as ``muted`` or ``heading``."""
    result = QLabel(text)
    result.setWordWrap(wraps)
    result.setContentsMargins(*margins)
    if role:
        result.setProperty("role", role)
    return result


def label_of(field: QWidget, text: str) -> QLabel:
    """The label of a field whose key leads to the field, also where that is within a layout."""
    result = label(text, wraps=False)
    result.setBuddy(field)
    return result


def empty_label(text: str) -> QLabel:
    """What stands at the top of an empty panel and says what fills it."""
    result = label(text, "muted", margins=(10, 10, 10, 10))
    result.setAlignment(Qt.AlignmentFlag.AlignTop)
    return result


def tool_button(tip: str, icon: str = "", text: str = "", role: str = "") -> QToolButton:
    """Make a flat button; its text, if any, stands beside the icon."""
    button = QToolButton()
    button.setAutoRaise(True)
    button.setToolTip(tip)
    if text:
        button.setText(text)
    else:
        button.setAccessibleName(tip)
    if role:
        button.setProperty("role", role)
    if icon:
        set_icon(button, icon)
    if icon and text:
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    return button


def action_button(
    action: QAction, style: Qt.ToolButtonStyle = Qt.ToolButtonStyle.ToolButtonIconOnly
) -> QToolButton:
    """Make a button of a command, with its icon or text."""
    button = QToolButton()
    button.setDefaultAction(action)
    button.setToolButtonStyle(style)
    return button


def choice(name: str, options: Iterable[tuple[str, str]] = (), tip: str = "") -> QComboBox:
    """Make a list to choose from, of keys with what a person reads."""
    box = QComboBox()
    box.setAccessibleName(name)
    box.setToolTip(tip or name)
    for key, text in options:
        box.addItem(text, key)
    return box


def searchable(box: QComboBox) -> QComboBox:
    """Let a person find an option by typing any part of it."""
    box.setEditable(True)
    box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
    completer = box.completer()
    if completer is not None:
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCompletionMode(QCompleter.CompletionMode.PopupCompletion)
    return box


def thin_progress() -> QProgressBar:
    """Make a bar of a few pixels, without text."""
    bar = QProgressBar()
    bar.setTextVisible(False)
    bar.setMaximumHeight(4)
    return bar


def scrolled(inside: QWidget, name: str) -> QScrollArea:
    """Make an area without a frame that scrolls up and down only."""
    area = QScrollArea()
    area.setAccessibleName(name)
    area.setWidgetResizable(True)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setWidget(inside)
    return area
