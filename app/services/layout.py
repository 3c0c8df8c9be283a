"""Workspaces: which panels each shows, and where; and how a person has left them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from PySide6.QtCore import QByteArray, QSettings, QSize, Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabBar


def stored_bytes(settings: QSettings, key: str) -> QByteArray | None:
    """What a widget says about its arrangement."""
    value = settings.value(key)
    return value if isinstance(value, QByteArray) else None


LAYOUT_VERSION, LAYOUT_KEY = 10, "workspaces/{}/state"
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

    def has(self, panel: str) -> bool:
        return panel in self.bottom or any(panel in names for names in self.side)


def arrange(window: QMainWindow, docks: Mapping[str, QDockWidget], space: Workspace) -> None:
    """Put the panels where the workspace has them by default, with their usual sizes."""
    _clear(window)
    area = Qt.DockWidgetArea
    corner = area.RightDockWidgetArea if space.tall_side else area.BottomDockWidgetArea
    window.setCorner(Qt.Corner.BottomRightCorner, corner)
    _stack(window, docks, area.RightDockWidgetArea, space.side)
    _stack(window, docks, area.BottomDockWidgetArea, [(name,) for name in space.bottom])
    width, height, shares = window.width(), window.height(), _shares(space)
    _resize(window, {docks[name]: share * width for name, (share, _) in shares.items()}, _ACROSS)
    _resize(window, {docks[name]: share * height for name, (_, share) in shares.items()}, _DOWN)


def _clear(window: QMainWindow) -> None:
    """Take all panels away; Qt keeps their places, and brings those back that were shown.

    Their tabs go only where the layout hears of both steps: otherwise they stay over what comes
    next.
    """
    docks = window.findChildren(QDockWidget)
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


def _shares(space: Workspace) -> dict[str, tuple[float, float]]:
    """Width and height of panels by default, as shares of the window.

    Heights at the right are those of a window without anything else.
    """
    heights, whole = space.side_heights, sum(space.side_heights)
    side = zip(space.side, heights, strict=True)
    below = zip(space.bottom, space.bottom_shares, strict=True)
    shares = {names[0]: (space.side_share, height / whole) for names, height in side}
    return shares | {name: (1.0, share) for name, share in below}


def leave_room(window: QMainWindow, docks: Mapping[str, QDockWidget]) -> None:
    """Make panels smaller that leave too little of the window to the pictures."""
    width, height = window.width(), window.height()
    middle, area = window.centralWidget(), Qt.DockWidgetArea
    pictures = middle.size() if middle is not None else QSize()
    there = [dock for dock in docks.values() if is_in_front(dock)]
    there = [dock for dock in there if not dock.isHidden() and not dock.isFloating()]
    sides = area.LeftDockWidgetArea | area.RightDockWidgetArea
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


def is_in_front(dock: QDockWidget) -> bool:
    """Whether a panel that is there is seen: Qt puts those behind it aside, and calls all visible.

    Neither does the visible region tell it: that of a panel full of opaque widgets is empty.
    """
    return dock.isFloating() or dock.geometry().right() >= 0


def _resize(
    window: QMainWindow, sizes: Mapping[QDockWidget, float], orientation: Qt.Orientation
) -> None:
    window.resizeDocks(list(sizes), [max(round(each), 1) for each in sizes.values()], orientation)
    if layout := window.layout():
        layout.activate()


def restore_layout(window: QMainWindow, settings: QSettings, space: Workspace) -> bool:
    """Put the panels where they were kept; False if nothing fitting was."""
    state = stored_bytes(settings, LAYOUT_KEY.format(space.name))
    if state is None:
        return False
    _clear(window)
    return window.restoreState(state, LAYOUT_VERSION)
