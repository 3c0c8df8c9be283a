import pytest
from PySide6 import QtWidgets
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor, QPalette
from PySide6.QtSvg import QSvgRenderer

from app.widgets.style.colours import LIMB_COLOURS
from app.widgets.style.theme import (
    apply_theme,
    chosen_theme,
    current_theme,
    data_folder,
    icon_named,
    load_theme,
    resource_path,
)
from app.widgets.tables.panels import RunRow, RunsPanel
from app.widgets.tables.table import Cell, CellTable, Column


def luminance(colour):
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a, b):
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", ["dark", "light"])
class TestContrast:
    def test_writing_is_readable_on_every_surface(self, name):
        theme = load_theme(name)
        for surface in (theme.window, theme.base, theme.raised):
            for writing in (theme.text, theme.muted, theme.error, theme.warning, theme.good):
                assert contrast(writing, surface) >= 4.5, (writing, surface)

    def test_what_cannot_be_done_now_can_still_be_read(self, name):
        theme = load_theme(name)
        for surface in (theme.window, theme.base, theme.raised, theme.plot_background):
            assert contrast(theme.disabled, surface) >= 3.0, surface
        assert contrast(theme.disabled, theme.base) < contrast(theme.muted, theme.base)

    def test_what_is_selected_is_readable(self, name):
        theme = load_theme(name)
        assert contrast(theme.accent_text, theme.accent) >= 4.5
        assert contrast(theme.text, theme.selection) >= 4.5

    def test_limbs_stand_out_from_the_plot(self, name):
        theme = load_theme(name)
        for colour in LIMB_COLOURS.values():
            assert contrast(colour, theme.plot_background) >= 2.0, colour


def test_theme_reaches_palette_and_tokens(qapp, dark):
    assert qapp.palette().color(QPalette.ColorRole.Window) == QColor(dark.window)
    apply_theme(qapp, "light")
    light = load_theme("light")
    assert current_theme() == light
    assert chosen_theme() == "light"
    assert qapp.palette().color(QPalette.ColorRole.WindowText) == QColor(light.text)


def test_widgets_that_are_there_already_change(qapp, qtbot, dark):
    window = QtWidgets.QMainWindow()
    qtbot.addWidget(window)
    dock, inner = QtWidgets.QDockWidget("panel", window), QtWidgets.QWidget()
    kinds = (
        QtWidgets.QPushButton,
        QtWidgets.QLabel,
        QtWidgets.QCheckBox,
        QtWidgets.QComboBox,
        QtWidgets.QSlider,
        QtWidgets.QTableWidget,
    )
    widgets = [kind(inner) for kind in kinds]
    dock.setWidget(inner)
    window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
    window.statusBar()
    window.show()
    for name in ("light", "dark"):
        apply_theme(qapp, name)
        qapp.processEvents()
        theme = load_theme(name)
        for widget in widgets:
            colours = widget.palette()
            assert colours.color(QPalette.ColorRole.Button).name() == theme.raised, widget
            assert colours.color(QPalette.ColorRole.Base).name() == theme.base, widget
            assert colours.color(QPalette.ColorRole.WindowText).name() == theme.text, widget


ICONS = sorted(path.stem for path in (data_folder("resources") / "icons").glob("*.svg"))


@pytest.mark.parametrize("name", ICONS)
def test_icon_is_drawn(qapp, dark, name):
    assert QSvgRenderer(str(resource_path("icons", f"{name}.svg"))).isValid()
    image = icon_named(name).pixmap(24, 24).toImage()
    opaque = [
        image.pixelColor(x, y).alpha() > 128
        for x in range(image.width())
        for y in range(image.height())
    ]
    assert 0.02 < sum(opaque) / len(opaque) < 0.9


def test_icons_follow_the_theme(qapp, qtbot, dark):
    button, action = QtWidgets.QToolButton(), QAction()
    qtbot.addWidget(button)
    button.addAction(action)
    action.setParent(button)
    for target in (button, action):
        target.setIcon(icon_named("stop"))
    apply_theme(qapp, "light")
    expected = QColor(load_theme("light").text)
    for target in (button, action):
        assert target.icon().pixmap(24, 24).toImage().pixelColor(12, 12) == expected


def test_lines_in_the_list_of_runs_follow_the_theme(qapp, qtbot, dark):
    panel = RunsPanel(*3 * [lambda *_: None])
    qtbot.addWidget(panel)
    panel.show_rows([RunRow(Cell("run"), "solid", (Cell(),) * 5, "")])
    panel.show()
    for name in ("light", "dark"):
        apply_theme(qapp, name)
        qapp.processEvents()
        role = Qt.ItemDataRole.DecorationRole
        line = panel.tree.topLevelItem(0).data(0, role).toImage()
        assert line.pixelColor(14, 7).name() == load_theme(name).text


def test_the_colour_of_a_selected_row_stays_what_it_is(qapp, qtbot, dark):
    apply_theme(qapp, "light")
    blue = LIMB_COLOURS["left_upper_arm"]
    table = CellTable("Landmarks", [Column("Name")], lambda row: row, single=True)
    qtbot.addWidget(table)
    table.show_rows([(Cell("elbow", swatch=blue),)])
    table.setCurrentIndex(table.cells.index(0, 0))
    table.show()
    image = table.viewport().grab().toImage()
    middle = table.visualRect(table.cells.index(0, 0)).center().y()
    assert blue.lower() in {image.pixelColor(x, middle).name() for x in range(30)}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_focus_does_not_look_like_a_selection(qapp, qtbot, theme):
    before = chosen_theme()
    apply_theme(qapp, theme)
    window, buttons = QtWidgets.QWidget(), [QtWidgets.QToolButton(), QtWidgets.QToolButton()]
    qtbot.addWidget(window)
    for place, button in enumerate(buttons):
        button.setParent(window)
        button.setGeometry(10 + 60 * place, 10, 40, 40)
        button.setCheckable(True)
    buttons[1].setChecked(True)
    window.resize(140, 60)
    with qtbot.waitExposed(window):
        window.show()

    def focused_one():
        window.activateWindow()
        buttons[0].setFocus()
        return buttons[0].hasFocus()

    qtbot.waitUntil(focused_one)

    def edge(button):
        """Colours along the upper edge, without its ends."""
        picture = button.grab().toImage()
        return {picture.pixelColor(x, 0).name() for x in range(8, picture.width() - 8)}

    focused, selected = (edge(button) for button in buttons)
    assert selected == {current_theme().accent}
    assert current_theme().accent not in focused
    assert len(focused) > 1, "dashes"
    apply_theme(qapp, before)
