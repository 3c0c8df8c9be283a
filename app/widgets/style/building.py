"""Layouts and small widgets that panels are built from, in one expression each."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QCompleter,
    QHBoxLayout,
    QLabel,
    QLayout,
    QMenu,
    QProgressBar,
    QScrollArea,
    QSizePolicy,
    QSplitter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from .theme import icon_named


def shortened(name: str, most: int) -> str:
    """A name of at most so many letters; those at both ends tell names apart best."""
    if len(name) <= most:
        return name
    behind = (most - 1) // 2
    return f"{name[: most - 1 - behind]}…{name[-behind:]}"


def allow(button: QWidget, why_not: str, tip: str = "") -> None:
    """Enable a button, or disable it and say why; the tip says what it does."""
    button.setEnabled(not why_not)
    before = f"{tip}. " if tip else ""
    button.setToolTip(f"{before}Unavailable: {why_not}" if why_not else tip)


class ElidedLabel(QLabel):
    """Muted words on one line, whatever their length."""

    def __init__(self, words: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = ""  # all words, also those that are cut
        self.setProperty("role", "muted")
        self.setMinimumWidth(40)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.set_words(words)

    def set_words(self, words: str) -> None:
        self.words = words
        self.setToolTip(words)
        self.setAccessibleName(words)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        room = self.contentsRect().width() - 2 * self.margin()
        self.setText(self.fontMetrics().elidedText(self.words, Qt.TextElideMode.ElideRight, room))


class Raised(QWidget):
    """A strip (role ``bar``) or ``box`` with a coloured edge, see the style sheet's ``edge``."""

    def __init__(self, role: str) -> None:
        super().__init__()
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setProperty("role", role)


Margins: TypeAlias = tuple[int, int, int, int]
Item: TypeAlias = QWidget | QLayout | tuple[QWidget | QLayout, int] | None
"""A widget or layout, alone or with its stretch; None is room that stretches."""

_Box = TypeVar("_Box", bound=QBoxLayout)
_Widget = TypeVar("_Widget", bound=QWidget)


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


def holder(layout: QLayout) -> QWidget:
    """A widget for a layout, where one is needed to scroll, hide or stack it."""
    widget = QWidget()
    widget.setLayout(layout)
    return widget


def splitter(way: Qt.Orientation, *parts: tuple[QWidget, int]) -> QSplitter:
    """Widgets with their stretches and handles between them; none can be closed."""
    split = QSplitter(way, childrenCollapsible=False)
    for place, (part, stretch) in enumerate(parts):
        split.addWidget(part)
        split.setStretchFactor(place, stretch)
    return split


def named(widget: _Widget, name: str = "", tip: str = "") -> _Widget:
    """A widget with what a screen reader calls it, and a tip."""
    widget.setAccessibleName(name)
    widget.setToolTip(tip)
    return widget


def label(
    text: str = "",
    role: str = "",
    *,
    wraps: bool = True,
    margins: Margins = (0, 0, 0, 0),
    align: Qt.AlignmentFlag = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter,
    copied: bool = False,
) -> QLabel:
    """Text in the look that the style sheet has for `role`, such as ``muted`` or ``heading``.

    If it can be `copied`, the mouse selects it.
    """
    result = QLabel(text, wordWrap=wraps, alignment=align)
    result.setContentsMargins(*margins)
    if role:
        result.setProperty("role", role)
    if copied:
        result.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    return result


def show_text(shown: QLabel, text: str) -> None:
    """Write in a label; it is hidden while there is nothing to say."""
    shown.setText(text)
    shown.setVisible(bool(text))


def parameter_links(names: Sequence[str]) -> str:
    """Links to parameters that something points to, as rich text; empty without any."""
    links = (f"<a href='{name}'>{name.replace('_', ' ')}</a>" for name in names)
    return f"Parameters: {', '.join(links)}" if names else ""


def label_of(field: QWidget, text: str) -> QLabel:
    """The label of a field whose key leads to the field, also where that is within a layout."""
    result = label(text, wraps=False)
    result.setBuddy(field)
    return result


def empty_label(text: str) -> QLabel:
    """What stands at the top of an empty panel and says what fills it."""
    return label(text, "muted", margins=(10, 10, 10, 10), align=Qt.AlignmentFlag.AlignTop)


def tool_button(
    tip: str, icon: str = "", text: str = "", role: str = "",
    do: Callable[[], object] | None = None,
) -> QToolButton:  # fmt: skip
    """Make a flat button; its text, if any, stands beside the icon."""
    button = QToolButton(autoRaise=True)
    if do is not None:
        button.clicked.connect(lambda: do())
    button.setToolTip(tip)
    button.setText(text)
    if not text:
        button.setAccessibleName(tip)
    if role:
        button.setProperty("role", role)
    if icon:
        button.setIcon(icon_named(icon))
    if icon and text:
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    return button


def action_button(
    action: QAction, style: Qt.ToolButtonStyle = Qt.ToolButtonStyle.ToolButtonIconOnly
) -> QToolButton:
    """Make a button of a command, with its icon or text."""
    button = QToolButton(toolButtonStyle=style)
    button.setDefaultAction(action)
    return button


def offer(row: QHBoxLayout, actions: Iterable[QAction]) -> None:
    """Put a button with its text into a row for each of these commands."""
    for action in actions:
        row.addWidget(action_button(action, Qt.ToolButtonStyle.ToolButtonTextOnly))
    row.addStretch(1)


def menu_of(button: QToolButton) -> QMenu:
    """Make the menu that a button opens at once."""
    menu = QMenu(button)
    menu.setToolTipsVisible(True)
    button.setMenu(menu)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    return menu


class Choice(QComboBox):
    """A list to choose from; the wheel scrolls what it stands in, and never changes it."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()


def choice(
    name: str,
    options: Iterable[tuple[str, str]] = (),
    tip: str = "",
    chosen: Callable[[Any], object] | None = None,
) -> QComboBox:
    """Make a list of keys with what a person reads; `chosen` is called with the key chosen."""
    box = named(Choice(), name, tip or name)
    for key, text in options:
        box.addItem(text, key)
    if chosen is not None:
        box.activated.connect(lambda: chosen(box.currentData()))
    return box


def searchable(box: QComboBox) -> QComboBox:
    """Let a person find an option by typing any part of it."""
    box.setEditable(True)
    box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
    if completer := box.completer():
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCompletionMode(QCompleter.CompletionMode.PopupCompletion)
    return box


def thin_progress() -> QProgressBar:
    """Make a bar of a few pixels, without text."""
    bar = QProgressBar(textVisible=False)
    bar.setMaximumHeight(4)
    return bar


def scrolled(inside: QWidget, name: str) -> QScrollArea:
    """Make an area without a frame that scrolls up and down only."""
    area = QScrollArea(widgetResizable=True)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setAccessibleName(name)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setWidget(inside)
    return area
