"""Workspaces: which panels each shows, and where; and how a person has left them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from PySide6.QtCore import QEvent, QObject, QSettings, QSize, Qt, QTimer, Slot
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabBar

from .stored import stored_bytes, stored_text

_VERSION = 9
LEAST_WIDTH, LEAST_HEIGHT = 0.45, 0.35
"""Shares of the window that are left to the pictures, however large the panels were."""

_ACROSS, _DOWN = Qt.Orientation.Horizontal, Qt.Orientation.Vertical

Shares: TypeAlias = dict[str, tuple[float, float]]
"""Width and height of panels as shares of the window."""


@dataclass(frozen=True)
class Workspace:
    """A named arrangement of panels."""

    name: str
    """As it is stored and given to ``--workspace``."""
    title: str
    tip: str
    icon: str
    side: tuple[tuple[str, ...], ...]
    """Panels at the right, from top to bottom; those in one tuple share a place as tabs."""
    bottom: tuple[str | tuple[str, ...], ...]
    """Panels over the whole width below the views, from top to bottom; those in
    one tuple share a place as tabs."""
    side_share: float
    """Width of the panels at the right, as a share of the window."""
    bottom_shares: tuple[float, ...]
    """Heights of the panels below, as shares of the window."""
    side_heights: tuple[int, ...]
    """Relative heights of the panels at the right."""
    tall_side: bool = False
    """Whether the panels at the right go down to the lower end of the window."""
    why_not: Callable[[], str] = field(default=str, compare=False)
    """Why it has nothing to show now, as a sentence; empty where it has."""
    middle: str = ""
    """Name of the page in the middle, see :meth:`Docks.add_page`; empty for the views."""
    no_panels: Callable[[], str] = field(default=str, compare=False)
    """Why its panels have nothing to show, so that its page stands alone; empty where they have."""

    def has(self, panel: str) -> bool:
        """Whether a panel belongs to it."""
        below = (name for names in self.bottom for name in _together(names))
        return panel in {name for names in self.side for name in names} | {*below}


def arrange(window: QMainWindow, docks: Mapping[str, QDockWidget], space: Workspace) -> Shares:
    """Put the panels where the workspace has them by default; what each shall have."""
    _clear(window)
    area = Qt.DockWidgetArea
    corner = area.RightDockWidgetArea if space.tall_side else area.BottomDockWidgetArea
    window.setCorner(Qt.Corner.BottomRightCorner, corner)
    _arrange_side(window, docks, space)
    previous = None
    for names in space.bottom:
        dock = docks[_together(names)[0]]
        if previous is None:
            window.addDockWidget(Qt.DockWidgetArea.BottomDockWidgetArea, dock)
        else:
            window.splitDockWidget(previous, dock, Qt.Orientation.Vertical)
        dock.show()
        previous = dock
    for first, *behind in map(_together, space.bottom):  # nothing can be put below tabs
        for name in behind:
            window.tabifyDockWidget(docks[first], docks[name])
            docks[name].show()
        docks[first].raise_()
    return _shares(space)


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


def _arrange_side(window: QMainWindow, docks: Mapping[str, QDockWidget], space: Workspace) -> None:
    above = None
    for names in space.side:
        first = docks[names[0]]
        if above is None:
            window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, first)
        else:
            window.splitDockWidget(above, first, Qt.Orientation.Vertical)
        first.show()
        for name in names[1:]:
            window.tabifyDockWidget(first, docks[name])
            docks[name].show()
        first.raise_()
        above = first


def _shares(space: Workspace) -> Shares:
    """Shares by default; heights at the right are those of a window without anything else."""
    heights, whole = space.side_heights, sum(space.side_heights)
    side = {
        names[0]: (space.side_share, height / whole)
        for names, height in zip(space.side, heights, strict=True)
    }
    below = zip(space.bottom, space.bottom_shares, strict=True)
    return side | {_together(names)[0]: (1.0, share) for names, share in below}


def _together(names: str | tuple[str, ...]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names


def shares_of(window: QMainWindow, docks: Mapping[str, QDockWidget]) -> Shares:
    """What the panels around the views have of the window; those behind others have their room."""
    width, height = max(window.width(), 1), max(window.height(), 1)
    return {
        name: (dock.width() / width, dock.height() / height)
        for name, dock in docks.items()
        if _is_placed(dock) and is_in_front(dock)
    }


def share_out(window: QMainWindow, docks: Mapping[str, QDockWidget], shares: Shares) -> None:
    """Give panels their shares of the window, but never the room that the pictures need."""
    width, height = window.width(), window.height()
    placed = {docks[name]: shares[name] for name in shares if _is_placed(docks.get(name))}
    _resize(window, {dock: share * width for dock, (share, _) in placed.items()}, _ACROSS)
    _resize(window, {dock: share * height for dock, (_, share) in placed.items()}, _DOWN)
    middle, area = window.centralWidget(), Qt.DockWidgetArea
    pictures = middle.size() if middle is not None else QSize()
    there = [dock for dock in docks.values() if _is_placed(dock) and is_in_front(dock)]
    beside, below = (
        [dock for dock in there if window.dockWidgetArea(dock) & areas]
        for areas in (
            area.LeftDockWidgetArea | area.RightDockWidgetArea,
            area.TopDockWidgetArea | area.BottomDockWidgetArea,
        )
    )
    too_wide = (width - pictures.width()) / ((1.0 - LEAST_WIDTH) * width)
    too_high = (height - pictures.height()) / ((1.0 - LEAST_HEIGHT) * height)
    if too_wide > 1.0:
        _resize(window, {dock: dock.width() / too_wide for dock in beside}, _ACROSS)
    if too_high > 1.0:
        _resize(window, {dock: dock.height() / too_high for dock in below}, _DOWN)
    for tabs in window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
        tabs.setVisible(tabs.count() > 0)  # Qt leaves some hidden that it uses again


def is_in_front(dock: QDockWidget) -> bool:
    """Whether a panel that is there is seen: Qt puts those behind it aside, and calls all visible.

    Neither does the visible region tell it: that of a panel full of opaque widgets is empty.
    """
    return dock.isFloating() or dock.geometry().right() >= 0


def _is_placed(dock: QDockWidget | None) -> bool:
    return dock is not None and not dock.isHidden() and not dock.isFloating()


def _resize(
    window: QMainWindow, sizes: Mapping[QDockWidget, float], orientation: Qt.Orientation
) -> None:
    window.resizeDocks(list(sizes), [max(round(each), 1) for each in sizes.values()], orientation)
    if layout := window.layout():
        layout.activate()


class PanelShares(QObject):
    """Keeps the panels' shares of a window, as a person has set them, while it is resized."""

    def __init__(self, window: QMainWindow, docks: Mapping[str, QDockWidget]) -> None:
        super().__init__(window)
        self._window, self._docks = window, docks
        self._wanted: Shares = {}
        self._given: Shares = {}
        self._size = window.size()
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self.now)
        window.installEventFilter(self)

    def give(self, shares: Shares) -> None:
        """Share the room out; without shares it stays as it is."""
        share_out(self._window, self._docks, shares)
        self._size, self._given = self._window.size(), shares_of(self._window, self._docks)
        self._wanted = shares or self._given

    @Slot()
    def now(self) -> Shares:
        """The shares as they were set last, be it on a larger window than this."""
        found = shares_of(self._window, self._docks)
        there = found.keys() & self._given.keys()  # others have come up from behind
        moved = any(found[name] != self._given[name] for name in there)
        if self._size == self._window.size() and (moved or not there):
            self._wanted = self._given = found
        return self._wanted

    def watch(self, dock: QDockWidget) -> None:
        """Notice when a person makes a panel larger or smaller."""
        dock.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Resize:
            if watched is self._window:
                self.give(self._wanted)
            else:
                self._soon.start()
        return False


