"""How far the annotation is, which lanes are shown, and what can be done with the selection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QPoint, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QSizePolicy, QToolButton, QWidget

from ..style.icons import set_icon
from ..style.theme import current_theme
from .lanes import KIND_WORDS, KINDS, LaneFilter


class ProgressStrip(QWidget):
    """The share of keyframes that is done, as a thin bar."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._share = 0.0
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        return QSize(72, 6)

    def show_share(self, share: float) -> None:
        """Show a share from 0 to 1."""
        self._share = share
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current_theme()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        box = QRectF(self.rect())
        painter.setBrush(QColor(theme.border))
        painter.drawRoundedRect(box, 3, 3)
        if self._share > 0:
            box.setWidth(max(box.width() * self._share, 6.0))
            painter.setBrush(QColor(theme.good if self._share >= 1.0 else theme.accent))
            painter.drawRoundedRect(box, 3, 3)
        painter.end()


class AnnotationBar(QWidget):
    """One row over the timeline."""

    filter_changed = Signal(object)
    """The :class:`~app.widgets.timeline.lanes.LaneFilter` that a person wants."""
    flagged_requested = Signal(bool)
    """Go to the next flagged frame; True: the one before."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._filter = LaneFilter()
        self._lanes: tuple[tuple[str, str], ...] = ()
        self.strip = ProgressStrip()
        self.progress = QLabel()
        self.previous_button = _button("previous-episode", "Previous frame with a flag")
        self.next_button = _button("next-episode", "Next frame with a flag")
        self.previous_button.clicked.connect(lambda: self.flagged_requested.emit(True))
        self.next_button.clicked.connect(lambda: self.flagged_requested.emit(False))
        self.lanes_button = _button("filter", "Choose which lanes are shown")
        self.lanes_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.lanes_button.setText(_with_arrow("Lanes"))
        self.lanes_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.lanes_menu = QMenu(self.lanes_button)
        self.lanes_menu.aboutToShow.connect(self._fill_lanes_menu)
        self.lanes_button.setMenu(self.lanes_menu)
        self.selection_words = QLabel()
        self.selection_words.setProperty("role", "muted")
        self.selection_words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.selection_words.setAlignment(
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        )
        self.selection_button = _button("selection", "Actions on the selected frames")
        self.selection_button.setText(_with_arrow("Selection"))
        self.selection_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.selection_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.selection_menu = QMenu(self.selection_button)
        self.selection_menu.setToolTipsVisible(True)
        self.selection_button.setMenu(self.selection_menu)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 1, 8, 1)
        row.setSpacing(6)
        for widget in (self.strip, self.progress, self.previous_button, self.next_button):
            row.addWidget(widget)
        row.addWidget(self.lanes_button)
        row.addWidget(self.selection_words, 1)
        row.addWidget(self.selection_button)
        self.setAccessibleName("Annotation")
        self.hide()

    def show_progress(self, words: str, share: float, *, flagged: bool) -> None:
        """Say how far the annotation is; `share` is that of the keyframes that are done."""
        self.progress.setText(words)
        self.strip.show_share(share)
        self.previous_button.setEnabled(flagged)
        self.next_button.setEnabled(flagged)

    def show_selection(self, words: str) -> None:
        """Say what commands work on."""
        self.selection_words.setText(words)
        self.selection_words.setToolTip(
            f"{words}\nCommands act on this selection. Drag in the ruler to select frames, "
            "Ctrl+click on names to select landmarks."
        )

    def set_selection_actions(self, actions: Sequence[QAction | None]) -> None:
        """Offer these commands on the selection; None separates."""
        self.selection_menu.clear()
        for action in actions:
            if action is None:
                self.selection_menu.addSeparator()
            else:
                self.selection_menu.addAction(action)

    def show_selection_menu(self, place: QPoint) -> None:
        """Offer the commands on the selection at a place of the screen."""
        self.selection_menu.popup(place)

    # ---- which lanes are shown

    @property
    def filter(self) -> LaneFilter:
        """Which lanes are shown."""
        return self._filter

    def set_filter(self, chosen: LaneFilter) -> None:
        """Show other lanes, without a signal."""
        self._filter = chosen
        words = "Lanes" if chosen == LaneFilter() else "Lanes *"
        self.lanes_button.setText(_with_arrow("Only flagged" if chosen.only_flagged else words))

    def set_lanes(self, lanes: Sequence[tuple[str, str]]) -> None:
        """Offer these lanes, each with what the program and what a person calls it."""
        self._lanes = tuple(lanes)

    def _fill_lanes_menu(self) -> None:
        menu = self.lanes_menu
        menu.clear()
        only = self._add("Only flagged items", checked=self._filter.only_flagged)
        only.toggled.connect(lambda on: self._change(replace(self._filter, only_flagged=on)))
        menu.addSeparator()
        for kind in KINDS:
            action = self._add(KIND_WORDS[kind], checked=kind in self._filter.kinds)
            action.toggled.connect(lambda _on, kind=kind: self._toggle("kinds", kind))
        menu.addSeparator()
        for name, words in self._lanes:
            action = self._add(words, checked=name not in self._filter.hidden)
            action.toggled.connect(lambda _on, name=name: self._toggle("hidden", name))
        menu.addSeparator()
        menu.addAction("Reset", lambda: self._change(LaneFilter()))

    def _add(self, words: str, *, checked: bool) -> QAction:
        action = self.lanes_menu.addAction(words)
        action.setCheckable(True)
        action.setChecked(checked)
        return action

    def _toggle(self, field: str, name: str) -> None:
        names = getattr(self._filter, field) ^ {name}
        self._change(
            replace(self._filter, kinds=names)
            if field == "kinds"
            else replace(self._filter, hidden=names)
        )

    def _change(self, chosen: LaneFilter) -> None:
        if chosen != self._filter:
            self.set_filter(chosen)
            self.filter_changed.emit(chosen)


def _button(icon: str, tip: str) -> QToolButton:
    button = QToolButton()
    button.setAutoRaise(True)
    button.setToolTip(tip)
    button.setAccessibleName(tip)
    button.setProperty("role", "plain")
    set_icon(button, icon)
    return button


def _with_arrow(words: str) -> str:
    return f"{words} ▾"
