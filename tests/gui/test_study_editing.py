"""Studies edited in their window: cells, columns, recordings, undo, and what others write."""

import shutil
from dataclasses import replace

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QTreeView

from app.features.study.edit_dialogs import RemoveColumnDialog, TextDialog, ValueDialog
from app.features.study.editing import StudyEditing
from app.features.study.window import StudyWindow
from app.widgets.forms.form_dialog import FormDialog
from app.widgets.style.theme import apply_theme
from stereotrack_core.project.project import Project
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.file import read_study
from stereotrack_core.study.status import RowStatus, study_status
from stereotrack_core.study.tasks import remembered
from tests.gui.hands import CTRL, LEFT, SHIFT, double_click
from tests.gui.seen_texts import faults_of
from tests.study.conftest import study, walks  # noqa: F401 - fixtures

pytestmark = pytest.mark.window

SUBJECT, CONDITION = 1, 2


@pytest.fixture
def table(shown, qtbot, settings, study):  # noqa: F811
    """The window of a study that was read before, without the rest of the program."""
    cache = StudyCache(study.cache)
    study_status(study, cache)
    cache.save()
    window = StudyWindow()
    editing = StudyEditing(window, settings)
    found = remembered(study.path)
    editing.editor.show(found.stored)
    window.show_study(found.study, found.rows)
    window.editing = editing
    shown(window, 1366, 768)
    qtbot.waitUntil(lambda: active(window))
    return window


def active(window):
    window.activateWindow()
    return window.isActiveWindow()


def names(window):
    return [row.row.recording.removeprefix("data/") for row in window.model.rows]


def column(path, name):
    return [row.factors[name] for row in read_study(path).rows]


def place(window, row, column):
    return window.view.visualRect(window.model.index(row, column)).center()


def click(window, row, column=SUBJECT, modifiers=Qt.KeyboardModifier.NoModifier):
    QTest.mouseClick(window.view.viewport(), LEFT, modifiers, place(window, row, column))


def editor(window):
    found = window.view.viewport().findChildren(QLineEdit)
    return next((one for one in found if one.isVisible()), None)


def write(qtbot, window, text, key=Qt.Key.Key_Return):
    """Type into the cell that is edited, over what it says."""
    qtbot.waitUntil(lambda: editor(window) is not None)
    line = editor(window)
    line.selectAll()
    QTest.keyClicks(line, text)
    press(qtbot, window, key)


def press(qtbot, window, key):
    """Press a key in the cell that is edited, which ends that."""
    line = editor(window)
    QTest.keyClick(line, key)
    qtbot.waitUntil(lambda: editor(window) is not line)


def dialog(qtbot, kind):
    def found():
        return [one for one in QApplication.topLevelWidgets() if isinstance(one, kind)]

    qtbot.waitUntil(lambda: any(one.isVisible() for one in found()))
    return next(one for one in found() if one.isVisible())


def accept(qtbot, window, asked):
    QTest.mouseClick(asked.accept_button, LEFT)
    qtbot.waitUntil(lambda: active(window))


def test_a_cell_is_edited_by_double_click_saved_and_undone(table, qtbot):
    opened = []
    table.open_wanted.connect(opened.append)
    path = table.study.path
    cell = place(table, 1, CONDITION)
    QTest.mouseClick(table.view.viewport(), LEFT, pos=cell)
    double_click(table.view.viewport(), cell)
    write(qtbot, table, "very slow")
    assert column(path, "condition") == ["fast", "very slow", "slow"]
    assert table.model.index(1, CONDITION).data() == "very slow"
    assert table.said.text() == "condition is 'very slow' in 1 recording."
    table.view.setFocus()
    QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL)
    assert column(path, "condition") == ["fast", "slow", "slow"]
    assert table.said.text() == "Undone: set condition of 1 recording."
    QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL | SHIFT)
    assert column(path, "condition") == ["fast", "very slow", "slow"]
    assert opened == [], "what is edited does not open"
    click(table, 1, 0)
    double_click(table.view.viewport(), place(table, 1, 0))
    assert len(opened) == 1, "a cell that cannot be edited opens the recording, as before"


