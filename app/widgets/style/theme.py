"""The workbench's look: tokens of the dark and the light theme, and how Qt is told of them."""

import tomllib
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from string import Template
from typing import Literal, TypeAlias

from PySide6.QtCore import QByteArray, QEvent, QRect, QSize, Qt
from PySide6.QtGui import (
    QColor,
    QGuiApplication,
    QIcon,
    QIconEngine,
    QPainter,
    QPalette,
    QPixmap,
    QPixmapCache,
)
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QApplication, QWidget

_APP = Path(__file__).resolve().parents[2]


@cache
def data_folder(name: str) -> Path:
    """Folder of data files: ``resources``, or the pages of the user guide in ``docs``.

    An installed wheel carries them inside this package; in a checkout they stand at the top level,
    beside ``app``. FileNotFoundError means that the installation is damaged.
    """
    for folder in (_APP / name, _APP.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"{_APP / name} is missing: reinstall stereotrack")


@cache
def resource_path(*parts: str) -> Path:
    """Path of one data file, such as ``resource_path("icons", "play.svg")``."""
    path = data_folder("resources").joinpath(*parts)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing: reinstall stereotrack")
    return path


class _Drawing(QIconEngine):
    """A drawing in the colour that the palette has for text on buttons when it is painted."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name, self._path = name, resource_path("icons", f"{name}.svg")

    def clone(self) -> QIconEngine:
        return _Drawing(self._name)

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        ratio = painter.device().devicePixelRatioF()
        painter.drawPixmap(rect, self.pixmap(rect.size() * ratio, mode, state))

    def pixmap(self, size: QSize, mode: QIcon.Mode, _state: QIcon.State) -> QPixmap:
        groups = QPalette.ColorGroup
        group = groups.Disabled if mode == QIcon.Mode.Disabled else groups.Active
        colour = QGuiApplication.palette().color(group, QPalette.ColorRole.ButtonText).name()
        key, found = f"{self._name}/{colour}/{size.width()}/{size.height()}", QPixmap()
        if QPixmapCache.find(key, found):
            return found
        text = self._path.read_text(encoding="utf-8").replace("currentColor", colour)
        drawing = QSvgRenderer(QByteArray(text.encode()))
        drawing.setAspectRatioMode(Qt.AspectRatioMode.KeepAspectRatio)
        result = drawn_pixmap(size.width(), size.height(), drawing.render)
        QPixmapCache.insert(key, result)
        return result


def icon_named(name: str) -> QIcon:
    """Icon in the palette's colours, sharp in every size; it changes with the theme."""
    return QIcon(_Drawing(name))


def drawn_pixmap(
    width: int, height: int, draw: Callable[[QPainter], object], ratio: float = 1.0
) -> QPixmap:
    """A transparent picture with a drawing, `ratio` pixels for a device-independent one."""
    pixmap = QPixmap(round(width * ratio), round(height * ratio))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    draw(painter)
    painter.end()
    return pixmap


ThemeName: TypeAlias = Literal["dark", "light", "system"]
THEME_NAMES: tuple[ThemeName, ...] = ("dark", "light", "system")

_SHOWN = "stereotrack_theme"
_CHOSEN = "stereotrack_theme_choice"


@dataclass(frozen=True)
class Theme:
    """Design tokens: colours as #rrggbb, lengths in device-independent pixels."""

    name: str
    window: str
    base: str
    raised: str
    hover: str
    border: str
    """`window`, `base`, `raised`, `hover` and `border`: surfaces, from the window over fields to
    what lies above it."""
    text: str
    muted: str
    disabled: str  # `text`, `muted` and `disabled`: writing in falling importance
    accent: str
    accent_text: str
    selection: str
    """`accent`, `accent_text` and `selection`: what is chosen; violet, because the other hues are
    limbs."""
    playhead: str  # the instant that is shown, in plots and lanes
    error: str
    warning: str
    good: str  # `error`, `warning` and `good`: verdicts
    plot_background: str
    plot_grid: str
    scene_top: str
    scene_bottom: str
    scene_grid: str
    """`scene_top`, `scene_bottom` and `scene_grid`: gradient and floor of the 3-D scene."""
    reference: str  # lines of the reference, which differ by style from what was tracked
    gap_small: int = 4
    gap: int = 8
    radius: int = 4  # `gap_small`, `gap` and `radius`: distances between and inside widgets

    @property
    def is_dark(self) -> bool:
        """Whether writing is brighter than what it stands on."""
        return self.name == "dark"


