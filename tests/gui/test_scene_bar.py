"""Switches in the scene's title, and how the scene follows the views."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QToolButton

from app.features.view.feature import SCENE_LAYERS
from app.widgets.scene.content import LAYERS
from tests.gui.made_runs import add_run

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


def test_the_scene_says_what_the_colours_of_its_points_mean(opened, qtbot):
    opened.context.docks.show_named("track")
    qtbot.waitUntil(opened.context.tasks.settled)
    add_run(opened, "good", off=0.05)
    scene, views = opened.context.docks.scene, tuple(opened.context.docks.views.tiles)
    colours = {action.objectName(): action for action in menus(opened)["Point colours"].actions()}
    for name, title, words in (
        ("points_limb", "Points by nearest limb:", "left forearm"),
        ("points_distance", "Points by distance to the model:", "100 mm and more"),
        ("points_view", "Points by view:", views[-1]),
    ):
        colours[name].trigger()
        qtbot.waitUntil(opened.context.tasks.settled)
        legend = scene.content.point_legend
        assert legend.title == title
        told = dict(legend.entries)
        assert words in told
        drawn = {tuple(colour) for colour in scene.content.cloud_colours.tolist()}
        assert name == "points_distance" or drawn <= set(told.values())
