"""Studies in the window: the table, its filter and order, opening, what is asked for."""

import pytest
from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPushButton

from app.features.study.track_dialog import TrackDialog
from app.features.study.window import StudyWindow
from app.session.opening import dropped_paths
from stereotrack_core.cli.commands import command_named, parser_of
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.status import study_status
from stereotrack_core.study.tasks import remembered
from tests.study.conftest import study, walks  # noqa: F401 - fixtures

pytestmark = pytest.mark.window


@pytest.fixture
def known(study):  # noqa: F811
    """The study, read before."""
    cache = StudyCache(study.cache)
    study_status(study, cache)
    cache.save()
    return study


def names(window):
    return [row.row.recording.removeprefix("data/") for row in window.model.rows]


def button(dialog, text):
    return next(one for one in dialog.findChildren(QPushButton) if one.text() == text)


def test_the_table_is_filtered_sorted_and_keeps_what_is_selected(shown, qtbot, known, tmp_path):
    window = shown(StudyWindow(), 1100, 500)
    found = remembered(known.path)
    window.show_study(found.study, found.rows)
    assert names(window) == ["anna/fast", "anna/slow", "ben/slow"]
    header = window.view.horizontalHeader()
    frames = [column.heading for column in window.model.columns].index("frames")
    where = header.sectionViewportPosition(frames) + header.sectionSize(frames) // 2
    for order in (["anna/slow", "anna/fast", "ben/slow"], ["ben/slow", "anna/fast", "anna/slow"]):
        QTest.mouseClick(
            header.viewport(),
            Qt.MouseButton.LeftButton,
            pos=QPoint(where, header.height() // 2),
        )
        assert names(window) == order
    cell = window.view.visualRect(window.model.index(1, 0)).center()
    QTest.mouseClick(window.view.viewport(), Qt.MouseButton.LeftButton, pos=cell)
    assert window.chosen() == ("data/anna/fast",)
    window.filter.setFocus()
    qtbot.keyClicks(window.filter, "subject=anna")
    assert names(window) == ["anna/fast", "anna/slow"]
    assert window.chosen() == ("data/anna/fast",), "the same recording at another place"
    assert window.count.text() == "2 of 3 recordings"
    qtbot.keyClicks(window.filter, " slow")
    assert names(window) == ["anna/slow"]
    assert window.chosen() == ("data/anna/slow",), "all that are shown, where none is selected"


def test_a_study_is_opened_read_and_its_recordings_open(window, qtbot, known, tmp_path):
    (tmp_path / "data/anna/fast/calibration.toml").unlink()
    opening = window.context.session.opening
    opening.open(known.path)
    studies = next(
        one for one in window.context.session.children() if type(one).__name__ == "StudyController"
    )
    qtbot.waitUntil(lambda: studies.window is not None and bool(studies.window.rows))
    table = studies.window
    qtbot.waitUntil(lambda: not studies.working)
    spoilt = table.rows[0]
    assert spoilt.recording.errors >= 1
    QTest.keyClick(table.filter, Qt.Key.Key_B)
    assert names(table) == ["ben/slow"]
    cell = table.view.visualRect(table.model.index(0, 0)).center()
    QTest.mouseClick(table.view.viewport(), Qt.MouseButton.LeftButton, pos=cell)
    assert table.messages.text() == "No problems are known."
    with qtbot.waitSignal(window.context.session.document.opened):
        QTest.keyClick(table.view, Qt.Key.Key_Return)
        QApplication.processEvents()
    assert window.context.session.document.recording.folder == tmp_path / "data/ben/slow"
    table.close()
    qtbot.waitUntil(window.context.tasks.settled)


def test_what_is_asked_for_is_a_command(shown, qtbot, known):
    begun = []
    dialog = shown(
        TrackDialog(known.path, ("data/ben/slow",), 3, ("fast", ["iterations=3"]), begun.append),
        520,
        320,
    )
    dialog.seeds.selectAll()
    qtbot.keyClicks(dialog.seeds, "0,x")
    start = button(dialog, "&Start")
    QTest.mouseClick(start, Qt.MouseButton.LeftButton)
    assert "list of seeds" in dialog.words.text()
    dialog.seeds.selectAll()
    qtbot.keyClicks(dialog.seeds, "0,1")
    dialog.report.setFocus()
    QTest.keyClick(dialog.report, Qt.Key.Key_Space)
    QTest.mouseClick(start, Qt.MouseButton.LeftButton)
    (arguments,) = begun
    args = parser_of(command_named("study")).parse_args(arguments[1:])
    assert (args.study, args.preset, args.changes) == (known.path, "fast", ["iterations=3"])
    assert (args.select, args.seeds, args.report) == (["recording=data/ben/slow"], "0,1", True)


def test_a_study_can_be_dropped_on_the_window(known):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(known.path))])
    assert dropped_paths(data) == (known.path,)
