"""A window with nothing but the panels of annotation, and what a person does there."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMainWindow, QVBoxLayout, QWidget

from app.features.annotate.actions import add_commands
from app.features.annotate.dialogs import AnnotationDialogs
from app.features.annotate.filling.predicting import PredictionWork
from app.features.annotate.panels import AnnotationPanels
from app.services.actions import ActionRegistry
from app.services.tasks.task import TaskList
from app.session.edits import EditStack
from app.widgets.redraw import RedrawQueue
from app.widgets.timeline.timeline_view import TimelineView

LEFT = Qt.MouseButton.LeftButton


class Stage(QMainWindow):
    """A window with nothing but the panels of annotation."""

    def __init__(self, settings):
        super().__init__()
        self.timeline, self.tasks = TimelineView(), TaskList(self)
        self.edits = EditStack(self)
        self.panels = AnnotationPanels(self.timeline, self.tasks, self.edits, self)
        self.book = ActionRegistry(self, settings, RedrawQueue(self))
        self.dialogs = AnnotationDialogs(self.panels)
        add_commands(self.book, self.panels, self.dialogs, PredictionWork(self.panels))
        self.book.fill(self.menuBar(), ())
        page = QWidget()
        column = QVBoxLayout(page)
        column.addWidget(self.panels.repeat_bar)
        column.addWidget(self.panels.next_panel)
        column.addWidget(self.panels.bar)
        column.addWidget(self.timeline)
        self.setCentralWidget(page)
        self.heard, self.problems = [], []
        self.panels.said.connect(self.heard.append)
        self.panels.message.connect(self.problems.append)
        self.tasks.failed.connect(self.problems.append)
        self.panels.frame_requested.connect(self.go_to)
        self.timeline.frame_requested.connect(self.panels.set_frame)

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
    qtbot.waitUntil(lambda: stage.panels.settled() and not stage.tasks.tasks, timeout=60_000)