def test_what_is_typed_goes_into_all_selected_recordings(table, qtbot):
    path = table.study.path
    click(table, 0, CONDITION)
    click(table, 2, CONDITION, CTRL)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    assert "2 selected" in table.said.text()
    press(qtbot, table, Qt.Key.Key_Return)
    assert column(path, "condition") == ["fast", "slow", "slow"], "nothing was typed"
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "run", Qt.Key.Key_Escape)
    assert column(path, "condition") == ["fast", "slow", "slow"]
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "run")
    assert column(path, "condition") == ["run", "slow", "run"]
    assert table.chosen() == ("data/anna/fast", "data/ben/slow"), "they stay selected"


def test_rows_stay_in_place_while_a_cell_is_edited(table, qtbot):
    table.view.horizontalHeader().setSortIndicator(CONDITION, Qt.SortOrder.AscendingOrder)
    assert names(table) == ["anna/fast", "anna/slow", "ben/slow"]
    click(table, 0, SUBJECT)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "zoe", Qt.Key.Key_Tab)
    assert table.view.currentIndex().column() == CONDITION, "Tab goes on in the row"
    write(qtbot, table, "z")
    qtbot.waitUntil(lambda: names(table) == ["anna/slow", "ben/slow", "anna/fast"])
    assert table.view.currentIndex().row() == 2, "the cursor has moved with its recording"
    assert column(table.study.path, "subject") == ["zoe", "anna", "ben"]
    assert column(table.study.path, "condition") == ["z", "slow", "slow"]


def test_a_value_is_set_and_filled_by_dialogs(table, qtbot):
    path = table.study.path
    click(table, 0)
    click(table, 1, SUBJECT, SHIFT)
    QTest.keyClick(table.view, Qt.Key.Key_F2, SHIFT)
    asked = dialog(qtbot, ValueDialog)
    assert asked.column.currentData() == "subject"
    asked.column.setCurrentIndex(1)
    assert [asked.value.itemText(k) for k in range(asked.value.count())] == ["fast", "slow"]
    QTest.keyClicks(asked.value.lineEdit(), "jog")
    accept(qtbot, table, asked)
    assert column(path, "condition") == ["jog", "jog", "slow"]
    table.editing.actions.action("study_fill").trigger()
    asked = dialog(qtbot, TextDialog)
    QTest.keyClicks(asked.text, "who/value")
    QTest.mouseClick(asked.accept_button, LEFT)
    assert "'value' cannot be a column" in asked.words.text()
    asked.text.clear()
    QTest.keyClicks(asked.text, "who/condition")
    accept(qtbot, table, asked)
    assert column(path, "who") == ["anna", "anna", ""]
    assert column(path, "condition") == ["jog", "jog", "slow"], "what was written stays"


def test_columns_are_added_renamed_and_removed(table, qtbot):
    path, actions = table.study.path, table.editing.actions
    actions.action("study_add_column").trigger()
    asked = dialog(qtbot, TextDialog)
    QTest.keyClicks(asked.text, "subject")
    QTest.keyClick(asked.text, Qt.Key.Key_Return)
    assert "already" in asked.words.text()
    asked.text.selectAll()
    QTest.keyClicks(asked.text, "age")
    QTest.keyClick(asked.text, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: active(table))
    assert [one.heading for one in table.model.columns][:4] == [
        *("recording", "subject", "condition", "age"),
    ]
    header = table.view.horizontalHeader()
    header.customContextMenuRequested.emit(QPoint(header.sectionViewportPosition(CONDITION) + 9, 5))
    table._column_menu.close()
    actions.action("study_rename_column").trigger()
    asked = dialog(qtbot, TextDialog)
    assert asked.column.currentData() == "condition", "the column that was clicked"
    asked.text.selectAll()
    QTest.keyClicks(asked.text, "speed")
    accept(qtbot, table, asked)
    assert column(path, "speed") == ["fast", "slow", "slow"]
    actions.action("study_remove_column").trigger()
    asked = dialog(qtbot, RemoveColumnDialog)
    assert asked.column.currentData() == "speed"
    assert "3 recordings" in asked.note.text()
    accept(qtbot, table, asked)
    assert read_study(path).factors == ("subject", "age")
    for _ in range(3):
        QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL)
    assert read_study(path).factors == ("subject", "condition")
    assert column(path, "condition") == ["fast", "slow", "slow"]


