"""The line that says how things are: words, the pixel under the cursor, progress and cancel."""

from __future__ import annotations

from PySide6.QtCore import QObject, Slot
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar, QToolButton

from ..context import Context
from ..widgets.style.icons import set_icon
from .status import status_words


class StatusLine(QObject):
    """Follows the session and the tasks.

    Attributes
    ----------
    state : QLabel
    pixel : QLabel
    progress : QProgressBar
    cancel : QToolButton
    """

    def __init__(self, bar: QStatusBar, context: Context) -> None:
        super().__init__(bar)
        self._context = context
        self.state, self.pixel = QLabel(), QLabel()
        self.state.setContentsMargins(8, 0, 0, 0)
        self.progress = QProgressBar()
        self.progress.setMaximumWidth(160)
        self.progress.setMaximumHeight(14)
        self.progress.setTextVisible(False)
        self.cancel = QToolButton()
        self.cancel.setToolTip("Cancel the work in the background")
        self.cancel.setAutoRaise(True)
        set_icon(self.cancel, "stop")
        bar.addWidget(self.state, 1)
        for widget in (self.pixel, self.progress, self.cancel):
            bar.addPermanentWidget(widget)
        self.progress.hide()
        self.cancel.hide()
        self.cancel.clicked.connect(context.tasks.cancel_all)
        context.docks.views.hovered.connect(self.pixel.setText)
        context.notifier.said.connect(bar.showMessage)
        context.actions.refreshed.connect(self.write)
        for signal in (context.session.opened, context.session.closed):
            signal.connect(self.pixel.clear)

    @Slot()
    def write(self) -> None:
        """Say how things are."""
        session, tasks = self._context.session, self._context.tasks.tasks
        track = session.track
        doing = "; ".join(task.says() for task in tasks)
        words = status_words(session.document, track, session.runs, session.judging, doing)
        drawing = self._context.view_state.drawing
        if drawing is not None and drawing.frame == session.document.frame:
            words = f"inside frame {drawing.frame}: {drawing.words}"
        self.state.setText(words)
        entry = track.entry
        self.cancel.setVisible(bool(tasks))
        self.progress.setVisible(bool(tasks) or entry is not None)
        if tasks:
            share = tasks[0].share
            self.progress.setRange(0, 100 if share else 0)
            self.progress.setValue(round(100 * share))
        elif entry is not None:
            preparing = track.running and not entry.frames
            self.progress.setRange(0, 0 if preparing else len(entry.wanted))
            self.progress.setValue(len(entry.frames))
