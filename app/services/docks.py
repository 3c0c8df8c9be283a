"""What stands in the window: the views, the panels around them, and workspaces of panels."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

from PySide6.QtCore import QByteArray, QEvent, QObject, QSettings, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QDockWidget, QMainWindow, QStackedWidget, QTabBar, QWidget

from ..session.messages import Message, stored_text
from ..widgets.camera.camera_grid import CameraGrid
from ..widgets.forms.message import BarsBelow
from ..widgets.forms.numbers import WholeNumberField
from ..widgets.scene.scene_view import SceneView
from ..widgets.style.building import hbox, holder, label, vbox
from ..widgets.timeline.timeline_view import TimelineView
from .failures import Notifier
from .focus import FocusWalk, is_in_front


def stored_bytes(settings: QSettings, key: str) -> QByteArray | None:
    """State of a widget's arrangement from the last start, if there is one."""
    value = settings.value(key)
    return value if isinstance(value, QByteArray) else None


LAYOUT_VERSION, LAYOUT_KEY = 11, "workspaces/{}/state"
LEAST_WIDTH, LEAST_HEIGHT = 0.45, 0.35
"""Shares of the window that are left to the pictures, however large the panels were."""

_ACROSS, _DOWN = Qt.Orientation.Horizontal, Qt.Orientation.Vertical


@dataclass(frozen=True)
class Workspace:
    """A named arrangement of panels."""

    name: str  # as it is stored and given to `--workspace`
    title: str
    tip: str
    icon: str
    side: tuple[tuple[str, ...], ...]
    """Panels at the right, from top to bottom; those in one tuple share a place as tabs."""
    bottom: tuple[str, ...]  # panels over the whole width below the views, from top to bottom
    side_share: float  # width of the panels at the right, as a share of the window
    bottom_shares: tuple[float, ...]  # heights of the panels below, as shares of the window
    side_heights: tuple[int, ...]  # relative heights of the panels at the right
    tall_side: bool = False
    """Whether the panels at the right go down to the lower end of the window."""
    why_not: Callable[[], str] = field(default=str, compare=False)
    """Why it has nothing to show now, as a sentence; empty where it has."""
    middle: str = ""  # name of the page in the middle, see `Docks.add_page`; empty for the views
    no_panels: Callable[[], str] = field(default=str, compare=False)
    """Why its panels have nothing to show, so that its page stands alone; empty where they have."""


def _clear(window: QMainWindow, docks: Collection[QDockWidget]) -> None:
    """Take all panels away; Qt keeps their places, and brings those back that were shown.

    Their tabs go only where the layout hears of both steps: otherwise they stay over what comes
    next.
    """
    for step in (QDockWidget.hide, window.removeDockWidget):
        for dock in docks:
            step(dock)
        if layout := window.layout():
            layout.activate()


def _stack(
    window: QMainWindow,
    docks: Mapping[str, QDockWidget],
    area: Qt.DockWidgetArea,
    groups: Sequence[tuple[str, ...]],
) -> None:
    """Put panels below each other in an area; those of one group share a place as tabs."""
    for place, (first, *_) in enumerate(groups):
        if place:
            window.splitDockWidget(docks[groups[place - 1][0]], docks[first], _DOWN)
        else:
            window.addDockWidget(area, docks[first])
        docks[first].show()
    for first, *behind in groups:  # nothing can be put below tabs
        for name in behind:
            window.tabifyDockWidget(docks[first], docks[name])
            docks[name].show()
        docks[first].raise_()


def _resize(
    window: QMainWindow, sizes: Mapping[QDockWidget, float], orientation: Qt.Orientation
) -> None:
    window.resizeDocks(list(sizes), [max(round(each), 1) for each in sizes.values()], orientation)
    if layout := window.layout():
        layout.activate()


_CORNER = Qt.Corner.BottomRightCorner
_USUAL = ("track", "annotate")  # workspaces that are shown first, where they have something to show


class Transport(QWidget):
    """A field for the frame's number with the recording's length and the time beside it."""

    def __init__(self) -> None:
        super().__init__()
        self.number = WholeNumberField(
            accessibleName="Frame", toolTip="Frame number, counted from 0", minimumWidth=56,
            keyboardTracking=False, buttonSymbols=WholeNumberField.ButtonSymbols.NoButtons,
            alignment=Qt.AlignmentFlag.AlignRight, focusPolicy=Qt.FocusPolicy.ClickFocus,
        )  # fmt: skip
        self._length = label("", "muted", wraps=False)
        name = label("Frame", wraps=False)
        self.setLayout(hbox(name, self.number, self._length, margins=(4, 0, 4, 0)))
        self._fps, self._count = 1.0, 0
        self.number.editingFinished.connect(self.number.clearFocus)
        self.set_range(0, 1.0)

    def set_range(self, count: int, fps: float) -> None:
        self._count, self._fps = count, fps
        with QSignalBlocker(self.number):
            self.number.setRange(0, max(count - 1, 0))
        self.setEnabled(count > 0)
        self._write()

    def set_frame(self, frame: int) -> None:
        with QSignalBlocker(self.number):
            self.number.setValue(frame)
        self._write()

    def type_frame(self) -> None:
        self.number.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.number.selectAll()

    def _write(self) -> None:
        minutes, rest = divmod(self.number.value() / self._fps, 60.0)
        time = f"{int(minutes)}:{rest:05.2f}" if minutes else f"{rest:.2f} s"
        self._length.setText(f"of 0 – {self._count - 1}   {time}" if self._count else "–")