class Dressed(QWidget):
    """A widget that takes its colours from the theme again whenever that changes."""

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _dress(self) -> None:
        """Take the colours of :func:`current_theme`."""


def set_look(widget: QWidget, name: str, value: object) -> None:
    """Give a widget a property that the style sheet tells looks by, such as ``role``."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)


@cache
def load_theme(name: str) -> Theme:
    """Tokens of ``dark`` or ``light`` from the resources."""
    text = resource_path("themes", f"{name}.toml").read_text(encoding="utf-8")
    return Theme(name=name, **tomllib.loads(text))


def current_theme() -> Theme:
    """Tokens of the theme that is shown; dark where none was applied."""
    app = QApplication.instance()
    return load_theme((app.property(_SHOWN) if app else None) or "dark")


def chosen_theme() -> ThemeName:
    """Tell what was asked for: ``dark``, ``light`` or ``system``."""
    app = QApplication.instance()
    name: ThemeName = (app.property(_CHOSEN) if app else None) or "system"
    return name


def apply_theme(app: QApplication, name: ThemeName) -> None:
    """Give the whole application the theme `name`, now and for windows yet to come.

    Widgets that paint by themselves hear of it as ``QEvent.Type.PaletteChange`` and read
    :func:`current_theme` again.
    """
    hints, shown = app.styleHints(), app.property(_SHOWN)
    if app.property(_CHOSEN) is None:
        hints.colorSchemeChanged.connect(lambda: apply_theme(app, chosen_theme()))
    app.setProperty(_CHOSEN, name)
    scheme = "dark" if hints.colorScheme() == Qt.ColorScheme.Dark else "light"
    theme = load_theme(scheme if name == "system" else name)
    if shown == theme.name:  # a style sheet polishes every widget there is again
        return
    app.setProperty(_SHOWN, theme.name)
    if shown is None:  # later on, the style of a style sheet hides what it is built on
        app.setStyle("Fusion")
    # the other way round widgets that are there already keep the old palette
    app.setPalette(palette(theme))
    sheet = resource_path("themes", "workbench.qss").read_text(encoding="utf-8")
    check = resource_path("themes", f"check-{theme.name}.svg").as_posix()
    app.setStyleSheet(Template(sheet).substitute(asdict(theme), check=check))


def palette(theme: Theme) -> QPalette:
    """Palette of the Fusion style in the theme's colours."""
    role = QPalette.ColorRole
    colours = (
        (theme.window, (role.Window, role.AlternateBase)),
        (theme.base, (role.Base,)),
        (theme.text, (role.WindowText, role.Text, role.ButtonText, role.ToolTipText)),
        (theme.muted, (role.PlaceholderText,)),
        (theme.raised, (role.Button, role.ToolTipBase, role.Midlight)),
        (theme.error, (role.BrightText,)),
        (theme.accent, (role.Highlight, role.Link, role.LinkVisited, role.Accent)),
        (theme.accent_text, (role.HighlightedText,)),
        (theme.hover, (role.Light,)),
        (theme.border, (role.Mid, role.Dark)),
    )
    result = QPalette()
    for colour, keys in colours:
        for key in keys:
            result.setColor(key, QColor(colour))
    result.setColor(role.Shadow, QColor(theme.base if theme.is_dark else theme.border))
    for key in (role.WindowText, role.Text, role.ButtonText, role.HighlightedText):
        result.setColor(QPalette.ColorGroup.Disabled, key, QColor(theme.disabled))
    result.setColor(QPalette.ColorGroup.Disabled, role.Highlight, QColor(theme.border))
    return result
