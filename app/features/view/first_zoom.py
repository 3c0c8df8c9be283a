"""A recording opens with its views zoomed to the person, wherever that moves in it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from PySide6.QtCore import QObject, QPointF, QRectF, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.person import person_pixels
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.person_boxes import Box, person_boxes

from ...context import Context
from ...services.tasks.task import Task

_SETTING = "open_zoomed"
_KEPT = "person_boxes"
"""Name of what the project keeps."""
_MARGIN = 0.12
"""Share of the longer side of a person's box that is left on each side."""


class FirstZoom(QObject):
    """Looks for the person in the background; who has clicked into a view by then is left alone.

    Where it was found once is kept in the project, where there is one.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context = context
        self._looking: Task | None = None
        context.session.project.followed.connect(self._look)
        context.session.closed.connect(self._stop)
        context.docks.views.activated.connect(self._stop)

    def chosen(self) -> bool:
        """Whether recordings open zoomed."""
        return bool(self._context.settings.value(_SETTING, True, type=bool))

    def toggle(self) -> None:
        """Open recordings zoomed, or with whole images."""
        self._context.settings.setValue(_SETTING, not self.chosen())

    @Slot()
    def _look(self) -> None:
        self._stop()
        recording = self._context.session.document.recording
        if recording is None or not self.chosen():
            return
        project = self._context.session.project.project
        kept = _boxes_of({} if project is None else project.view_settings.get(_KEPT, {}))
        if all(view.name in kept for view in recording.views):
            self._zoom(kept)
            return
        self._looking = self._context.tasks.begin(
            "looking for the person", lambda task: _found(task, recording, project), self._show
        )

    @Slot()
    def _stop(self) -> None:
        if self._looking is not None:
            self._looking.cancel()
            self._looking = None

    @Slot(object)
    def _show(self, boxes: dict[str, Box]) -> None:
        if self.sender() is not self._looking:
            return
        self._looking = None
        self._zoom(boxes)
        project = self._context.session.project.project
        if boxes and project is not None and not project.read_only:
            with suppress(InputError):  # nothing is lost: it is looked for again
                project.view_settings.set(_KEPT, boxes)

    def _zoom(self, boxes: Mapping[str, Box]) -> None:
        self._context.docks.views.set_homes({name: _wider(*box) for name, box in boxes.items()})


def _wider(left: float, top: float, right: float, bottom: float) -> QRectF:
    more = _MARGIN * max(right - left, bottom - top)
    return QRectF(QPointF(left, top), QPointF(right, bottom)).adjusted(-more, -more, more, more)


def _boxes_of(kept: Mapping[str, Any]) -> dict[str, Box]:
    """Boxes as they were kept; what somebody else has written there is left out."""
    boxes = {}
    for name, values in kept.items():
        if isinstance(values, list) and all(isinstance(one, int | float) for one in values):
            with suppress(ValueError):
                left, top, right, bottom = values
                if left < right and top < bottom:
                    boxes[name] = (left, top, right, bottom)
    return boxes


def _found(task: Task, recording: Recording, project: Project | None) -> dict[str, Box]:
    try:
        known = person_pixels(recording, project)
        return person_boxes(recording, known, task.token.cancelled)
    except InputError:
        return {}  # what cannot be read is told by who shows it
