"""A window with nothing but the panels of annotation, and what a person does there."""

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMainWindow, QVBoxLayout, QWidget

from app.context import make_context
from app.features.annotate.clicking.controller import ClickController
from app.features.annotate.dialogs import AnnotationDialogs
from app.features.annotate.feature import add_commands
from app.features.annotate.filling.predicting import PredictionWork
from app.features.annotate.panels import AnnotationPanels
from app.widgets.forms.message import MessageBar

LEFT = Qt.MouseButton.LeftButton


class Stage(QMainWindow):
    """A window with nothing but the panels of annotation."""

    def __init__(self, settings):
        super().__init__()
        self.heard, self.problems = [], []
        self.messages = MessageBar()
        self.messages.show_message = self._hear_message
        self.statusBar().messageChanged.connect(lambda words: words and self.heard.append(words))
        self.context = context = make_context(self, self.messages, settings)
        self.timeline, self.tasks = context.docks.timeline, context.tasks
        self.edits, self.book = context.session.edits, context.actions
        self.panels = AnnotationPanels(context, ClickController(context))
        self.dialogs = AnnotationDialogs(self.panels)
        add_commands(self.book, self.panels, self.dialogs, PredictionWork(self.panels))
        self.book.fill(self.menuBar(), ())
        page = QWidget()
        column = QVBoxLayout(page)
        column.addWidget(self.panels.repeat_bar)
        column.addWidget(self.panels.next_panel)
        column.addWidget(self.panels.bar)
        column.addWidget(self.timeline)
        context.docks.middle.addWidget(page)
        context.docks.middle.setCurrentWidget(page)
        context.session.document.visit = self.go_to
        self.timeline.frame_requested.connect(self.panels.set_frame)

    def _hear_message(self, message):
        heard = self.heard if message.severity == "note" else self.problems
        heard.append(message.sentence() if message.severity == "note" else message)

    def go_to(self, frame):
        self.timeline.set_frame(frame)
        self.panels.set_frame(frame)

    def trigger(self, name):
        self.book.refresh()
        action = self.book.action(f"annotate-{name}")
        assert action.isEnabled(), action.toolTip()
        action.trigger()


def at(view, frame, y):
    return QPoint(round(view.scale.x_of(frame + 0.5)), y)


def select(qtbot, stage, first, last):
    """Drag in the ruler."""
    port = stage.timeline.viewport()
    qtbot.mousePress(port, LEFT, pos=at(stage.timeline, first, 10))
    qtbot.mouseMove(port, at(stage.timeline, (first + last) // 2, 10))
    qtbot.mouseMove(port, at(stage.timeline, last, 10))
    qtbot.mouseRelease(port, LEFT, pos=at(stage.timeline, last, 10))


def settled(qtbot, stage):
    qtbot.waitUntil(lambda: stage.panels.settled() and not stage.tasks.tasks)
