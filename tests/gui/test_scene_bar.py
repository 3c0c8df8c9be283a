"""Switches in the scene's title, and how the scene follows the views."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QToolButton

from app.features.view.feature import SCENE_LAYERS
from app.widgets.scene.content import LAYERS

pytestmark = pytest.mark.window


def buttons(window):
    bar = window.context.docks.dock("scene").titleBarWidget()
    return {
        b.defaultAction().objectName(): b for b in bar.findChildren(QToolButton) if not b.menu()
    }


def menus(window):
    bar = window.context.docks.dock("scene").titleBarWidget()
    return {b.text(): b.menu() for b in bar.findChildren(QToolButton) if b.menu()}


def test_every_layer_has_a_button_that_switches_it(opened, qtbot):
    assert set(SCENE_LAYERS) == set(LAYERS)
    for layer in LAYERS:
        button = buttons(opened)[f"scene_{layer}"]
        before = opened.context.docks.scene.layer_visible(layer)
        assert button.isChecked() == before
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        assert opened.context.docks.scene.layer_visible(layer) != before
        assert button.isChecked() != before
    assert not opened.context.docks.scene.layer_visible("cloud")
    assert opened.context.docks.scene.layer_visible("ellipsoids")


def test_standard_views_are_in_a_menu_and_stay_when_the_scene_grows(opened, qtbot):
    actions = {action.objectName(): action for action in menus(opened)["Standard views"].actions()}
    actions["scene_from_top"].trigger()
    assert opened.context.docks.scene.orbit.elevation == pytest.approx(1.5708, abs=1e-3)
    before = opened.context.docks.scene.orbit
    opened.context.docks.scene.resize(
        opened.context.docks.scene.width(), opened.context.docks.scene.height() // 2
    )
    assert opened.context.docks.scene.orbit.elevation == before.elevation


def test_the_scene_is_drawn_after_the_views_and_shows_the_newest_frame(opened, qtbot, monkeypatch):
    opened.context.docks.show_named("track")
    qtbot.waitUntil(opened.context.tasks.settled, timeout=60_000)
    shown, show_scene = [], opened.context.docks.scene.show_scene

    def noted(content):
        shown.append({tile.camera.painted_frame for tile in tiles.values()})
        show_scene(content)

    tiles = opened.context.docks.views.tiles
    monkeypatch.setattr(opened.context.docks.scene, "show_scene", noted)
    for _ in range(3):
        frame = opened.context.session.document.frame + 1
        opened.context.session.document.go_to(frame)
        qtbot.waitUntil(
            lambda frame=frame: opened.context.session.instant.told.frame_set.index == frame
        )
    qtbot.waitUntil(opened.context.tasks.settled, timeout=60_000)
    assert shown[-1] == {3}
    assert opened.context.session.document.frame == 3
    qtbot.waitUntil(opened.context.docks.scene.at_rest, timeout=10_000)
