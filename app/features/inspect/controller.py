"""The panel of a frame's inside in the window: what it shows, and what its commands mean."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtWidgets import QFileDialog

from stereotrack_core.errors import InputError
from stereotrack_core.interop.trace_file import TRACE_SUFFIXES, write_trace

from ...context import Context
from ...services.actions import ActionRegistry
from ...widgets.plots.inside_panel import InsidePanel, StepName
from .presenter import InsidePresenter

_SHARE = 0.68
"""Share of its column that the panel gets while a frame is looked into."""

_WAITING = "Measuring the points of this frame and recording the tracker's step …"
_FILTERS = "Cross-covariance of the iteration (*.csv);;All numbers of the step (*.npz)"


class InspectController(QObject):
    """Connects the panel with the presenter."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        session = context.session
        self.panel = InsidePanel()
        context.docks.add("inside", "Inspect step", self.panel)
        self.inside = InsidePresenter(session)
        self.inside.changed.connect(self.show)
        self.inside.message.connect(context.notifier.show)
        self.panel.step_chosen.connect(self.inside.go)
        context.docks.workspace_changed.connect(self._on_workspace)
        session.leaving.connect(self.inside.leave)
        session.closing.connect(self.inside.close)
        context.tasks.watch(self.inside.settled)

    def offer(self, actions: ActionRegistry) -> None:
        """Put the commands into the panel."""
        names = ("inside_previous", "inside_next", "inside_export", "look_inside")
        self.panel.set_actions(
            [actions.action(name) for name in names], actions.key_words(names[-1])
        )

    # ---- what commands do

    def toggle(self) -> None:
        """Look inside the frame that is shown, or show the run again."""
        if self.inside.looking:
            self.inside.leave()
            return
        self._session.document.pause()
        self._raise_panel()
        self.inside.look()

    def step(self, by: int) -> None:
        """Go so many steps on."""
        self.inside.move(by)

    def iterate(self) -> None:
        """Show the next step inside the frame that comes next; after the last one, track it."""
        session = self._session
        frame = session.tracker.hold_before_next()
        if frame is None:
            return
        here = self.inside.looking and self.inside.live and session.document.frame == frame
        if not here:
            session.document.visit(frame)
            self.inside.look()
        elif self.inside.at_end:
            session.track.go_on(1)
        else:
            self.inside.move(1)

    def why_no_step(self, by: int) -> str:
        """Why there is no further step; empty where there is one."""
        known = self.inside.known
        if known is None:
            return "No step trace is shown. Choose Inspect step first."
        if 0 <= self.inside.index + by < len(known.steps):
            return ""
        return "This is the last stage." if by > 0 else "This is the first stage."

    def ask_for_file(self) -> None:
        """Ask where the numbers of the frame shall go."""
        known = self.inside.known
        if known is None:
            return
        name = f"frame-{known.trace.frame}-inside.csv"
        chosen, _ = QFileDialog.getSaveFileName(
            self._context.docks.dialog_parent, "Export step trace", name, _FILTERS
        )
        if chosen:
            self.export(Path(chosen))

    def export(self, path: Path) -> None:
        """Write the cross-covariance of the iteration that is shown, or all numbers."""
        known, step = self.inside.known, self.inside.step
        if known is None or step is None:
            return
        path = path if path.suffix.lower() in TRACE_SUFFIXES else path.with_name(f"{path.name}.csv")
        try:
            write_trace(path, known.trace, max(step.correction, 0))
        except InputError as error:
            self._context.notifier.error(error)
        else:
            self._context.notifier.say(f"Saved to {path}.", 6000)

    # ---- following

    @Slot()
    def show(self) -> None:
        """Show what the presenter knows."""
        self._context.view_state.draw(self.inside.drawing)
        inside, panel = self.inside, self.panel
        known, content = inside.known, inside.content()
        if known is None or content is None:
            panel.show_nothing(_WAITING if inside.looking else "")
        else:
            names = tuple(StepName(step.title, step.heading) for step in known.steps)
            panel.show_steps(names, inside.index)
            elsewhere = known.question.frame != self._session.document.frame
            panel.show_content(content, known.words, busy=inside.busy and elsewhere)
        if not inside.looking:
            self._context.docks.give_room_back()
        self._context.actions.refresh_soon()

    def _raise_panel(self) -> None:
        """Bring the panel to the front, and make room for it."""
        self._context.docks.bring_up("inside")
        QTimer.singleShot(0, self, self._make_room)

    @Slot()
    def _make_room(self) -> None:
        if self.inside.looking:
            self._context.docks.make_room("inside", _SHARE)

    @Slot()
    def _on_workspace(self) -> None:
        if self.inside.looking and self._context.docks.workspace:
            self._make_room()