class Docks(QObject):
    """Panels by name, the workspaces that arrange them, and the parts that all features share.

    `host` holds the panels, `settings` keep how a person has arranged them; `workspace_changed` is
    called with the name of another workspace that is shown.
    """

    left = Signal()  # A workspace without a recording was closed by the person

    def __init__(
        self,
        host: QMainWindow,
        settings: QSettings,
        notifier: Notifier,
        views: CameraGrid,
        scene: SceneView,
        workspace_changed: Callable[[str], None],
    ) -> None:
        super().__init__(host)
        self._workspace_changed = workspace_changed
        self._host, self._settings, self._notifier = host, settings, notifier
        self._docks: dict[str, QDockWidget] = {}
        self._workspaces: dict[str, Workspace] = {}
        self._shown: Workspace | None = None
        self.is_alone = False  # whether a workspace is shown without panels, while nothing is open
        self._before: QByteArray | None = None
        self.redraw, self.views, self.scene = views.redraw, views, scene
        self.timeline, self.transport = TimelineView(), Transport()
        self.focus = FocusWalk(host, self.views, self._docks)
        self.middle = QStackedWidget()
        self.dialog_parent: QWidget = self.middle
        self.middle.addWidget(self.views)
        self._pages: dict[str, QWidget] = {"": self.views}
        host.setCentralWidget(self.middle)
        self.below_views = BarsBelow(self.middle).column
        """Bars below the views or the page in the middle, which leave them room."""
        self.add("scene", "3-D scene", self.scene)
        self.timeline_column = vbox((self.timeline, 1), spacing=0)
        dock = self.add("timeline", "Timeline", holder(self.timeline_column), titled=False)
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
        now, space = self._shown, self._workspaces.get(name)
        if now is None or self.is_shown(panel) or panel in (*now.bottom, *chain(*now.side)):
            return
        if space is not None and not space.why_not():
            self.show_workspace(name)

    def hide_all(self) -> None:
        for dock in self._docks.values():
            dock.hide()

    def make_room(self, name: str, share: float) -> None:
        """Let a panel's column go down to the lower end, and give the panel so much of it."""
        if self._before is None and self.is_shown(name):
            self._before = self._host.saveState()
            self._host.setCorner(_CORNER, Qt.DockWidgetArea.RightDockWidgetArea)
            self._host.resizeDocks(
                [self._docks[name]], [round(share * self.middle.height())], _DOWN
            )

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
            state = stored_bytes(self._settings, LAYOUT_KEY.format(space.name))
            if state is not None:
                _clear(self._host, self._docks.values())
            if state is None or not self._host.restoreState(state, LAYOUT_VERSION):
                self.arrange()
            else:
                self.leave_room()
        self._workspace_changed(self.workspace)

    def show_named(self, name: str) -> None:
        """Show a workspace by its name; one that has nothing to show says why."""
        space = self._workspaces[name.strip().lower()]
        if why_not := space.why_not():
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
        self._workspace_changed(self.workspace)

    def close_alone(self) -> None:
        if self.is_alone:
            self.left.emit()

    def reset(self) -> None:
        if self._shown is not None and not self.is_alone:
            self._settings.remove(LAYOUT_KEY.format(self._shown.name))
            self.arrange()

    def arrange(self) -> None:
        """Put the panels of this workspace where they are by default, for now."""
        space = self._shown
        if space is None or self.is_alone:
            return
        host, docks, area = self._host, self._docks, Qt.DockWidgetArea
        _clear(host, docks.values())
        corner = area.RightDockWidgetArea if space.tall_side else area.BottomDockWidgetArea
        host.setCorner(_CORNER, corner)
        _stack(host, docks, area.RightDockWidgetArea, space.side)
        _stack(host, docks, area.BottomDockWidgetArea, [(name,) for name in space.bottom])
        # heights at the right are those of a window without anything else
        side = zip(space.side, space.side_heights, strict=True)
        below = zip(space.bottom, space.bottom_shares, strict=True)
        whole, wide = sum(space.side_heights), space.side_share
        shares = [(docks[names[0]], wide, height / whole) for names, height in side]
        shares += [(docks[name], 1.0, share) for name, share in below]
        _resize(host, {dock: share * host.width() for dock, share, _ in shares}, _ACROSS)
        _resize(host, {dock: share * host.height() for dock, _, share in shares}, _DOWN)
        self.leave_room()

    def leave_room(self) -> None:
        """Make panels smaller that leave too little of the window to the pictures."""
        window = self._host
        width, height, pictures = window.width(), window.height(), self.middle.size()
        there = [dock for dock in self._docks.values() if is_in_front(dock)]
        there = [dock for dock in there if not dock.isHidden() and not dock.isFloating()]
        sides = Qt.DockWidgetArea.LeftDockWidgetArea | Qt.DockWidgetArea.RightDockWidgetArea
        beside = [dock for dock in there if window.dockWidgetArea(dock) & sides]
        too_wide = (width - pictures.width()) / ((1.0 - LEAST_WIDTH) * width)
        too_high = (height - pictures.height()) / ((1.0 - LEAST_HEIGHT) * height)
        if too_wide > 1.0:
            _resize(window, {dock: dock.width() / too_wide for dock in beside}, _ACROSS)
        if too_high > 1.0:
            below = [dock for dock in there if dock not in beside]
            _resize(window, {dock: dock.height() / too_high for dock in below}, _DOWN)
        for tabs in window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            tabs.setVisible(tabs.count() > 0)  # Qt leaves some hidden that it uses again
            tabs.installEventFilter(self)

    def eventFilter(self, _tabs: QObject, event: QEvent) -> bool:
        return event.type() == QEvent.Type.Wheel  # it would bring another panel to the front

    def _keep(self) -> None:
        alone, self.is_alone = self.is_alone, False
        if self._shown is not None and not alone:
            self.give_room_back()
            state = self._host.saveState(LAYOUT_VERSION)
            self._settings.setValue(LAYOUT_KEY.format(self._shown.name), state)
