"""From pictures of a board to a calibration, by mouse, without and with a recording."""

import shutil

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.session.replacing import replace_cameras
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.lens import RADIAL, Lens
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.folder import open_recording as read_recording
from stereotrack_core.simulation.rig import Sensor
from tests.calibrate.board_pictures import BoardRenderer, board_in_view
from tests.gui.kept_window import open_recording

pytestmark = pytest.mark.window

SIZE = (320, 240)
BOARD = Board(6, 5, 0.07)
LENS = Lens(RADIAL, np.array([300.0, 301, 160, 119, -0.1, 0.02, 0, 0, 0, 0, 0, 0]))
LEFT = Qt.MouseButton.LeftButton


def rendered(folder, cameras, boards):
    """One folder of pictures per camera, named as the camera."""
    for number, camera in enumerate(cameras):
        (folder / camera.name).mkdir(parents=True)
        sensor = Sensor(np.ones((1, 3)), 1.0, 0.6, 2.0, (1, number))
        renderer = BoardRenderer(camera, BOARD, sensor)
        for k, board in enumerate(boards):
            cv2.imwrite(str(folder / camera.name / f"{k}.png"), renderer.picture(board, k))
    return folder


@pytest.fixture(scope="session")
def board_pictures(tmp_path_factory):
    """Nine positions of a board before a stereo camera."""
    rng = np.random.default_rng(4)
    cameras = [
        LENS.camera(name, SIZE, RigidTransform(np.eye(3), np.array([x, 0.0, 0.0])))
        for name, x in (("N_left", 0.06), ("N_right", -0.06))
    ]
    boards = []
    while len(boards) < 9:
        board = board_in_view(cameras[0], BOARD, rng, (0.9, 1.4))
        seen = np.array([one.project(board.apply(BOARD.corners)) for one in cameras])
        if (seen > 25).all() and (seen < np.array(SIZE) - 25).all():
            boards.append(board)
    return rendered(tmp_path_factory.mktemp("boards"), cameras, boards)


def press(button):
    """Click a button that can be clicked."""
    assert button.isVisible(), button.text()
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, LEFT)


def done(qtbot, window):
    """Wait until nothing is calculated any more."""
    calibration = window.features.calibrate.calibration
    qtbot.waitUntil(lambda: calibration.state.busy is None)
    qtbot.waitUntil(window.context.tasks.settled)
    return calibration.state


def choose_folder(monkeypatch, folder):
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(folder))


def number(field, value):
    """Type a number into a field."""
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, str(value))
    QTest.keyClick(field, Qt.Key.Key_Return)


def described(window, monkeypatch, folder):
    """The page with the pictures of a folder and the board."""
    page = window.features.calibrate.page
    choose_folder(monkeypatch, folder)
    press(page.board.folder_button)
    number(page.board.columns, BOARD.columns)
    number(page.board.rows, BOARD.rows)
    number(page.board.square, 1000 * BOARD.square)
    return page


def tick(tree, item):
    """Click the box of a picture."""
    tree.scrollToItem(item)
    place = tree.visualItemRect(item)
    QTest.mouseClick(tree.viewport(), LEFT, pos=QPoint(place.left() + 9, place.center().y()))


@pytest.fixture
def lenses(window, qtbot, monkeypatch, board_pictures):
    """The page with the lenses calculated, without any recording."""
    press(window.welcome.calibrate_button)
    assert window.context.docks.workspace == "calibrate"
    page = described(window, monkeypatch, board_pictures)
    assert page.steps.buttons["lenses"].isEnabled() is False
    window.features.calibrate.calibration.change(model="radial")  # the quickest
    press(page.next_button)
    found = done(qtbot, window).found
    count = sum(len(one) for one in found.sightings)
    assert count > 14
    assert page.verdict.words.text() == f"Good: the board was found in {count} of 18 pictures."
    assert page.picture.shot.corners is not None
    press(page.next_button)
    assert len(done(qtbot, window).fits) == 2
    return page


