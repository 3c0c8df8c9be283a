"""What is drawn again is drawn one piece at a time, each once, in the order it was asked for."""

import pytest
from PySide6.QtCore import QCoreApplication, QEvent, QObject
from PySide6.QtWidgets import QApplication, QWidget

from app.widgets.redraw import RedrawQueue


class Drawing(QObject):
    """Writes down what is drawn, and when the window has answered an event."""

    def __init__(self, queue):
        super().__init__()
        self.queue, self.done = queue, []

    def views(self):
        self.done.append("views")
        QApplication.postEvent(self, QEvent(QEvent.Type.User))

    def scene(self):
        self.done.append("scene")

    def fails(self):
        raise ArithmeticError("drawing")

    def customEvent(self, _event):
        self.done.append("event")


@pytest.fixture
def drawing(qapp):
    return Drawing(RedrawQueue())


def drawn(drawing, qtbot):
    qtbot.waitUntil(drawing.queue.settled)
    return drawing.done


def test_events_are_answered_between_pieces(drawing, qtbot):
    drawing.queue.soon(drawing.views)
    drawing.queue.soon(drawing.scene)
    assert not drawing.done
    assert not drawing.queue.settled()
    assert drawn(drawing, qtbot) == ["views", "event", "scene"]


def test_a_piece_asked_for_again_keeps_its_place_and_is_drawn_once(drawing, qtbot):
    for piece in (drawing.scene, drawing.views, drawing.scene):
        drawing.queue.soon(piece)
    assert drawn(drawing, qtbot)[:2] == ["scene", "views"]
    assert drawing.done.count("scene") == 1


def test_what_is_gone_is_not_drawn(drawing, qtbot):
    widget = QWidget()
    drawing.queue.soon(widget.update)
    drawing.queue.soon(drawing.scene)
    widget.deleteLater()
    QCoreApplication.sendPostedEvents(widget, QEvent.Type.DeferredDelete)
    assert drawn(drawing, qtbot) == ["scene"]


def test_a_piece_that_fails_holds_up_nothing(drawing, qtbot):
    with qtbot.captureExceptions() as failures:
        drawing.queue.soon(drawing.fails)
        drawing.queue.soon(drawing.scene)
        assert drawn(drawing, qtbot) == ["scene"]
    assert [failure[0] for failure in failures] == [ArithmeticError]
