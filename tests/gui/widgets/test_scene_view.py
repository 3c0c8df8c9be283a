from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QKeyEvent, QPainter

from app.widgets.scene import drawing
from app.widgets.scene.content import LAYERS, Ellipsoid, Orbit, SceneContent
from app.widgets.scene.drawing import SceneUnavailable
from app.widgets.scene.scene_view import SceneView
from app.widgets.style.colours import LIMB_COLOURS
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import body_mesh
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from tests.gui.hands import double_click, wheel_event

HIPS = np.array([0.0, 0.0, 0.95])
BODY = body_model(AVERAGE)
POSE = t_pose(HIPS)
MESHES = body_mesh(BODY, POSE)


@dataclass(frozen=True, eq=False)
class Box:
    """A cube of a limb's colour."""

    limb: str
    vertices: np.ndarray
    triangles: np.ndarray


def snapshot(scene):
    """The scene at its best, in the pixels of the screen; null where it cannot be drawn."""
    if not scene._render(fine=True):
        return QImage()
    picture = scene._image.copy()
    painter = QPainter(picture)
    scene._paint_names(painter)
    painter.end()
    return picture


def box(limb, centre, half=0.2):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return Box(limb, np.array(centre) + half * corners, np.array(triangles))


def camera_north(name="N"):
    # looks south at the person; x is west then, y is down
    rotation = np.array([[-1.0, 0, 0], [0, 0, -1], [0, -1, 0]])
    matrix = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
    place = RigidTransform(rotation, -rotation @ np.array([0.0, 2.5, 1.3]))
    return Camera(name, 640, 480, matrix, np.zeros(5), False, place)