def test_from_pictures_to_a_file(window, qtbot, monkeypatch, tmp_path, lenses):
    page, state = lenses, done(qtbot, window)
    shared = set.intersection(*(set(one.frames.tolist()) for one in state.sightings))
    gone = min(shared)
    assert page.steps.buttons["lenses"].text().startswith("✓")
    assert page.coverage.shot.title.startswith("N_left")
    # a picture is unticked, and the lenses are to be calculated again
    height = page.verdict.sizeHint().height()
    tick(page.lenses.tree, page.lenses.tree.item_of(("N_right", gone)))
    assert page.steps.buttons["lenses"].text().startswith("↻")
    assert page.verdict.words.text().endswith("calculate again.")
    assert page.verdict.sizeHint().height() == height, "the list stays under the mouse"
    press(page.do_button)
    state = done(qtbot, window)
    assert gone not in state.fits["N_right"].sightings.frames
    assert state.is_done("lenses")
    tick(page.lenses.tree, page.lenses.tree.item_of(("N_left", gone)))
    press(page.next_button)
    assert page.next_button.text() == "Next", "what comes next is not known yet"
    assert gone not in done(qtbot, window).fits["N_left"].sightings.frames
    assert page.steps.buttons["lenses"].text().startswith("✓"), "calculated with the places"
    assert page.verdict.words.text().endswith("or better.")
    assert f"agree on {len(shared) - 1} boards" in page.verdict.words.text()
    assert len(page.scene.content.boards) == len(done(qtbot, window).boards) > 6
    press(page.next_button)
    QTest.mouseClick(page.axes.ways["board"], LEFT, pos=QPoint(8, 8))
    place = window.features.calibrate.calibration.state.boards[-1]
    middle = place.apply(BOARD.corners.mean(axis=0))
    assert np.allclose(middle, 0.0, atol=1e-9)
    target = tmp_path / "calibration.toml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(target), ""))
    press(page.axes.file_button)
    assert page.verdict.words.text().startswith("Saved")
    saved = read_calibration(target)
    assert saved["N_left"].focal == pytest.approx(300.5, rel=0.01)
    press(page.close_button)
    assert window.context.docks.middle.currentWidget() is window.welcome


def test_what_cannot_work_says_what_to_film_again(window, qtbot, monkeypatch, tmp_path):
    folder = tmp_path / "left"
    folder.mkdir()
    for k in range(3):
        cv2.imwrite(str(folder / f"{k}.png"), np.full((60, 80), 128, np.uint8))
    press(window.welcome.calibrate_button)
    page = described(window, monkeypatch, tmp_path)
    press(page.next_button)
    done(qtbot, window)
    assert page.verdict.words.text().startswith("Film again, or name another board")
    assert not page.next_button.isEnabled()
    assert "Find the board" in page.steps.buttons["lenses"].toolTip()


def test_the_world_of_a_recording_is_turned(newly_opened, qtbot, monkeypatch, tmp_path):
    window = newly_opened
    calibrate = window.features.calibrate
    page, recording = calibrate.page, window.context.session.document.recording
    window.context.docks.show_workspace("calibrate")
    press(page.steps.buttons["axes"])
    state = window.context.view_state
    shown = state.arrangement, state.displayed
    for code in (Qt.Key.Key_Period, Qt.Key.Key_M, Qt.Key.Key_D):
        QTest.keyClick(page, code)
    assert (state.arrangement, state.displayed) == shown, "keys leave alone what is hidden"
    assert window.context.session.document.frame == 0
    assert page.axes.ways["first"].text() == "The world as &it is"
    assert not page.axes.file_button.isEnabled()
    assert "Choose pictures of the board" in page.axes.ways["board"].toolTip()
    QTest.mouseClick(page.axes.ways["floor"], LEFT, pos=QPoint(8, 8))
    state = done(qtbot, window)
    assert state.axes.way == "floor"
    number(page.axes.frame, 1)
    state = done(qtbot, window)
    assert state.axes.frame == 1
    assert page.verdict.words.text().startswith("Good: up is tilted by 0.")
    place = state.cameras["N_right"].position_world
    before = recording.cameras["N_right"].position_world
    assert np.allclose(place, before, atol=0.2)  # the floor was right but for a small turn
    assert not np.array_equal(place, before)
    target = tmp_path / "turned.toml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(target), ""))
    press(page.axes.file_button)
    assert np.allclose(read_calibration(target)["N_right"].position_world, place, atol=1e-6)


