"""Data files of the program, and its line icons tinted by the palette."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from PySide6.QtCore import QByteArray, QObject, QRectF, Qt
from PySide6.QtGui import (
    QAction,
    QColor,
    QGuiApplication,
    QIcon,
    QPainter,
    QPalette,
    QPixmap,
    QPixmapCache,
)
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QAbstractButton, QApplication

_APP = Path(__file__).resolve().parents[2]


def data_folder(name: str) -> Path:
    """Folder of data files: ``resources``, or the pages of the user guide in ``docs``.

    An installed wheel carries them inside this package; in a checkout they stand at the top level,
    beside ``app``.

    Raises
    ------
    FileNotFoundError
        If neither is there, which means that the installation is damaged.
    """
    for folder in (_APP / name, _APP.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"{_APP / name} is missing: reinstall stereotrack")


def resource_path(*parts: str) -> Path:
    """Path of one data file, such as ``resource_path("icons", "play.svg")``."""
    path = data_folder("resources").joinpath(*parts)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing: reinstall stereotrack")
    return path


_SIZES = (16, 20, 24, 32, 40, 48, 64)
_NAME = "icon_name"


def icon(name: str) -> QIcon:
    """Icon in the palette's colours, sharp from 16 to 64 pixels."""
    drawing = _drawing(name)
    colours = QGuiApplication.palette()
    result = QIcon()
    for mode, group in (
        (QIcon.Mode.Normal, QPalette.ColorGroup.Active),
        (QIcon.Mode.Disabled, QPalette.ColorGroup.Disabled),
    ):
        colour = colours.color(group, QPalette.ColorRole.ButtonText)
        for size in _SIZES:
            result.addPixmap(_drawn(name, drawing, colour, size), mode)
    return result


def set_icon(target: QAction | QAbstractButton, name: str) -> None:
    """Give an action or button an icon that changes with the theme."""
    target.setProperty(_NAME, name)
    target.setIcon(icon(name))


def refresh_icons(app: QApplication) -> None:
    """Tint every icon given by :func:`set_icon` again, after the palette has changed."""
    for window in app.topLevelWidgets():
        found: list[QObject] = [window, *window.findChildren(QObject)]
        for target in found:
            name = target.property(_NAME)
            if name and isinstance(target, QAction | QAbstractButton):
                target.setIcon(icon(name))


@cache
def _drawing(name: str) -> str:
    return resource_path("icons", f"{name}.svg").read_text(encoding="utf-8")


def _drawn(name: str, drawing: str, colour: QColor, size: int) -> QPixmap:
    key = f"stereotrack/{name}/{colour.name()}/{size}"
    kept = QPixmap()
    if QPixmapCache.find(key, kept):
        return kept
    renderer = QSvgRenderer(QByteArray(drawing.replace("currentColor", colour.name()).encode()))
    pixmap = QPixmap(size, size)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    renderer.render(painter, QRectF(0, 0, size, size))
    painter.end()
    QPixmapCache.insert(key, pixmap)
    return pixmap