def save_layout(window: QMainWindow, settings: QSettings, space: Workspace, shares: Shares) -> None:
    """Keep how the person has arranged a workspace; apart from all data."""
    settings.setValue(f"workspaces/{space.name}/state", window.saveState(_VERSION))
    settings.setValue(f"workspaces/{space.name}/shares", json.dumps(shares))


def restore_layout(window: QMainWindow, settings: QSettings, space: Workspace) -> Shares | None:
    """Put the panels where they were kept; their shares, or None where nothing fitting was."""
    state = stored_bytes(settings, f"workspaces/{space.name}/state")
    if state is None:
        return None
    _clear(window)
    if not window.restoreState(state, _VERSION):
        return None
    return _shares_in(stored_text(settings, f"workspaces/{space.name}/shares"))


def _shares_in(text: str) -> Shares:
    """Shares that were stored; without those that make no sense."""
    try:
        stored = json.loads(text)
    except ValueError:
        return {}
    pairs = stored.items() if isinstance(stored, dict) else ()
    return {str(name): (pair[0], pair[1]) for name, pair in pairs if _is_share(pair)}


def _is_share(pair: object) -> bool:
    if not (isinstance(pair, list) and len(pair) == 2):
        return False
    return all(isinstance(one, float | int) and 0.0 < one <= 1.0 for one in pair)


def forget_layout(settings: QSettings, space: Workspace) -> None:
    """Go back to the default next time."""
    settings.remove(f"workspaces/{space.name}")