def test_rows_are_removed_and_no_file_is(table):
    path = table.study.path
    click(table, 0)
    click(table, 1, SUBJECT, CTRL)
    QTest.keyClick(table.view, Qt.Key.Key_Delete)
    assert names(table) == ["ben/slow"]
    assert "No file was deleted" in table.said.text()
    assert (path.parent / "data/anna/fast/recording.toml").is_file()
    assert [row.recording for row in read_study(path).rows] == ["data/ben/slow"]
    QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL)
    assert names(table) == ["anna/fast", "anna/slow", "ben/slow"]
    assert table.rows[0].recording is not None, "what was known is still known"
    table.view.selectAll()
    QTest.keyClick(table.view, Qt.Key.Key_Delete)
    assert table.empty.isVisible()
    assert "no recordings yet" in table.track_button.toolTip()


def test_what_is_read_late_does_not_undo_an_edit(table, qtbot):
    stale = list(table.rows)
    click(table, 0, SUBJECT)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    QTest.keyClicks(editor(table), "Anna")
    read = replace(stale[0].recording, frames=99)
    table.take([replace(stale[0], recording=read)])
    assert editor(table).text() == "Anna", "what is typed stays"
    QTest.keyClicks(editor(table), " B")
    press(qtbot, table, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: active(table))  # proposals have been shown in a window
    table.take(stale)
    assert table.rows[0].row.factors["subject"] == "Anna B"
    gone = RowStatus(table.rows[0].row, table.rows[0].place)
    click(table, 0)
    QTest.keyClick(table.view, Qt.Key.Key_Delete)
    table.take([gone])
    assert names(table) == ["anna/slow", "ben/slow"]


def test_every_edit_says_what_it_does_and_why_it_cannot_be_done(table, qtbot):
    table.view.clearSelection()
    actions = table.editing.actions
    for command in actions.commands:
        action = actions.action(command.id)
        assert action.toolTip()
        assert action.statusTip()
        assert action.isEnabled() == ("Unavailable: " not in action.toolTip()), command.id
    assert not actions.action("study_remove").isEnabled()
    table.view.setFocus()
    QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL)
    assert table.said.text() == "Undo: unavailable. There is nothing to undo."
    assert "Select one recording" in table.open_button.toolTip()


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_everything_can_be_read_and_is_explained(table, qtbot, qapp, theme):
    apply_theme(qapp, theme)
    asks = ["set_value", "fill", "add_column", "rename_column", "remove_column"]
    assert faults_of(table) == []
    table.view.selectAll()
    for name in asks:
        table.editing.actions.action(f"study_{name}").trigger()
        asked = dialog(qtbot, FormDialog)
        assert faults_of(asked) == [], name
        QTest.keyClick(asked, Qt.Key.Key_Escape)
        qtbot.waitUntil(lambda: active(table))
    QTest.keyClick(table.view, Qt.Key.Key_Delete)
    assert faults_of(table) == []


def test_a_file_that_another_program_changed_is_not_overwritten(table, qtbot):
    path = table.study.path
    text = path.read_text("utf-8").replace("ben,slow", "Ben,slow")
    path.write_text(text, "utf-8")
    click(table, 0, SUBJECT)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "x")
    assert "another program has changed" in table.said.text()
    assert path.read_text("utf-8") == text
    assert table.model.index(0, SUBJECT).data() == "anna"
    assert table.editing.editor.stack.to_undo() is None


# ---- with the whole program


@pytest.fixture
def studies(window):
    session = window.context.session
    return next(one for one in session.children() if type(one).__name__ == "StudyController")


