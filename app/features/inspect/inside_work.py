"""The panel of a frame's inside in the window: what it shows, and what its commands mean."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, QTimer, Slot
from PySide6.QtWidgets import QDockWidget, QFileDialog

from stereotrack_core.errors import InputError
from stereotrack_core.interop.trace_file import TRACE_SUFFIXES, write_trace

from ...services.actions import ActionBook
from ...widgets.plots.inside_content import StepName
from .inside import InsidePresenter

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_SHARE = 0.68
"""Share of its column that the panel gets while a frame is looked into."""

_CORNER = Qt.Corner.BottomRightCorner
_WAITING = "Measuring the points of this frame, and going through what the tracker does with them …"
_FILTERS = "Cross-covariance of the iteration (*.csv);;All numbers of the frame (*.npz)"


class InsideWork(QObject):
    """Connects the panel with the presenter."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        self._panel = window.inside_panel
        self._inside: InsidePresenter = window.inside
        self._heights: list[int] = []
        self._column: list[QDockWidget] = []
        self._corner: Qt.DockWidgetArea | None = None
        self._inside.changed.connect(self.show)
        self._inside.message.connect(window.messages.show_message)
        self._panel.step_chosen.connect(self._inside.go)
        window.spaces.leaving.connect(self._give_room_back)
        window.spaces.changed.connect(self._on_workspace)
        window.document.closed.connect(self._inside.leave)
        window.document.opened.connect(self._inside.leave)

    def offer(self, book: ActionBook) -> None:
        """Put the commands into the panel."""
        names = ("inside_previous", "inside_next", "inside_export", "look_inside")
        self._panel.set_actions([book.action(name) for name in names], book.key_words(names[-1]))

    # ---- what commands do

    def toggle(self) -> None:
        """Look inside the frame that is shown, or show the run again."""
        if self._inside.looking:
            self._inside.leave()
            return
        self._w.document.pause()
        self._raise_panel()
        self._inside.look()

    def step(self, by: int) -> None:
        """Go so many steps on."""
        self._inside.move(by)

    def why_no_step(self, by: int) -> str:
        """Why there is no further step; empty where there is one."""
        known = self._inside.known
        if known is None:
            return "Look inside a frame first."
        if 0 <= self._inside.index + by < len(known.steps):
            return ""
        return "This is the last step." if by > 0 else "This is the first step."

    def ask_for_file(self) -> None:
        """Ask where the numbers of the frame shall go."""
        known = self._inside.known
        if known is None:
            return
        name = f"frame-{known.trace.frame}-inside.csv"
        chosen, _ = QFileDialog.getSaveFileName(
            self._w, "Export the inside of the frame", name, _FILTERS
        )
        if chosen:
            self.export(Path(chosen))

    def export(self, path: Path) -> None:
        """Write the cross-covariance of the iteration that is shown, or all numbers."""
        known, step = self._inside.known, self._inside.step
        if known is None or step is None:
            return
        path = path if path.suffix.lower() in TRACE_SUFFIXES else path.with_name(f"{path.name}.csv")
        try:
            write_trace(path, known.trace, max(step.correction, 0))
        except InputError as error:
            self._w.show_error(error)
        else:
            self._w.statusBar().showMessage(f"Written to {path}.", 6000)

    # ---- following

    @Slot()
    def show(self) -> None:
        """Show what the presenter knows."""
        inside, panel = self._inside, self._panel
        known, content = inside.known, inside.content()
        if known is None or content is None:
            panel.show_nothing(_WAITING if inside.looking else "")
        else:
            names = tuple(StepName(step.title, step.heading) for step in known.steps)
            panel.show_steps(names, inside.index)
            elsewhere = known.question.frame != self._w.document.frame
            panel.show_content(content, known.words, busy=inside.busy and elsewhere)
        if not inside.looking:
            self._give_room_back()
        self._w.refresh_soon()

    def _raise_panel(self) -> None:
        """Bring the panel to the front, and make room for it."""
        dock = self._w.docks["inside"]
        if dock.isHidden():
            self._w.spaces.toggle_panel("inside")
        dock.raise_()
        QTimer.singleShot(0, self._make_room)

    @Slot()
    def _make_room(self) -> None:
        """Let the panel's column go down to the lower end, and give the panel most of it."""
        w, dock = self._w, self._w.docks["inside"]
        if not self._inside.looking or self._corner is not None or dock.isHidden():
            return
        self._corner = w.corner(_CORNER)
        self._column = self._panels_of_the_column(dock)
        self._heights = [each.height() for each in self._column]
        w.setCorner(_CORNER, Qt.DockWidgetArea.RightDockWidgetArea)
        QTimer.singleShot(0, self._share_column)

    @Slot()
    def _share_column(self) -> None:
        if len(self._column) == 2:
            whole = sum(each.height() for each in self._column)
            self._resize([round((1.0 - _SHARE) * whole), round(_SHARE * whole)])

    @Slot()
    def _give_room_back(self) -> None:
        if self._corner is not None:
            self._w.setCorner(_CORNER, self._corner)
            if layout := self._w.layout():
                layout.activate()
            self._resize(self._heights)
        self._heights, self._column, self._corner = [], [], None

    def _resize(self, heights: list[int]) -> None:
        self._w.resizeDocks(self._column, heights, Qt.Orientation.Vertical)

    def _panels_of_the_column(self, dock: QDockWidget) -> list[QDockWidget]:
        """The panel above, and that of the frame's inside; none where it floats."""
        behind = self._w.tabifiedDockWidgets(dock)
        above = [
            each
            for each in self._w.docks.values()
            if each is not dock
            and each not in behind
            and each.isVisible()
            and not each.isFloating()
            and each.geometry().left() == dock.geometry().left()
        ]
        return [*above, dock] if not dock.isFloating() else []

    @Slot()
    def _on_workspace(self) -> None:
        if self._inside.looking and self._w.spaces.current is not None:
            self._make_room()
