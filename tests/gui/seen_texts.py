"""What is wrong with texts and controls that are seen: cut off, or without a word about them."""

from collections.abc import Iterator

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QColorDialog,
    QComboBox,
    QFileDialog,
    QHeaderView,
    QInputDialog,
    QLabel,
    QLineEdit,
    QMessageBox,
    QSlider,
    QStyle,
    QStyleOptionComboBox,
    QTabBar,
    QToolButton,
    QWidget,
)

_SLACK = 2
"""Pixels that are the style's own affair."""
_OF_QT = (QColorDialog, QFileDialog, QInputDialog, QMessageBox)
"""Dialogs that Qt explains."""
_FIELDS = (QComboBox, QLineEdit, QAbstractSpinBox, QSlider)


def faults_of(window: QWidget) -> list[str]:
    """Sentences about what is seen in a window or dialog; empty where nothing is wrong."""
    found: list[str] = []
    if isinstance(window, _OF_QT):
        return found
    for part in window.findChildren(QWidget):
        if part.isVisible() and not part.visibleRegion().isEmpty() and not _is_of_qt(part):
            found += [f"{why}, in {_place(part)}" for why in _faults(part)]
    return list(dict.fromkeys(found))


def _is_of_qt(part: QWidget) -> bool:
    """Whether a control belongs to one of Qt's own, which explains it."""
    inner = isinstance(part.parentWidget(), QAbstractSpinBox | QComboBox | QTabBar)
    return part.objectName().startswith("qt_") or inner


def _faults(part: QWidget) -> Iterator[str]:
    if isinstance(part, QLabel):
        yield from _of_label(part)
    elif isinstance(part, QAbstractButton):
        yield from _of_button(part)
    elif isinstance(part, QComboBox):
        yield from _of_choice(part)
    elif isinstance(part, QTabBar | QHeaderView):
        yield from _of_titles(part)
    if isinstance(part, (QAbstractButton, *_FIELDS)) and not _explained(part):
        name = part.text() if isinstance(part, QAbstractButton) else part.accessibleName()
        yield f"{type(part).__name__} {name!r} has no tooltip"
    if isinstance(part, _FIELDS) and not (part.accessibleName() or _labelled(part)):
        yield f"{type(part).__name__} {part.toolTip()!r} has no name"


def _explained(part: QWidget) -> bool:
    """Whether a tooltip is shown over a control: its own, or that of what it stands in."""
    around: QWidget | None = part
    while around is not None and not around.isWindow():
        if around.toolTip():
            return True
        around = around.parentWidget()
    # in a dialog the words beside a field, and those on a button, say all of it
    told = part.text() if isinstance(part, QAbstractButton) else part.accessibleName()
    return not part.window().inherits("QMainWindow") and bool(told or _labelled(part))


def _labelled(part: QWidget) -> bool:
    return any(one.buddy() is part for one in part.window().findChildren(QLabel))


def _of_label(part: QLabel) -> Iterator[str]:
    if not part.text() or not part.pixmap().isNull() or "Elid" in type(part).__name__:
        return
    wide = part.wordWrap()
    need = part.heightForWidth(part.width()) if wide else part.sizeHint().height()
    if need > part.height() + _SLACK:
        yield f"{part.text()[:60]!r} needs a height of {need}, not {part.height()}"
    if not wide and part.sizeHint().width() > part.width() + _SLACK:
        yield f"{part.text()[:60]!r} needs {part.sizeHint().width()} pixels, not {part.width()}"


def _of_button(part: QAbstractButton) -> Iterator[str]:
    icon_only = Qt.ToolButtonStyle.ToolButtonIconOnly
    if not part.text() or (isinstance(part, QToolButton) and part.toolButtonStyle() == icon_only):
        return
    need = part.minimumSizeHint()
    if need.width() > part.width() + _SLACK or need.height() > part.height() + _SLACK:
        has = f"{part.width()} x {part.height()}"
        yield f"{part.text()[:60]!r} needs {need.width()} x {need.height()}, not {has}"


def _of_choice(part: QComboBox) -> Iterator[str]:
    option = QStyleOptionComboBox()
    part.initStyleOption(option)
    kinds = QStyle.ComplexControl.CC_ComboBox, QStyle.SubControl.SC_ComboBoxEditField
    room = part.style().subControlRect(kinds[0], option, kinds[1], part).width()
    need = part.fontMetrics().horizontalAdvance(part.currentText())
    if need > room + _SLACK and part.currentText() not in part.toolTip():
        yield f"{part.currentText()[:60]!r} needs {need} pixels, not {room}"


def _of_titles(part: QTabBar | QHeaderView) -> Iterator[str]:
    if isinstance(part, QTabBar):
        shown = [k for k in range(part.count()) if part.isTabVisible(k)]
        titles = [(part.tabText(k), part.tabRect(k).width()) for k in shown]
    elif part.orientation() == Qt.Orientation.Horizontal and part.model() is not None:
        shown = [k for k in range(part.count()) if not part.isSectionHidden(k)]
        head = part.model().headerData
        titles = [(str(head(k, part.orientation()) or ""), part.sectionSize(k)) for k in shown]
    else:
        return
    for text, room in titles:
        need = part.fontMetrics().horizontalAdvance(text)
        if need > room:
            yield f"the title {text!r} needs {need} pixels, not {room}"


def _place(part: QWidget) -> str:
    names = []
    around: QWidget | None = part
    while around is not None:
        if around.objectName() or type(around).__module__.startswith("app"):
            names.append(around.objectName() or type(around).__name__)
        around = around.parentWidget()
    return " < ".join(names[:4]) or part.window().windowTitle()
