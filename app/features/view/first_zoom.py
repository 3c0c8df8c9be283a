"""A recording opens with its views zoomed to the person, wherever that moves in it."""

from PySide6.QtCore import QPointF, QRectF

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.person_boxes import Box, person_boxes

from ...context import Context
from ...session.changes import Part
from ...session.jobs import Job, NewestJob, Task

_SETTING = "open_zoomed"
_MARGIN = 0.12  # share of the longer side of a person's box that is left on each side


class FirstZoom:
    """Looks for the person in the background; who has clicked into a view by then is left alone."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._looking = NewestJob(context.tasks)
        context.session.changes.watch(Part.PROJECT_FOLLOWED, self._look)
        context.session.changes.watch(Part.RECORDING_CLOSED, self._looking.give_up)
        context.docks.views.activated.connect(self._looking.give_up)

    def chosen(self) -> bool:
        return bool(self._context.settings.value(_SETTING, True, type=bool))

    def toggle(self) -> None:
        self._context.settings.setValue(_SETTING, not self.chosen())

    def _look(self) -> None:
        self._looking.give_up()
        recording = self._context.session.document.recording
        if recording is None or not self.chosen():
            return

        def show(boxes: dict[str, Box]) -> None:
            homes = {name: _wider(*box) for name, box in boxes.items()}
            self._context.docks.views.set_homes(homes)

        title = "looking for the person"
        self._looking.run(Job(title, lambda task: _found(task, recording), show))


def _wider(left: float, top: float, right: float, bottom: float) -> QRectF:
    more = _MARGIN * max(right - left, bottom - top)
    return QRectF(QPointF(left, top), QPointF(right, bottom)).adjusted(-more, -more, more, more)


def _found(task: Task, recording: Recording) -> dict[str, Box]:
    try:
        return person_boxes(recording, task.token.cancelled)
    except InputError:
        return {}  # what cannot be read is told by who shows it
