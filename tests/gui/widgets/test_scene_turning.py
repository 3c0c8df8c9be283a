"""What is written over the scene goes with it, and turning it keeps up with the mouse."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.widgets.scene import scene_view
from app.widgets.scene.content import Orbit, SceneContent
from app.widgets.scene.scene_view import SceneView
from tests.gui.widgets.test_scene_view import pixels, snapshot


@pytest.fixture
def scene(shown):
    return shown(SceneView(lambda _limb: None), 640, 480)


class Written:
    """What is written over a scene, by text, with where its middle is."""

    def __init__(self, monkeypatch):
        self.places = {}
        monkeypatch.setattr(scene_view, "_write", self.note)

    def note(self, _painter, text, box, _theme):
        self.places[text] = box.center()

    def now(self, scene):
        self.places = {}
        snapshot(scene)
        return self.places


class TestLettering:
    def test_north_goes_with_the_floor_as_it_is_turned(self, qtbot, scene, monkeypatch):
        written = Written(monkeypatch)
        scene.show_scene(SceneContent())
        scene.set_orbit(Orbit(np.zeros(3), 0.0, 0.5, 14.0))
        before = written.now(scene)["N"].x()
        drag(scene, round(np.pi / np.radians(0.4)))
        after = written.now(scene)["N"].x()
        assert (before - 320.0) * (after - 320.0) < 0.0, "from the other side it is on the other"
        scene.set_layer_visible("floor", False)
        assert not written.now(scene)

    def test_axes_stand_as_the_world_does(self, scene):
        scene.show_scene(SceneContent())
        scene.set_orbit(Orbit(np.zeros(3), -np.pi / 2, 0.0, 14.0))  # from the south
        corner = pixels(snapshot(scene))[-90:, -110:]
        red = np.argwhere(corner[..., 0] > corner[..., 2] + 90)
        blue = np.argwhere(corner[..., 2] > corner[..., 0] + 110)
        assert np.ptp(red[:, 1]) > np.ptp(red[:, 0]), "x goes to the right"
        assert np.ptp(blue[:, 0]) > np.ptp(blue[:, 1]), "z goes up"


def drag(scene, pixels_right, steps=12):
    """Turn the scene by the mouse, each move painted."""
    start = QPoint(320, 240)
    QTest.mousePress(scene, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, start)
    for k in range(1, steps + 1):
        QTest.mouseMove(scene, start + QPoint(round(k * pixels_right / steps), 0))
        scene.repaint()
    QTest.mouseRelease(scene, Qt.MouseButton.LeftButton)
