"""Which frames of the project have a click, kept while edits are made."""

from __future__ import annotations

from PySide6.QtCore import QObject, Slot

from stereotrack_core.project.history import Changed

from ....session.project import ProjectPresenter

_MANY = 200
"""Edited frames from which all are read again."""


class ClickedFrames(QObject):
    """Read once, and then followed edit by edit: there may be many clicks."""

    def __init__(self, project: ProjectPresenter) -> None:
        super().__init__(project)
        self._project = project
        self._frames: set[int] | None = None
        project.changed.connect(self._on_edited)
        for signal in (project.opened, project.closed):
            signal.connect(self._forget)

    def frames(self) -> set[int]:
        project = self._project.project
        if project is None:
            return set()
        if self._frames is None:
            self._frames = set(map(int, project.clicks.frames()))
        return self._frames

    def within(self, frames: range) -> bool:
        return not self.frames().isdisjoint(frames)

    @Slot(object)
    def _on_edited(self, changed: Changed) -> None:
        project = self._project.project
        if "click" not in changed.tables:
            return
        edited = set(changed.frames())
        if self._frames is None or project is None or len(edited) > _MANY:
            self._frames = None
        else:
            clicked = {k for k in edited if project.clicks.at(k)}
            self._frames = (self._frames - edited) | clicked

    @Slot()
    def _forget(self) -> None:
        self._frames = None
