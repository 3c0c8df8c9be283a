"""What speaks for an episode's causes, in words and bars, and pictures of it beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QImage, QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QFrame, QScrollArea, QSizePolicy, QWidget

from stereotrack_core.arrays import ImageArray

from ..style.building import label, vbox

_NONE = (
    "Select a failure to see the evidence for its cause. Press Enter to go to its worst frame; "
    "Loop failure plays it in a loop."
)
_BAR = 8


class EvidenceView(QScrollArea):
    """A heading, a picture as wide as there is room, and a line for each piece of evidence."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMinimumHeight(80)
        self.heading, self.label = label(_NONE), label()
        for text in (self.heading, self.label):
            text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.label.setTextFormat(Qt.TextFormat.RichText)
        self.picture = ScaledPicture()
        inside = QWidget()
        parts = (self.heading, self.picture, self.label)
        inside.setLayout(vbox(*parts, None, margins=(8, 6, 8, 6), spacing=6))
        self.setWidget(inside)

    def show_words(self, heading: str, evidence: Sequence[tuple[str, float, str, bool]]) -> None:
        """Show what is known of an episode; without a heading nothing is chosen.

        Parameters
        ----------
        heading : str
        evidence : sequence of (str, float, str, bool)
            Cause, strength from 0 to 1, words, and whether it is that of the probable cause.
        """
        self.heading.setText(heading or _NONE)
        lines = []
        for cause, strength, words, probable in evidence:
            full = round(_BAR * min(max(strength, 0.0), 1.0))
            bar = "█" * full + "░" * (_BAR - full)
            name = f"<b>{escape(cause)}</b>" if probable else escape(cause)
            lines.append(
                f"<p style='margin:0 0 2px 0'><span style='font-family:monospace'>{bar}</span> "
                f"{name}: {escape(words)}</p>"
            )
        if heading and not evidence:
            lines.append("<p style='margin:0'>No evidence for a cause.</p>")
        self.label.setText("".join(lines))

    def show_picture(self, pixels: ImageArray | None) -> None:
        """Show a picture (H, W, 3) BGR, or none."""
        self.picture.show_pixels(pixels)


class ScaledPicture(QWidget):
    """A picture in its own proportions, as wide as the widget, never enlarged."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._picture: QPixmap | None = None
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self.setAccessibleName("Before, worst and after")

    @property
    def shown(self) -> QSize:
        """Size of the picture that is shown; empty without one."""
        return self._picture.size() if self._picture is not None else QSize()

    def show_pixels(self, pixels: ImageArray | None) -> None:
        """Show a picture (H, W, 3) BGR, or none."""
        self._picture = None
        if pixels is not None:
            whole = np.ascontiguousarray(pixels)
            height, width = whole.shape[:2]
            image = QImage(whole.data, width, height, 3 * width, QImage.Format.Format_BGR888)
            self._picture = QPixmap.fromImage(image)
        self.updateGeometry()
        self.update()

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        shown = self.shown
        if shown.isEmpty():
            return 0
        return round(shown.height() * min(1.0, width / shown.width()))

    def sizeHint(self) -> QSize:
        return QSize(200, self.heightForWidth(max(self.width(), 1)))

    def paintEvent(self, _event: QPaintEvent) -> None:
        if self._picture is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        share = min(1.0, self.width() / self._picture.width())
        size = self._picture.size() * share
        painter.drawPixmap(QRect(0, 0, size.width(), size.height()), self._picture)
        painter.end()
