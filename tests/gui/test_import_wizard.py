"""From a folder of videos to an open recording, by keyboard, mouse and drop."""

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWizard

from app.features.project.importing.wizard import ImportWizard
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.importing.making import cameras_for
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.sources import look_at
from tests.gui.hands import settle
from tests.gui.test_opening_files import drop
from tests.recording.importing.clips import clip, flashing, images

pytestmark = pytest.mark.window
BUTTON = QWizard.WizardButton


@pytest.fixture
def videos(tmp_path):
    for name in ("N_left", "N_right", "S"):
        clip(tmp_path / "videos" / f"{name}.mp4", frames=4)
    return tmp_path / "videos"


@pytest.fixture
def wizard_of(window, qtbot):
    """Function that opens paths and gives the wizard that comes."""

    def shown(*paths):
        if len(paths) == 1 and paths[0].is_dir():
            window.context.session.open(paths[0])
        else:
            assert drop(window, *paths)
        qtbot.waitUntil(lambda: window.findChild(ImportWizard) is not None)
        wizard = window.findChild(ImportWizard)
        qtbot.waitUntil(wizard.isVisible)
        settle(window, qtbot)
        return wizard

    yield shown
    for wizard in window.findChildren(ImportWizard):
        wizard.reject()


def press(wizard, which):
    """Go on by Return, as somebody without a mouse does."""
    button = wizard.button(which)
    assert button.isEnabled(), which
    assert button.isDefault()
    QTest.keyClick(wizard, Qt.Key.Key_Return)
    QApplication.processEvents()


def to_the_end(wizard):
    for page in wizard.steps[wizard.steps.index(wizard.currentPage()) + 1 :]:
        press(wizard, BUTTON.NextButton)
        assert wizard.currentPage() is page


def recording_of(window, qtbot):
    qtbot.waitUntil(lambda: window.context.session.document.recording is not None)
    settle(window, qtbot)
    return window.context.session.document.recording


def set_role(row, role):
    row.role.setFocus()
    while row.role.currentData() != role:
        before = row.role.currentIndex()
        down = row.role.findData(role) > before
        QTest.keyClick(row.role, Qt.Key.Key_Down if down else Qt.Key.Key_Up)
        assert row.role.currentIndex() != before


def test_a_folder_of_videos_becomes_a_recording_by_keyboard(window, qtbot, videos, wizard_of):
    wizard = wizard_of(videos)
    assert [row.role.currentData() for row in wizard.sources.rows] == ["left", "right", "mono"]
    to_the_end(wizard)
    assert "3 sources stay where they are" in wizard.place.summary.text()
    assert "need a calibration" in wizard.place.summary.text()
    press(wizard, BUTTON.FinishButton)
    recording = recording_of(window, qtbot)
    assert [(view.name, view.kind) for view in recording.views] == [("N", "stereo"), ("S", "mono")]
    assert recording.folder.resolve() == videos.resolve()
    assert window.findChild(ImportWizard) is None or not window.findChild(ImportWizard).isVisible()
    assert "guessed from the size of the images" in window.messages.text()
    assert "The calibration is a guess" in window.context.session.no_depth()

    assert window.messages.do_button.text() == "Attach a calibration …"
    QTest.mouseClick(window.messages.other_buttons[0], Qt.MouseButton.LeftButton)
    assert window.context.docks.workspace == "calibrate"


def test_what_does_not_fit_together_is_said_in_place(videos, wizard_of):
    wizard = wizard_of(videos)
    left, _, _ = wizard.sources.rows
    set_role(left, "mono")
    assert "the left image is missing" in wizard.sources.words.text()
    assert not wizard.button(BUTTON.NextButton).isEnabled()
    set_role(left, "left")
    assert wizard.sources.words.text() == ""
    left.view.setFocus()
    left.view.selectAll()
    QTest.keyClicks(left.view, "Q")
    assert "the right image is missing" in wizard.sources.words.text()


def test_images_need_a_frame_rate(window, qtbot, tmp_path, wizard_of):
    images(tmp_path / "videos" / "O_depth", depth=True)
    wizard = wizard_of(tmp_path / "videos")
    press(wizard, BUTTON.NextButton)
    assert "do not state their frame rate" in wizard.timing.words.text()
    assert not wizard.button(BUTTON.NextButton).isEnabled()
    assert wizard.timing.unit.value() == 1.0
    wizard.timing.fps.setFocus()
    wizard.timing.fps.selectAll()
    QTest.keyClicks(wizard.timing.fps, "30")
    to_the_end(wizard)
    assert "O_image/%06d.png" in wizard.place.summary.text()
    press(wizard, BUTTON.FinishButton)
    assert recording_of(window, qtbot).fps == 30.0


def choose_method(wizard, qtbot, method):
    page = wizard.timing
    page.method.setFocus()
    for _ in range(page.method.findData(method) - page.method.currentIndex()):
        QTest.keyClick(page.method, Qt.Key.Key_Down)
    assert page.method.currentData() == method
    assert not wizard.button(BUTTON.NextButton).isEnabled()
    assert "Press Estimate" in page.words.text()
    page.estimate.setFocus()
    QTest.keyClick(page.estimate, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: page.estimate.isEnabled())


