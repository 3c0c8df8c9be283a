"""What stands in the window: the views, the panels around them, and workspaces of panels."""

from collections.abc import Callable

from PySide6.QtCore import QByteArray, QEvent, QObject, QSettings, Qt, Signal
from PySide6.QtWidgets import QDockWidget, QMainWindow, QStackedWidget, QWidget

from ..session.messages import Message
from ..session.surroundings import stored_text
from ..widgets.camera.camera_grid import CameraGrid
from ..widgets.forms.message import BarsOver
from ..widgets.scene.scene_view import SceneView
from ..widgets.style.building import vbox
from ..widgets.timeline.bars import Transport
from ..widgets.timeline.timeline_view import TimelineView
from .failures import Notifier
from .focus import FocusWalk
from .layout import (
    LAYOUT_KEY,
    LAYOUT_VERSION,
    Workspace,
    arrange,
    is_in_front,
    leave_room,
    restore_layout,
)

_CORNER = Qt.Corner.BottomRightCorner
_USUAL = ("track", "annotate")  # workspaces that are shown first, where they have something to show


class Docks(QObject):
    """Panels by name, the workspaces that arrange them, and the parts that all features share.

    `host` holds the panels, `settings` keep how a person has arranged them; `workspace_changed` is
    called when another workspace is shown.
    """

    left = Signal()  # A workspace without a recording was closed by the person

    def __init__(
        self,
        host: QMainWindow,
        settings: QSettings,
        notifier: Notifier,
        views: CameraGrid,
        scene: SceneView,
        workspace_changed: Callable[[], None],
    ) -> None:
        super().__init__(host)
        self._workspace_changed = workspace_changed
        self._host, self._settings, self._notifier = host, settings, notifier
        self._docks: dict[str, QDockWidget] = {}
        self._workspaces: dict[str, Workspace] = {}
        self._shown: Workspace | None = None
        self.is_alone = False
        """Whether a workspace is shown without panels, while nothing is open."""
        self._before: QByteArray | None = None
        host.installEventFilter(self)
        self.redraw, self.views, self.scene = views.redraw, views, scene
        self.timeline, self.transport = TimelineView(), Transport()
        self.focus = FocusWalk(host, self.views, self._docks)
        self.middle = QStackedWidget()
        self.dialog_parent: QWidget = self.middle
        self.middle.addWidget(self.views)
        self._pages: dict[str, QWidget] = {"": self.views}
        host.setCentralWidget(self.middle)
        self._over_views = BarsOver(self.middle)
        self.add("scene", "3-D scene", self.scene)
        both = QWidget()
        self._timeline_column = vbox((self.timeline, 1), spacing=0)
        both.setLayout(self._timeline_column)
        dock = self.add("timeline", "Timeline", both, titled=False)
        # the timeline is the scrubber: it stays where it is
        dock.setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)

    def add(self, name: str, title: str, widget: QWidget, *, titled: bool = True) -> QDockWidget:
        """Add a panel; one that says by itself what it shows needs no title."""
        dock = QDockWidget(title, self._host)
        dock.setObjectName(name)
        for part in (dock, widget):
            part.setAccessibleName(part.accessibleName() or title)
        dock.setWidget(widget)
        if not titled:
            dock.setTitleBarWidget(QWidget())
        self._docks[name] = dock
        return dock

    def lay_over_views(self, bar: QWidget) -> None:
        """Let a bar lie over the lower end of the views, so that it never moves them."""
        self._over_views.column.addWidget(bar)

    def add_above_timeline(self, widget: QWidget) -> None:
        self._timeline_column.insertWidget(0, widget)

    def add_page(self, name: str, page: QWidget) -> None:
        """Add a page that a workspace may have in the middle in place of the views."""
        self._pages[name] = page
        self.middle.addWidget(page)

    def pages(self) -> dict[str, QWidget]:
        return {one.accessibleName(): one for name, one in self._pages.items() if name}

    def dock(self, name: str) -> QDockWidget:
        return self._docks[name]

    def titles(self) -> dict[str, str]:
        return {name: dock.windowTitle() for name, dock in self._docks.items()}

    def is_shown(self, name: str) -> bool:
        """Whether a panel is there, be it behind another one."""
        return not self._docks[name].isHidden()

    def is_seen(self, name: str) -> bool:
        """Whether a panel is on the screen, not behind another one: others need no work."""
        return self._docks[name].isVisible() and is_in_front(self._docks[name])

    def toggle(self, name: str) -> None:
        """Show or hide a panel; one that was never placed comes to the right."""
        if self.is_shown(name):
            self._docks[name].hide()
        else:
            self.bring_up(name)

    def bring_up(self, name: str) -> None:
        dock = self._docks[name]
        if dock.isHidden():
            if self._host.dockWidgetArea(dock) == Qt.DockWidgetArea.NoDockWidgetArea:
                self._host.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
            dock.show()
        dock.raise_()

    def show_workspace_for(self, panel: str, name: str) -> None:
        """Show a workspace for a panel, unless that is here or belongs to the present one."""
        space = self._workspaces.get(name)
        if self._shown is None or self._shown.has(panel) or self.is_shown(panel):
            return
        if space is not None and not space.why_not():
            self.show_workspace(name)

    def hide_all(self) -> None:
        for dock in self._docks.values():
            dock.hide()

    def make_room(self, name: str, share: float) -> None:
        """Let a panel's column go down to the lower end, and give the panel so much of it."""
        dock = self._docks[name]
        if self._before is None and not dock.isHidden():
            self._before = self._host.saveState()
            self._host.setCorner(_CORNER, Qt.DockWidgetArea.RightDockWidgetArea)
            high = round(share * self.middle.height())
            self._host.resizeDocks([dock], [high], Qt.Orientation.Vertical)

    def give_room_back(self) -> None:
        """Take back what :meth:`make_room` did."""
        if self._before is not None:
            self._host.restoreState(self._before)
            self._before = None

    @property
    def workspaces(self) -> tuple[Workspace, ...]:
        return tuple(self._workspaces.values())

    @property
    def workspace(self) -> str:
        """Name of the workspace that is shown; empty while nothing is open."""
        return self._shown.name if self._shown is not None else ""

    def add_workspace(self, space: Workspace) -> None:
        self._workspaces[space.name] = space

    def show_workspace(self, name: str) -> None:
        self._keep()
        space = self._shown = self._workspaces[name]
        self.middle.setCurrentWidget(self._pages[space.middle])
        self.is_alone = bool(space.no_panels())
        if self.is_alone:
            self.hide_all()
        else:
            self._settings.setValue("workspace", space.name)
            if not restore_layout(self._host, self._settings, space):
                arrange(self._host, self._docks, space)
            leave_room(self._host, self._docks)
        self._workspace_changed()

    def show_named(self, name: str) -> None:
        """Show a workspace by its name; one that has nothing to show says why."""
        space = self._workspaces.get(name.strip().lower())
        if space is None:
            remedy = f"Available: {', '.join(self._workspaces)}."
            self._notifier.show(Message("error", f"there is no workspace {name!r}", remedy=remedy))
        elif why_not := space.why_not():
            what = f"The {space.title} workspace has nothing to show"
            self._notifier.show(Message("note", what, remedy=why_not))
        else:
            self.show_workspace(space.name)

    def show_first(self) -> None:
        """Show the workspace that was used last, or a usual one that has something to show."""
        self._shown, self.is_alone = None, False
        last = stored_text(self._settings, "workspace")
        wanted = [self._workspaces[name] for name in (last, *_USUAL) if name in self._workspaces]
        fits = (space for space in wanted if not space.why_not())
        self.show_workspace(next(fits, self.workspaces[0]).name)

    def leave(self) -> None:
        """Show no workspace any more; how it was arranged is kept."""
        self._keep()
        self._shown = None
        self._workspace_changed()

    def close_alone(self) -> None:
        if self.is_alone:
            self.left.emit()

    def reset(self) -> None:
        if self._shown is not None and not self.is_alone:
            self._settings.remove(LAYOUT_KEY.format(self._shown.name))
            self.arrange()

    def arrange(self) -> None:
        """Put the panels of this workspace where they are by default, for now."""
        if self._shown is not None and not self.is_alone:
            arrange(self._host, self._docks, self._shown)
            leave_room(self._host, self._docks)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self._host and event.type() == QEvent.Type.Resize:
            leave_room(self._host, self._docks)
        return False

    def _keep(self) -> None:
        alone, self.is_alone = self.is_alone, False
        if self._shown is not None and not alone:
            self.give_room_back()
            state = self._host.saveState(LAYOUT_VERSION)
            self._settings.setValue(LAYOUT_KEY.format(self._shown.name), state)
