"""The picture below the evidence for a failure is as wide as there is room, at any size."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QObject

from app.widgets.tables.failures_panel import EvidenceView

WIDTH, HEIGHT = 900, 300
GREY = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)


class Resizes(QObject):
    """How often something is resized."""

    def __init__(self, watched):
        super().__init__(watched)
        self.count = 0
        watched.installEventFilter(self)

    def eventFilter(self, _watched, event):
        self.count += int(event.type() == QEvent.Type.Resize)
        return self.count > 20  # nothing shall end a test run by recursion without an end


@pytest.fixture
def view(shown):
    made = shown(EvidenceView(), 300, 200)
    made.show_picture(GREY)
    return made


def test_a_scroll_bar_does_not_come_and_go_without_end(view, qapp):
    resizes = Resizes(view.widget())
    bars = set()
    for height in range(80, 500):
        resizes.count = 0
        view.resize(300, height)
        qapp.processEvents()
        assert resizes.count <= 3, f"at a height of {height}"
        bars.add(view.verticalScrollBar().isVisible())
    assert bars == {True, False}, "sizes with a bar and without one are tried"


@pytest.mark.parametrize("width", [300, 700, 1400])
def test_the_picture_keeps_its_proportions_and_is_not_enlarged(view, qapp, width):
    view.resize(width, 900)
    qapp.processEvents()
    shown = view.picture.grab().toImage()
    painted = [x for x in range(shown.width()) if shown.pixelColor(x, 5).red() == 90]
    room = view.picture.width()
    assert painted[0] == 0
    assert len(painted) == pytest.approx(min(room, WIDTH), abs=1)
    assert view.picture.height() == pytest.approx(min(room, WIDTH) * HEIGHT / WIDTH, abs=1)