def test_cameras_are_synchronised_by_a_flash(window, qtbot, tmp_path, wizard_of):
    for name, at in (("A", 9.0), ("B", 12.25)):
        clip(tmp_path / "videos" / f"{name}.mp4", flashing(at), frames=20)
    wizard = wizard_of(tmp_path / "videos")
    press(wizard, BUTTON.NextButton)
    choose_method(wizard, qtbot, "flash")
    assert "B: +3.2" in wizard.timing.offsets.text()
    to_the_end(wizard)
    press(wizard, BUTTON.FinishButton)
    streams = [view.image for view in recording_of(window, qtbot).views]
    assert [one.first_frame for one in streams] == [0, 3]
    assert streams[1].time_offset == pytest.approx(0.25 / 25.0, abs=0.004)


def test_cameras_of_a_calibration_are_matched(window, qtbot, videos, tmp_path, wizard_of):
    cameras = cameras_for(propose(look_at([videos])))
    path = tmp_path / "rig.toml"
    renamed = {f"c{k}": replace(one, name=f"c{k}") for k, one in enumerate(cameras.values())}
    write_calibration(path, renamed)
    wizard = wizard_of(videos)
    press(wizard, BUTTON.NextButton)
    press(wizard, BUTTON.NextButton)
    page = wizard.calibration
    page.from_file.setFocus()
    QTest.keyClick(page.from_file, Qt.Key.Key_Space)
    page.path.setFocus()
    QTest.keyClicks(page.path, str(path))
    assert "Say which camera of the file is N_left" in page.words.text()
    assert not wizard.button(BUTTON.NextButton).isEnabled()
    for box, letter in zip(list(page._cameras.values()), "123", strict=True):
        for _ in range(int(letter)):
            QTest.keyClick(box, Qt.Key.Key_Down)
    assert page.words.text() == ""
    press(wizard, BUTTON.NextButton)
    press(wizard, BUTTON.FinishButton)
    recording = recording_of(window, qtbot)
    assert not recording.guessed
    assert recording.views[0].image.camera == "c1"


def test_a_folder_in_which_nothing_can_be_made_is_said(videos, wizard_of, tmp_path):
    wizard = wizard_of(videos)
    to_the_end(wizard)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("years")
    wizard.place.folder.setFocus()
    wizard.place.folder.selectAll()
    QTest.keyClicks(wizard.place.folder, str(tmp_path / "full"))
    assert "the folder is not empty" in wizard.place.words.text()
    assert not wizard.button(BUTTON.FinishButton).isEnabled()


def test_escape_leaves_nothing_behind(window, qtbot, videos, wizard_of):
    before = sorted(videos.iterdir())
    wizard = wizard_of(videos)
    to_the_end(wizard)
    QTest.keyClick(wizard, Qt.Key.Key_Escape)
    qtbot.waitUntil(lambda: window.findChild(ImportWizard) is None)
    assert sorted(videos.iterdir()) == before
    assert window.context.session.document.recording is None
    assert wizard_of(videos) is not None, "it can be opened again"


THEIRS = """[cam_{k}]
name = "{name}"
size = [64, 48]
matrix = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]
distortions = [0.0, 0.0, 0.0, 0.0, 0.0]
rotation = [0.0, 0.0, 0.0]
translation = [{x}, 0.0, 0.0]
"""


def test_a_calibration_of_another_tool_asks_for_its_unit(window, qtbot, tmp_path, wizard_of):
    for name in ("left", "right"):
        clip(tmp_path / "videos" / f"{name}.mp4", frames=2)
    path = tmp_path / "theirs.toml"
    sections = [THEIRS.format(k=k, name=f"c{k}", x=-k * 40.0) for k in range(2)]
    path.write_text("".join(sections))
    wizard = wizard_of(tmp_path / "videos")
    press(wizard, BUTTON.NextButton)
    press(wizard, BUTTON.NextButton)
    page = wizard.calibration
    page.from_file.setFocus()
    QTest.keyClick(page.from_file, Qt.Key.Key_Space)
    page.path.setFocus()
    QTest.keyClicks(page.path, str(path))
    assert "Choose the unit or the convention" in page.words.text()
    assert "mm: base line 0.04 m" in page.words.text()
    assert not wizard.button(BUTTON.NextButton).isEnabled()
    page.unit.setFocus()
    for _ in range(page.unit.findData("mm")):
        QTest.keyClick(page.unit, Qt.Key.Key_Down)
    for box, times in zip(list(page._cameras.values()), (1, 2), strict=True):
        for _ in range(times):
            QTest.keyClick(box, Qt.Key.Key_Down)
    assert "Unit mm: given" in page.words.text()
    press(wizard, BUTTON.NextButton)
    press(wizard, BUTTON.FinishButton)
    recording = recording_of(window, qtbot)
    assert recording.cameras["c1"].position_world == pytest.approx([0.04, 0.0, 0.0])
