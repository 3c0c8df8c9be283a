"""Boxes to tick, by which cameras are left out and used again."""

from collections.abc import Collection, Sequence
from functools import partial

from PySide6.QtGui import QAction, QIcon, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QGridLayout, QSizePolicy, QWidget

from ..style.building import hbox, label, shortened, vbox
from ..style.theme import icon_named


class CameraBoxes(QWidget):
    """A box to tick for each camera that counts, in as many columns as there is room for."""

    def __init__(self) -> None:
        super().__init__()
        self.boxes: dict[QCheckBox, QAction] = {}
        self._doubtful: Collection[str] = ()
        self._doubt = ""
        self._placed: tuple[list[QCheckBox], int] = [], 0
        # as wide as the panel is, however many columns there are: it may become narrower
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._grid = QGridLayout()
        self._grid.setHorizontalSpacing(12)
        self._grid.setVerticalSpacing(2)
        caption = label("Cameras that count", "muted", margins=(6, 0, 6, 0))
        self.setLayout(vbox(caption, hbox(self._grid, None), margins=(0, 2, 0, 2), spacing=2))

    def add(self, actions: Sequence[QAction]) -> None:
        """Add boxes of commands ``Use N``, which switch whether a camera counts."""
        for action in actions:
            box = QCheckBox(self)
            self.boxes[box] = action
            box.clicked.connect(action.trigger)
            action.changed.connect(partial(self._show, box, action))

    def mark(self, doubtful: Collection[str], words: str) -> None:
        """Say of cameras, as people call them, that they disagree with the others."""
        if (self._doubtful, self._doubt) != (doubtful, words):
            self._doubtful, self._doubt = doubtful, words
            for box, action in self.boxes.items():
                self._show(box, action)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._lay_out()

    def _show(self, box: QCheckBox, action: QAction) -> None:
        name, tip = action.text().removeprefix("Use "), action.toolTip()
        doubtful = name in self._doubtful
        box.setText(shortened(name, 10))
        box.setChecked(action.isChecked())
        box.setEnabled(action.isEnabled())
        box.setIcon(icon_named("warning") if doubtful else QIcon())
        box.setToolTip(f"{self._doubt}. {tip}" if doubtful else tip)
        box.setVisible(action.isVisible())
        self._lay_out()

    def _lay_out(self) -> None:
        """Place the boxes; where they stay in their places, a frame step has no time for it."""
        shown = [box for box in self.boxes if not box.isHidden()]
        widest = self._grid.horizontalSpacing()
        widest += max(map(_width_with_icon, shown), default=0)
        columns = max(self.width() // widest, 1)
        if self._placed == (shown, columns):
            return
        self._placed = shown, columns
        for place, box in enumerate(shown):
            self._grid.addWidget(box, *divmod(place, columns))
        self.setVisible(bool(shown))


def _width_with_icon(box: QCheckBox) -> int:
    """Pixels, also without an icon: columns stay as many when it comes and goes."""
    icon = box.iconSize().width() + 4 if box.icon().isNull() else 0
    return box.sizeHint().width() + icon
