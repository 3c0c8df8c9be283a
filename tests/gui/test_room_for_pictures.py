"""How much of the window the cameras' pictures get, and who takes it from them."""

import shutil

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, QRectF, QSize, Qt
from PySide6.QtWidgets import QApplication, QWidget

from app.session.messages import Message
from stereotrack_core.recording.calibration import write_calibration
from tests.gui.hands import key, trigger, view
from tests.gui.kept_window import close_window, open_recording, show_window

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


def test_fewer_views_than_before_have_all_the_room(shared_window, four_portraits, small_recording):
    assert rows(shared_window(four_portraits, "annotate")) == [["N", "O", "S", "W"]]
    window = shared_window(small_recording, "annotate")
    views = window.context.docks.views
    ends = [tile.geometry().right() for tile in views.tiles.values()]
    assert len(ends) == 2
    assert max(ends) == views.width() - 1, "no place is kept for views that are gone"


def test_portraits_stand_in_a_row_and_landscapes_in_two(
    shared_window, four_portraits, four_views, qtbot
):
    window = shared_window(four_portraits, "annotate")
    assert rows(window) == [["N", "O", "S", "W"]]
    assert picture_share(window) > 0.3
    trigger(window, "arrange_one-and-more", qtbot)
    sizes = {name: view(window, name).size() for name in "NOSW"}
    assert all(2 * sizes[name].height() <= sizes["N"].height() for name in "OSW")
    assert picture_share(window) > 0.2, "the small ones stand beside each other where it helps"
    window.context.view_state.activate("S")
    QApplication.processEvents()
    assert rows(window)[0][0] == "S"
    trigger(window, "arrange_grid", qtbot)
    assert rows(window) == [["N", "O", "S", "W"]]
    window = shared_window(four_views, "annotate")
    assert rows(window) == [["N", "O"], ["S", "W"]]
    resize(window, 1366, 620)
    assert rows(window) == [["N", "O", "S", "W"]], "a low and wide room"
    resize(window, 1366, 768)
    assert rows(window) == [["N", "O"], ["S", "W"]]


def views_size(window):
    return window.context.docks.views.size()


def test_messages_and_bars_cover_neither_pictures_nor_buttons(four, qtbot):
    before = views_size(four)
    long = Message("warning", "The board was seen only at the left edge. " * 9, button="Look")
    four.context.notifier.show(long)
    bar = four.features.annotate.panels.repeat_bar
    bar.show_words("Frame 0 is annotated again.")
    QApplication.processEvents()
    views = four.context.docks.views
    for each in (bar, four.messages):
        assert each.isVisible()
        place = QRect(each.mapTo(four, QPoint(0, 0)), each.size())
        assert not QRect(views.mapTo(four, QPoint(0, 0)), views.size()).intersects(place)
        assert four.childAt(place.center()) in {each, *each.findChildren(QWidget)}
    assert four.messages.height() > 1.5 * bar.height(), "all of a long message is written"
    assert views_size(four).height() == before.height() - four.messages.height() - bar.height()
    four.context.docks.show_named("calibrate")
    QApplication.processEvents()
    page = four.context.docks.middle.currentWidget()
    top = four.messages.mapTo(four, QPoint(0, 0)).y()
    assert page.mapTo(four, QPoint(0, page.height())).y() <= top
    four.context.docks.show_named("annotate")
    four.messages.close_button.click()
    bar.show_words("")
    QApplication.processEvents()
    assert views_size(four) == before
    view_n = view(four, "N")
    corner = view_n.mapTo(four, view_n.rect().bottomLeft() + QPoint(5, -5))
    assert four.childAt(corner) is view_n, "nothing is left over the views"


def test_panels_leave_room_to_the_pictures(window, four_views, qtbot):
    window.context.session.open(four_views, workspace="annotate")
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
    docks = window.context.docks
    resize(window, 1920, 1080)
    side = docks.dock("landmarks")
    window.resizeDocks([side], [1000], Qt.Orientation.Horizontal)  # as the mouse does
    QApplication.processEvents()
    assert side.width() == 1000
    docks.show_named("track")
    resize(window, 1280, 720)
    for space in ("track", "review", "tune", "calibrate", "annotate"):
        docks.show_named(space)
        QApplication.processEvents()
        assert window.size() == QSize(1280, 720)
        size = views_size(window)
        assert size.width() >= 0.44 * 1280, space
        assert size.height() >= 0.34 * 720, space
    docks.reset()
    QApplication.processEvents()
    assert side.width() == pytest.approx(0.26 * 1280, abs=3)


def is_seen(camera, points):
    area = QRectF(camera.rect())
    return all(area.contains(camera.place_of(x, y)) for x, y in points)


def test_a_recording_opens_zoomed_to_the_person(
    qtbot, settings, failures, processes, kept, four_views, tmp_path
):
    kept.close()
    settings.setValue("open_zoomed", True)
    window = show_window(qtbot, settings, processes)
    qtbot.addWidget(window)
    open_recording(window, qtbot, four_views)
    window.context.docks.show_named("annotate")
    QApplication.processEvents()
    recording = window.context.session.document.recording
    reference = recording.reference.points.reshape(-1, 3)
    camera = view(window, "N")
    for name in "NOSW":
        person = recording.reference_camera(recording.view(name)).project(reference)
        assert view(window, name).zoom > 1.2
        assert is_seen(view(window, name), person)
        tall = np.ptp([view(window, name).place_of(x, y).y() for x, y in person])
        assert tall > 0.2 * view(window, name).height(), "hips to head"
    assert picture_share(window) > 0.4
    assert rows(window) == [["N", "O", "S", "W"]], "persons stand, so their parts are portraits"
    resize(window, 1280, 620)
    person = recording.reference_camera(recording.view("N")).project(reference)
    assert is_seen(camera, person), "in a room of another shape"
    key(window, Qt.Key.Key_0)
    assert camera.zoom == 1.0
    resize(window, 1366, 768)
    assert rows(window) == [["N", "O"], ["S", "W"]], "whole pictures are landscapes"
    assert camera.zoom == 1.0, "who has asked for the whole picture has it"
    plain = shutil.copytree(four_views, tmp_path / "plain")
    write_calibration(plain / "calibration.toml", recording.cameras, guessed=True)
    open_recording(window, qtbot, plain)
    assert view(window, "N").zoom == 1.0, "a person that movement misses could not be clicked"
    trigger(window, "open_zoomed")
    trigger(window, "close")
    open_recording(window, qtbot, four_views)
    assert view(window, "N").zoom == 1.0
    close_window(window)
    assert not failures
