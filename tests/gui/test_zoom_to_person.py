"""Zoom to the person: by key, to where clicks, fit, run or reference are, and back."""

import shutil

import pytest
from PySide6.QtCore import QPointF, QRectF, Qt

from tests.gui.hands import click, clicks, key, trigger, view
from tests.gui.kept_window import open_recording

pytestmark = pytest.mark.window

PLACES = {"N": [(300.0, 150.0), (330.0, 152.0), (310.0, 210.0)], "S": [(200.0, 150.0)]}


@pytest.fixture
def bare(window, qtbot, small_recording, tmp_path):
    """The workspace Annotate on a recording without a reference: nothing tells of a person."""
    folder = shutil.copytree(small_recording, tmp_path / "place" / "bare")
    without = [
        line
        for line in (folder / "recording.toml").read_text(encoding="utf-8").splitlines()
        if not line.startswith("reference")
    ]
    (folder / "recording.toml").write_text("\n".join(without), encoding="utf-8")
    open_recording(window, qtbot, folder, workspace="annotate")
    assert window.context.session.document.recording.reference is None
    return window


def seen(window, name, points):
    """Whether raw pixels are in what a view shows, and the share of it that they take."""
    camera = view(window, name)
    places = [camera.place_of(x, y) for x, y in points]
    area = QRectF(camera.rect())
    share = max(abs(a.y() - b.y()) for a in places for b in places) / area.height()
    return all(area.contains(QPointF(place)) for place in places), share


def press_z(window, qtbot):
    key(window, Qt.Key.Key_Z)
    qtbot.waitUntil(window.context.tasks.settled)


def test_views_zoom_to_the_clicks_and_back(bare, qtbot):
    for name, places in PLACES.items():
        for x, y in places:
            click(bare, x, y, name)
    qtbot.waitUntil(bare.context.tasks.settled)
    before = seen(bare, "N", PLACES["N"])[1]
    press_z(bare, qtbot)
    assert view(bare, "N").zoom > 1.5
    inside, share = seen(bare, "N", PLACES["N"])
    assert inside
    assert share > 1.5 * before
    press_z(bare, qtbot)
    assert [tile.camera.zoom for tile in bare.context.docks.views.tiles.values()] == [1.0, 1.0]


def test_nothing_moves_while_clicks_are_placed(bare, qtbot):
    for x, y in PLACES["N"]:
        click(bare, x, y)
    press_z(bare, qtbot)
    zoom, corner = view(bare, "N").zoom, view(bare, "N").place_of(0.0, 0.0)
    pixel = click(bare, *(PLACES["N"][0][0] - 20.0, PLACES["N"][0][1] + 30.0))
    qtbot.waitUntil(bare.context.tasks.settled)
    assert view(bare, "N").zoom == zoom
    assert view(bare, "N").place_of(0.0, 0.0) == corner
    assert any(one.position == pytest.approx(pixel) for one in clicks(bare).values())


def test_the_next_frame_follows_its_own_clicks(bare, qtbot):
    for x, y in PLACES["N"]:
        click(bare, x, y)
    bare.context.session.document.go_to(1)
    qtbot.waitUntil(bare.context.tasks.settled)
    elsewhere = [(x - 200.0, y + 150.0) for x, y in PLACES["N"]]
    for x, y in elsewhere:
        click(bare, x, y)
    bare.context.session.document.go_to(0)
    qtbot.waitUntil(bare.context.tasks.settled)
    press_z(bare, qtbot)
    assert not seen(bare, "N", elsewhere)[0]
    bare.context.session.document.go_to(1)
    qtbot.waitUntil(bare.context.tasks.settled)
    assert seen(bare, "N", elsewhere)[0]


def test_it_says_where_nothing_tells_of_a_person(bare, qtbot):
    trigger(bare, "keep_person")
    assert "Click two landmarks" in bare.statusBar().currentMessage()
    assert view(bare, "N").zoom == 1.0