def test_another_calibration_takes_the_saved_one_away(window, qtbot, tmp_path, small_recording):
    folder = shutil.copytree(small_recording, tmp_path / "recording")
    open_recording(window, qtbot, folder)
    before = window.context.session.document.recording
    page = window.features.calibrate.page
    window.context.docks.show_workspace("calibrate")
    press(page.steps.buttons["axes"])
    QTest.mouseClick(page.axes.ways["floor"], LEFT, pos=QPoint(8, 8))
    done(qtbot, window)

    def opened_after(recording):
        now = window.context.session.document
        qtbot.waitUntil(lambda: now.recording not in (None, recording) and not now.opening)
        done(qtbot, window)
        return now.recording

    press(page.axes.into_button)
    saved = opened_after(before)
    assert page.verdict.words.text().startswith("Saved into")
    assert page.steps.buttons["axes"].text().startswith("✓")
    replace_cameras(window.context.session, before.cameras, "The calibration is attached")
    opened_after(saved)
    assert not page.verdict.words.text().startswith("Saved into")
    assert not page.steps.buttons["axes"].text().startswith("✓")


@pytest.mark.slow
def test_into_a_recording(window, qtbot, monkeypatch, tmp_path, small_recording):
    folder = shutil.copytree(small_recording, tmp_path / "recording")
    true = read_recording(folder)
    north = [one for one in true.cameras.values() if one.name.startswith("N")]
    # the calibration before is wrong by a centimetre, and knows the cameras in the north alone
    lean = _only_north(folder)
    open_recording(window, qtbot, folder)
    window.context.docks.show_workspace("calibrate")
    assert window.context.docks.is_shown("findings")
    rng = np.random.default_rng(2)
    boards = [board_in_view(north[0], BOARD, rng, (1.2, 2.0)) for _ in range(12)]
    page = described(window, monkeypatch, rendered(tmp_path / "boards", north, boards))
    window.features.calibrate.calibration.change(model="radial")
    for _ in range(3):
        press(page.next_button)
        done(qtbot, window)
    done(qtbot, window)
    press(page.next_button)
    QTest.mouseClick(page.axes.ways["recording"], LEFT, pos=QPoint(8, 8))
    press(page.axes.into_button)
    qtbot.waitUntil(lambda: page.verdict.words.text().startswith("Saved into"))
    done(qtbot, window)
    assert (folder / "calibration-before-1.toml").read_bytes() == lean
    assert read_calibration(folder / "calibration.toml").keys() == {one.name for one in north}


def _only_north(folder):
    """Leave the view N alone, and displace one of its cameras; the calibration's bytes."""
    text = (folder / "recording.toml").read_text(encoding="utf-8")
    head, first, *_ = text.split("[[views]]")
    (folder / "recording.toml").write_text(f"{head}[[views]]{first}", encoding="utf-8")
    cameras = {
        name: one
        for name, one in read_calibration(folder / "calibration.toml").items()
        if name.startswith("N")
    }
    wrong = cameras["N_left"]
    pose = wrong.camera_from_world
    moved = RigidTransform(pose.rotation, pose.translation + np.array([0.0, 0.01, 0.0]))
    cameras["N_left"] = type(wrong)(**{**_fields(wrong), "camera_from_world": moved})
    write_calibration(folder / "calibration.toml", cameras)
    return (folder / "calibration.toml").read_bytes()


def _fields(camera):
    names = ("name", "width", "height", "matrix", "distortions", "fisheye")
    return {name: getattr(camera, name) for name in names}
