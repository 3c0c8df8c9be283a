"""Which workspace is shown, and which of its panels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QSettings, Qt, Signal

from stereotrack_core.errors import InputError

from ..services.failures import Message
from ..services.stored import stored_text
from .window_menu import why_no_workspace
from .workspaces.layout import (
    WORKSPACES,
    Workspace,
    arrange,
    forget_layout,
    restore_layout,
    save_layout,
    workspace_named,
)

if TYPE_CHECKING:
    from .main_window import MainWindow


class WorkspaceControl(QObject):
    """Arranges the panels, and keeps how the person has arranged them.

    Attributes
    ----------
    current : Workspace or None
        None while nothing is open.

    Signals
    -------
    changed : ()
        Another workspace is shown.
    leaving : ()
        The arrangement is about to be kept: what has moved panels for a while puts them back.
    """

    changed = Signal()
    leaving = Signal()

    def __init__(self, window: MainWindow, settings: QSettings) -> None:
        super().__init__(window)
        self._w = window
        self._settings = settings
        self.current: Workspace | None = None

    def show(self, space: Workspace) -> None:
        """Arrange the panels as a workspace has them, as the person left it."""
        self._keep()
        self.current = space
        self._settings.setValue("workspace", space.name)
        if not restore_layout(self._w, self._settings, space):
            arrange(self._w, self._w.docks, space)
        self._w.follower.look_at(cameras=space.name == "calibrate")
        self._w.instant.tell_soon()
        self._w.refresh_soon()
        self.changed.emit()

    def show_named(self, name: str) -> None:
        """Show a workspace by its name; one that has nothing to show says why."""
        space = workspace_named(name)
        if space is None:
            known = ", ".join(space.name for space in WORKSPACES)
            self._w.show_error(
                InputError(f"there is no workspace {name!r}", remedy=f"Known are: {known}.")
            )
            return
        why_not = why_no_workspace(self._w, space)
        if why_not:
            self._w.messages.show_message(
                Message("note", f"The workspace {space.title} has nothing to show", remedy=why_not)
            )
        else:
            self.show(space)

    def show_first(self) -> None:
        """Show the workspace that was used last, or the first that has something to show."""
        self.current = None
        wanted = workspace_named(stored_text(self._settings, "workspace") or "track")
        for space in (wanted, *WORKSPACES):
            if space is not None and not why_no_workspace(self._w, space):
                self.show(space)
                return
        self.show(WORKSPACES[0])

    def leave(self) -> None:
        """Show no workspace any more; how it was arranged is kept."""
        self._keep()
        self.current = None
        self.changed.emit()

    def reset(self) -> None:
        """Put the panels of this workspace back where they belong."""
        if self.current is not None:
            forget_layout(self._settings, self.current)
            self.arrange()

    def arrange(self) -> None:
        """Put the panels of this workspace where they are by default, for now."""
        if self.current is not None:
            arrange(self._w, self._w.docks, self.current)

    def is_shown(self, space: Workspace) -> bool:
        """Whether this is the workspace that is shown."""
        return self.current is space

    def panel_shown(self, name: str) -> bool:
        """Whether a panel is there, be it behind another one."""
        return not self._w.docks[name].isHidden()

    def toggle_panel(self, name: str) -> None:
        """Show or hide a panel; one that was never placed comes to the right."""
        dock = self._w.docks[name]
        if dock.isHidden():
            if self._w.dockWidgetArea(dock) == Qt.DockWidgetArea.NoDockWidgetArea:
                self._w.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
            dock.show()
            dock.raise_()
        else:
            dock.hide()
        self._w.instant.tell_soon()

    def _keep(self) -> None:
        if self.current is not None:
            self.leaving.emit()
            save_layout(self._w, self._settings, self.current)