@pytest.fixture
def settled(window, qtbot, studies):
    """Function that waits until the study is read, and gives its window."""

    def wait():
        qtbot.waitUntil(lambda: studies.window is not None and window.context.tasks.settled())
        qtbot.waitUntil(lambda: active(studies.window))
        return studies.window

    return wait


def drop(window, paths):
    """Drag files from another program onto the table."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    where, target = QPoint(200, 200), window.view.viewport()
    given = (Qt.DropAction.CopyAction, data, LEFT, Qt.KeyboardModifier.NoModifier)
    enter = QDragEnterEvent(where, *given)
    QApplication.sendEvent(target if target.isVisible() else window, enter)
    dropped = QDropEvent(QPointF(where), *given)
    QApplication.sendEvent(window, dropped)
    return enter.isAccepted()


def test_a_study_is_made_and_filled_in_the_window(
    window, qtbot, studies, settled, walks, tmp_path, monkeypatch  # noqa: F811
):  # fmt: skip
    monkeypatch.setattr(
        "stereotrack_core.project.whereabouts.documents_folder", lambda: tmp_path / "none"
    )
    shutil.copytree(walks, tmp_path / "data")
    Project.create(tmp_path / "ben.stereotrack", tmp_path / "data/ben/slow").close()
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_, **__: (str(tmp_path / "walks"), "")
    )
    window.context.actions.action("new_study").trigger()
    table = settled()
    path = tmp_path / "walks.study.csv"
    assert read_study(path).factors == ("subject", "condition", "repetition")
    assert table.empty.isVisible()

    QTest.keyClick(table, Qt.Key.Key_N, CTRL)
    asked = dialog(qtbot, QFileDialog)
    asked.setDirectory(str(tmp_path / "data"))
    tree = asked.findChild(QTreeView, "treeView")
    qtbot.waitUntil(lambda: tree.model().rowCount(tree.rootIndex()) == 2)
    tree.selectAll()
    button = next(
        one for one in asked.findChildren(type(table.open_button)) if one.text() == "&Add"
    )
    QTest.mouseClick(button, LEFT)
    qtbot.waitUntil(lambda: len(table.rows) == 3)
    settled()
    assert names(table) == ["anna/fast", "anna/slow", "ben/slow"]
    assert all(row.recording is not None for row in table.rows), "they were read"
    assert table.said.text() == "3 recordings added."

    (tmp_path / "empty").mkdir()
    assert drop(table, [tmp_path / "ben.stereotrack", tmp_path / "empty"])
    qtbot.waitUntil(lambda: "no recording" in table.said.text())
    settled()
    assert read_study(path).rows[2].project == "ben.stereotrack"
    assert table.rows[2].project is not None, "the project was read"
    for _ in range(2):
        QTest.keyClick(table.view, Qt.Key.Key_Z, CTRL)
    assert read_study(path).rows == ()
    settled()
    assert table.empty.isVisible()
    table.close()


def test_a_study_that_another_program_changed_is_read_again(window, qtbot, settled, study):  # noqa: F811
    window.context.session.opening.open(study.path)
    table = settled()
    click(table, 0, CONDITION)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "run")
    text = study.path.read_text("utf-8")
    study.path.write_text(text.replace("ben,slow", "Ben,slow"), "utf-8")
    QTest.mouseClick(table.refresh_button, LEFT)
    qtbot.waitUntil(lambda: "read again" in table.said.text())
    settled()
    assert "can no longer be undone" in table.said.text()
    assert table.rows[2].row.factors["subject"] == "Ben"
    click(table, 2, SUBJECT)
    QTest.keyClick(table.view, Qt.Key.Key_F2)
    write(qtbot, table, "Benno")
    assert column(study.path, "subject") == ["anna", "anna", "Benno"]
    settled().close()


def test_a_study_is_not_overwritten_by_a_new_one(window, studies, study):  # noqa: F811
    shown = []
    window.context.notifier.shown.connect(shown.append)
    before = study.path.read_bytes()
    studies.new_study(study.path)
    assert [message.what for message in shown] == ["there is a study of this name already"]
    assert study.path.read_bytes() == before
