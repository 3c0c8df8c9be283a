"""Data files of the program, and its line icons tinted by the palette."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from PySide6.QtCore import QByteArray, QObject, QRectF, Qt
from PySide6.QtGui import (
    QAction,
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
    colours = QGuiApplication.palette()
    result = QIcon()
    for mode, group in (
        (QIcon.Mode.Normal, QPalette.ColorGroup.Active),
        (QIcon.Mode.Disabled, QPalette.ColorGroup.Disabled),
    ):
        for pixmap in _drawn(name, colours.color(group, QPalette.ColorRole.ButtonText).name()):
            result.addPixmap(pixmap, mode)
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


def _drawn(name: str, colour: str) -> list[QPixmap]:
    """Draw an icon in all sizes, or find it among those that were drawn before."""
    kept = {size: QPixmap() for size in _SIZES}
    if all(QPixmapCache.find(f"{name}/{colour}/{size}", kept[size]) for size in _SIZES):
        return list(kept.values())
    drawing = QSvgRenderer(QByteArray(_drawing(name).replace("currentColor", colour).encode()))
    for size in _SIZES:
        kept[size] = _pixmap(drawing, size)
        QPixmapCache.insert(f"{name}/{colour}/{size}", kept[size])
    return list(kept.values())


def _pixmap(drawing: QSvgRenderer, size: int) -> QPixmap:
    pixmap = QPixmap(size, size)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    drawing.render(painter, QRectF(0, 0, size, size))
    painter.end()
    return pixmap
