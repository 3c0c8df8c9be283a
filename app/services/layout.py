"""Workspaces: which panels each shows, and where; and how a person has left them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow

from .stored import stored_bytes

_VERSION = 6
_USUAL_HEIGHT = 960


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
    bottom_heights: tuple[int, ...]
    """Heights of the panels below."""
    side_heights: tuple[int, ...]
    """Relative heights of the panels at the right."""
    tall_side: bool = False
    """Whether the panels at the right go down to the lower end of the window."""
    why_not: Callable[[], str] = field(default=str, compare=False)
    """Why it has nothing to show now, as a sentence; empty where it has."""


def arrange(window: QMainWindow, docks: Mapping[str, QDockWidget], space: Workspace) -> None:
    """Put the panels where the workspace has them by default."""
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
    _resize(window, docks, space)


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


def _resize(window: QMainWindow, docks: Mapping[str, QDockWidget], space: Workspace) -> None:
    side = [docks[names[0]] for names in space.side]
    if side:
        width = round(space.side_share * window.width())
        window.resizeDocks(side, [width] * len(side), Qt.Orientation.Horizontal)
        heights = [100 * height for height in space.side_heights]
        window.resizeDocks(side, heights, Qt.Orientation.Vertical)
    bottom = [docks[_together(names)[0]] for names in space.bottom]
    if bottom:
        share = window.height() / _USUAL_HEIGHT
        heights = [round(share * height) for height in space.bottom_heights]
        window.resizeDocks(bottom, heights, Qt.Orientation.Vertical)


def _together(names: str | tuple[str, ...]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names


def save_layout(window: QMainWindow, settings: QSettings, space: Workspace) -> None:
    """Keep how the person has arranged a workspace; apart from all data."""
    settings.setValue(f"workspaces/{space.name}", window.saveState(_VERSION))


def restore_layout(window: QMainWindow, settings: QSettings, space: Workspace) -> bool:
    """Arrange a workspace as it was kept; False where nothing fitting was."""
    state = stored_bytes(settings, f"workspaces/{space.name}")
    if state is None:
        return False
    _clear(window)
    return window.restoreState(state, _VERSION)


def forget_layout(settings: QSettings, space: Workspace) -> None:
    """Go back to the default next time."""
    settings.remove(f"workspaces/{space.name}")