def pixels(image):
    image = image.convertToFormat(image.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def share_of_hue(image, colour, tolerance=12):
    """Share of pixels that have a colour's hue, whatever the light makes of it."""
    rgb = pixels(image)
    saturated = np.ptp(rgb, axis=2) > 60
    hue = cv2.cvtColor((rgb / 255.0).astype(np.float32), cv2.COLOR_RGB2HSV)[..., 0]
    distance = np.abs((hue - QColor(colour).hsvHue() + 180) % 360 - 180)
    return float((saturated & (distance < tolerance)).mean())


def new_scene():
    clicked = []
    made = SceneView(clicked.append)
    made.clicked = clicked
    return made


@pytest.fixture
def scene(shown):
    return shown(new_scene(), 640, 480)


@pytest.fixture
def bare(scene):
    """A scene in which nothing but what a test puts there has a colour."""
    for layer in ("floor", "cameras"):
        scene.set_layer_visible(layer, False)
    return scene


class TestModel:
    @pytest.mark.parametrize("limb", [limb for limb in LIMBS if limb != "torso"])
    def test_limb_is_seen_in_its_colour(self, bare, limb):
        bare.show_scene(SceneContent(meshes=MESHES))
        with_limb = share_of_hue(snapshot(bare), LIMB_COLOURS[limb])
        others = tuple(mesh for mesh in MESHES if mesh.limb != limb)
        bare.show_scene(SceneContent(meshes=others))
        without = share_of_hue(snapshot(bare), LIMB_COLOURS[limb])
        assert with_limb > without + 0.002

    def test_front_view_has_the_right_arm_at_the_left_of_the_picture(self, bare):
        bare.show_scene(SceneContent(meshes=MESHES))
        bare.set_view("front")
        picture = snapshot(bare)
        left = picture.copy(0, 0, picture.width() // 2, picture.height())
        right = picture.copy(picture.width() // 2, 0, picture.width() // 2, picture.height())
        assert share_of_hue(left, LIMB_COLOURS["right_forearm"]) > 0.002
        assert share_of_hue(left, LIMB_COLOURS["left_forearm"]) == 0.0
        assert share_of_hue(right, LIMB_COLOURS["left_forearm"]) > 0.002

    def test_selected_limb_keeps_its_colour_and_gets_a_rim(self, bare, dark):
        bare.show_scene(SceneContent(meshes=MESHES))
        colour = LIMB_COLOURS["left_forearm"]
        before = share_of_hue(snapshot(bare), colour)
        assert share_of_hue(snapshot(bare), dark.accent) == 0.0
        bare.set_highlighted("left_forearm")
        assert bare.content.highlighted == "left_forearm"
        assert share_of_hue(snapshot(bare), dark.accent) > 0.0004
        assert share_of_hue(snapshot(bare), colour) > 0.8 * before
        bare.set_highlighted("")
        assert share_of_hue(snapshot(bare), dark.accent) == 0.0


class TestClicking:
    @pytest.mark.parametrize("limb", LIMBS)
    def test_click_on_a_limb_says_its_name(self, qtbot, scene, limb):
        boxes = tuple(
            box(name, (1.2 * (k % 3 - 1), 0, 1.2 * (k // 3))) for k, name in enumerate(LIMBS)
        )
        scene.show_scene(SceneContent(meshes=boxes))
        scene.set_view("front")
        centre = boxes[LIMBS.index(limb)].vertices.mean(axis=0)
        x, y = scene.orbit.project(centre[None], scene.width(), scene.height())[0]
        qtbot.mouseClick(scene, Qt.MouseButton.LeftButton, pos=QPoint(round(x), round(y)))
        assert scene.clicked == [limb]

    def test_click_beside_and_hidden_model_say_nothing(self, qtbot, scene):
        scene.show_scene(SceneContent(meshes=(box("torso", (0, 0, 1)),)))
        qtbot.mouseClick(scene, Qt.MouseButton.LeftButton, pos=QPoint(3, 3))
        scene.set_layer_visible("model", False)
        qtbot.mouseClick(scene, Qt.MouseButton.LeftButton, pos=QPoint(320, 240))
        assert not scene.clicked

    def test_drag_turns_and_does_not_click(self, qtbot, scene):
        scene.show_scene(SceneContent(meshes=(box("torso", (0, 0, 1)),)))
        before = scene.orbit
        qtbot.mousePress(scene, Qt.MouseButton.LeftButton, pos=QPoint(320, 240))
        qtbot.mouseMove(scene, QPoint(350, 240))
        qtbot.mouseMove(scene, QPoint(380, 250))
        qtbot.mouseRelease(scene, Qt.MouseButton.LeftButton, pos=QPoint(380, 250))
        assert not scene.clicked
        assert scene.orbit.azimuth != before.azimuth
        assert scene.orbit.elevation != before.elevation
        np.testing.assert_allclose(scene.orbit.focus, before.focus)


class TestEye:
    def test_wheel_zooms_and_double_click_resets(self, qtbot, scene):
        scene.show_scene(SceneContent(meshes=MESHES))
        home = scene.orbit
        scene.wheelEvent(wheel_event(scene, QPointF(10, 10), 3))
        assert scene.orbit.distance < home.distance
        double_click(scene, QPoint(5, 5))
        assert scene.orbit.distance == pytest.approx(home.distance)

    def test_right_drag_moves_the_scene_with_the_mouse(self, qtbot, scene):
        scene.show_scene(SceneContent(meshes=MESHES))
        point = scene.orbit.focus[None]
        before = scene.orbit.project(point, 640, 480)[0]
        qtbot.mousePress(scene, Qt.MouseButton.RightButton, pos=QPoint(320, 240))
        for step in (20, 40, 60):
            qtbot.mouseMove(scene, QPoint(320 + step, 240 - step // 2))
        qtbot.mouseRelease(scene, Qt.MouseButton.RightButton, pos=QPoint(380, 210))
        moved = scene.orbit.project(point, 640, 480)[0] - before
        np.testing.assert_allclose(moved, (60, -30), atol=2.0)

    def test_single_keys_mean_what_they_mean_in_the_whole_window(self, qtbot, scene):
        scene.show_scene(SceneContent(meshes=MESHES))
        before = scene.orbit
        letters = (Qt.Key.Key_F, Qt.Key.Key_S, Qt.Key.Key_T, Qt.Key.Key_R, Qt.Key.Key_Home)
        for code in letters:
            qtbot.keyClick(scene, code)
        assert scene.orbit == before
        none, control = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier
        zoom = ((Qt.Key.Key_Plus, none, True), (Qt.Key.Key_Plus, control, False))
        for code, modifier, taken in (*((code, none, False) for code in letters), *zoom):
            event = QKeyEvent(QEvent.Type.ShortcutOverride, code, modifier)
            event.ignore()
            scene.event(event)
            assert event.isAccepted() is taken


class TestLayers:
    content = SceneContent(
        cloud_points=np.random.default_rng(0).normal((0, 0, 1.2), 0.2, (3000, 3)),
        cloud_colours=np.tile(np.array([[255, 0, 255]], np.uint8), (3000, 1)),
        meshes=MESHES,
        reference=landmarks(BODY, POSE) + (0.0, 0.0, 0.1),
        cameras=(camera_north(),),
        camera_images={"N": np.full((48, 64, 3), (250, 20, 20), np.uint8)},
        ellipsoids=(Ellipsoid("head", np.array([0.0, 0.0, 2.0]), np.eye(3) * 0.02),),
    )

    @pytest.mark.parametrize("layer", LAYERS)
    def test_every_layer_can_be_switched_off(self, scene, layer):
        scene.show_scene(self.content)
        scene.set_orbit(scene.orbit.zoomed(0.5))
        scene.set_layer_visible(layer, True)
        before = pixels(snapshot(scene))
        scene.set_layer_visible(layer, False)
        assert not scene.layer_visible(layer)
        after = pixels(snapshot(scene))
        assert (np.abs(after - before).max(axis=2) > 20).sum() > 30
        scene.set_layer_visible(layer, True)
        np.testing.assert_array_equal(pixels(snapshot(scene)), before)

    def test_camera_shows_its_image_upright(self, bare):
        bare.set_layer_visible("cameras", True)
        image = np.zeros((48, 64, 3), np.uint8)
        image[:24] = (250, 10, 10)
        image[24:] = (10, 10, 250)
        content = SceneContent(cameras=(camera_north(),), camera_images={"N": image})
        bare.show_scene(content)
        # from behind the camera, looking where it looks
        bare.set_orbit(Orbit(np.array([0.0, 2.0, 1.3]), np.pi / 2, 0.0, 2.0))
        picture = snapshot(bare)
        upper = picture.copy(0, 0, 640, 230)
        lower = picture.copy(0, 250, 640, 230)
        assert share_of_hue(upper, "#ff0000") > 0.01
        assert share_of_hue(lower, "#0000ff") > 0.01
        assert share_of_hue(lower, "#ff0000") == 0.0


class TestWithoutOpenGL:
    @pytest.fixture
    def blind(self, shown, monkeypatch):
        def unavailable():
            raise SceneUnavailable("No OpenGL is available.")

        monkeypatch.setattr(drawing, "SceneRenderer", unavailable)
        return shown(new_scene(), 300, 200)

    def test_widget_says_so(self, blind):
        before = blind.grab().toImage()
        assert "OpenGL" in blind.unavailable_because
        assert len(np.unique(pixels(before).reshape(-1, 3), axis=0)) > 2
        assert snapshot(blind).isNull()

    def test_the_rest_works(self, qtbot, blind):
        blind.show_scene(SceneContent(meshes=(box("torso", (0, 0, 1)),)))
        blind.set_view("front")
        qtbot.mouseClick(blind, Qt.MouseButton.LeftButton, pos=QPoint(150, 100))
        assert blind.clicked == ["torso"]


def test_a_rig_is_held_beside_the_body(shown):
    scene = shown(new_scene(), 600, 250)
    corner = np.array([[2.0, 2.0, 2.4], [-2.0, -2.0, 0.0]])
    scene.hold(corner)
    scene.show_scene(SceneContent(meshes=MESHES))
    scene.set_view("home")
    points = np.vstack([corner, *(mesh.vertices for mesh in MESHES)])
    x, y = scene.orbit.project(points, 600, 250).T
    assert ((x > 0) & (x < 600)).all()
    assert ((y > 0) & (y < 250)).all()
