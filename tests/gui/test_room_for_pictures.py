"""How much of the window the cameras' pictures get, and who takes it from them."""

from __future__ import annotations

import shutil

import pytest
from PySide6.QtCore import QRectF, QSize
from PySide6.QtWidgets import QApplication

from tests.gui.hands import view

pytestmark = pytest.mark.window


@pytest.fixture(scope="session")
def four_portraits(four_views, tmp_path_factory):
    """Four views whose cameras lay on their side."""
    folder = shutil.copytree(four_views, tmp_path_factory.mktemp("recordings") / "portraits")
    path = folder / "recording.toml"
    turned = path.read_text(encoding="utf-8").replace(
        '\nkind = "stereo"', '\nkind = "stereo"\ndisplay_rotation = 90'
    )
    path.write_text(turned, encoding="utf-8")
    return folder


def resize(window, width, height):
    """Give the window another size; it takes it."""
    window.resize(width, height)
    QApplication.processEvents()
    assert window.size() == QSize(width, height)


def rows(window):
    """Names of the views as they stand, row by row."""
    tiles = [tile for tile in window.context.docks.views.tiles.values() if tile.isVisible()]
    tops = sorted({tile.y() for tile in tiles})
    return [
        [tile.view.name for tile in sorted(tiles, key=lambda one: one.x()) if tile.y() == top]
        for top in tops
    ]


def picture_share(window):
    """Share of the window that is picture."""
    covered = 0.0
    for name in window.context.docks.views.visible_views():
        camera = view(window, name)
        height, width = camera.picture.pixels.shape[:2]
        ends = camera.place_of(-0.5, -0.5), camera.place_of(width - 0.5, height - 0.5)
        seen = QRectF(*ends).normalized().intersected(QRectF(camera.rect()))
        covered += seen.width() * seen.height()
    return covered / (window.width() * window.height())


def test_portraits_stand_in_a_row_and_landscapes_in_two(
    shared_window, four_portraits, four_views, qtbot
):
    window = shared_window(four_portraits, "annotate")
    assert rows(window) == [["N", "O", "S", "W"]]
    assert picture_share(window) > 0.3
    window.context.actions.action("arrange_one-and-more").trigger()
    qtbot.waitUntil(window.context.tasks.settled)
    sizes = {name: view(window, name).size() for name in "NOSW"}
    assert all(2 * sizes[name].height() <= sizes["N"].height() for name in "OSW")
    assert picture_share(window) > 0.2, "the small ones stand beside each other where it helps"
    window.context.view_state.activate("S")
    QApplication.processEvents()
    assert rows(window)[0][0] == "S"
    window.context.actions.action("arrange_grid").trigger()
    qtbot.waitUntil(window.context.tasks.settled)
    assert rows(window) == [["N", "O", "S", "W"]]
    window = shared_window(four_views, "annotate")
    assert rows(window) == [["N", "O"], ["S", "W"]]
    resize(window, 1366, 620)
    assert rows(window) == [["N", "O", "S", "W"]], "a low and wide room"
    resize(window, 1366, 768)
    assert rows(window) == [["N", "O"], ["S", "W"]]
