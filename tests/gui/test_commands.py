"""Palette, shortcuts, and every command in every state."""

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QFileDialog, QToolButton

from app.services.actions import ActionRegistry
from app.shell.dialogs import CommandPalette, ShortcutEditor
from stereotrack_core.tracking.presets import preset
from tests.gui.kept_window import open_recording

pytestmark = pytest.mark.window


def dialog_of(kind):
    found = [w for w in QApplication.topLevelWidgets() if isinstance(w, kind) and w.isVisible()]
    return found[-1] if found else None


def test_the_palette_finds_and_does(opened, qtbot):
    QTest.keyClick(opened, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil(lambda: dialog_of(CommandPalette) is not None)
    palette = dialog_of(CommandPalette)
    qtbot.keyClicks(palette.search, "last frame")
    assert palette._current().title == "Last frame"
    qtbot.keyClick(palette.search, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: opened.context.session.document.frame == 7)


def test_the_palette_says_why_something_cannot_be_done(window, qtbot):
    palette = CommandPalette(window.context.actions, window)
    qtbot.addWidget(palette)
    palette.search.setText("track one frame")
    assert "No recording is open" in palette._why.text()
    palette._choose()
    assert not palette.result()


def test_the_status_line_says_first_why_something_cannot_be_done(window):
    """At 1366 pixels a long tip is cut off at its end, and with it the reason."""
    tip = window.context.actions.action("find_remedy").statusTip()
    assert tip.startswith("Unavailable: There is no run yet.")


def listed(palette, text):
    palette.search.setText(text)
    return [(command.title, command.id) for command in palette.list.cells.rows]


def test_the_palette_lists_first_what_is_meant_and_can_be_done(window, qtbot):
    book = window.context.actions
    palette = CommandPalette(book, window)
    qtbot.addWidget(palette)
    names = [name for name, _ in listed(palette, "")]
    assert len(names) == len(set(names)), "nothing is told apart by its menu alone"
    assert "Theme: Dark" in names
    can = [book.action(command).isEnabled() for _, command in listed(palette, "")]
    assert can == sorted(can, reverse=True), "what can be done comes first"
    assert listed(palette, "dark theme")[0] == ("Theme: Dark", "theme_dark")
    assert listed(palette, "track one frame")[0][1] == "step", "meant exactly, and says why not"
    can = [book.action(command).isEnabled() for _, command in listed(palette, "op")]
    assert can == sorted(can, reverse=True)
    assert set(can) == {True, False}


def test_main_actions_are_named_and_what_has_no_room_is_offered(opened, qtbot):
    bars, action = opened.bars, opened.context.actions.action
    run = bars.track.widgetForAction(action("run"))
    assert (run.text(), run.toolButtonStyle().name) == ("Run", "ToolButtonTextBesideIcon")
    assert not shown_more(opened), "all of them fit"
    opened.resize(1000, 700)
    QApplication.processEvents()
    more = shown_more(opened)
    assert more
    for button in more:
        assert button.accessibleName().startswith("More of the toolbar")
        assert not button.icon().isNull()
        assert button.width() >= 10
        place = button.mapTo(opened, button.rect().topRight())
        assert opened.rect().contains(place), "all of it is seen"


def shown_more(window):
    found = window.findChildren(QToolButton, "qt_toolbar_ext_button")
    return [button for button in found if button.isVisible()]


def test_every_command_says_what_it_does(window):
    for command in window.context.actions.commands:
        assert command.tip.endswith((".", "!")), command.id
        assert command.text, command.id
        reason = command.why_not()
        assert not reason or reason.endswith("."), command.id
        assert window.context.actions.action(command.id).isEnabled() == (not reason)


def test_no_two_commands_share_a_shortcut(window):
    book: ActionRegistry = window.context.actions
    used = {}
    for command in book.commands:
        keys = book.shortcut(command.id)
        if keys:
            where = (command.goes_first, keys)
            assert where not in used, f"{command.id} and {used.get(where)} are both on {keys}"
            used[where] = command.id


def test_a_shortcut_is_changed_kept_and_never_stolen(newly_opened, qtbot, settings):
    opened = newly_opened
    editor = ShortcutEditor(opened.context.actions, opened)
    qtbot.addWidget(editor)
    listed = [command.title for command in editor.list.cells.rows]
    assert not [title for title in listed if title.strip().endswith(":")], "none without a name"
    editor.choose("next")
    editor.keys.setKeySequence("L")
    qtbot.mouseClick(editor.set_button, Qt.MouseButton.LeftButton)
    assert "Loupe" in editor.note.text()
    assert opened.context.actions.shortcut("next") == "Right"
    editor.keys.setKeySequence("Y")
    qtbot.mouseClick(editor.set_button, Qt.MouseButton.LeftButton)
    assert settings.value("shortcuts/next") == "Y"
    QTest.keyClick(opened, Qt.Key.Key_Y)
    assert opened.context.session.document.frame == 1


@pytest.fixture
def silent_dialogs(monkeypatch, tmp_path):
    """File dialogs that are cancelled."""
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *a, **k: "")
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *a, **k: ("", ""))
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *a, **k: ("", ""))


NEED_CLICKS = {
    *("annotate-fit", "annotate-propose", "annotate-interpolate", "annotate-accept"),
    *("annotate-accept-fit", "annotate-accept-run"),
}
"""Commands that say in a message what has to be clicked first."""


LESS = {"fit_shape": False, "search_proposals": 60, "data_points": 300}

NOT_HERE = {"quit", "demo", "close", "projects_beside", "recent_1"}
"""Commands that would end the test or begin it anew, leave something beside the recording of
others, or answer with a message when the test may be over."""


def trigger_everything(window, qtbot, besides=()):
    """Trigger every command that can be done, and close what opens."""
    done = []
    for command in window.context.actions.commands:
        action = window.context.actions.action(command.id)
        window.context.actions.refresh(command.menu)
        if command.id in {*NOT_HERE, *NEED_CLICKS, *besides} or not action.isEnabled():
            continue
        action.trigger()
        QApplication.processEvents()
        for widget in QApplication.topLevelWidgets():
            if isinstance(widget, QDialog) and widget.isVisible():
                widget.close()
        done.append(command.id)
    return done


def test_every_command_in_every_state(window, qtbot, failures, small_recording, silent_dialogs):
    session = window.context.session
    welcome = trigger_everything(window, qtbot)
    assert "open" in welcome
    open_recording(window, qtbot, small_recording)
    tracking = {"run", "step", "run_here", "run_selection"}
    session.track.choose("accurate", preset("accurate").replaced(**LESS))
    quiet = trigger_everything(window, qtbot, besides=tracking)
    assert len(quiet) > 50
    session.track.choose("accurate", preset("accurate").replaced(**LESS))
    session.track.first_pose = "tpose"
    window.context.actions.action("step").trigger()
    qtbot.waitUntil(lambda: session.track.paused and len(session.track.entry.frames) == 1)
    paused = trigger_everything(window, qtbot, besides={"remove_run"})
    assert tracking - {"run_selection"} <= set(paused) | {"run_here", "step"}
    session.track.pause()
    qtbot.waitUntil(lambda: not session.track.running)
    session.track.stop()
    qtbot.waitUntil(window.context.tasks.settled)
    there = not session.no_run()  # a command may take it away, another one back
    idle = trigger_everything(window, qtbot, besides=tracking)
    assert "save_run" in idle or not there
    assert not failures
    assert window.messages.message is None, window.messages.text()


def test_something_wrong_inside_is_said_without_a_traceback(window, qtbot, failures, monkeypatch):
    failed = []
    monkeypatch.setattr(
        "app.session.messages.LOG.error", lambda *a, **k: failed.append(k["exc_info"][1])
    )
    QTimer.singleShot(0, lambda: 1 / 0)
    qtbot.waitUntil(lambda: bool(failures))
    message = failures.pop()
    window.messages.show_message(message)
    assert "Unexpected error in the program" in window.messages.text()
    assert "Traceback" not in window.messages.text()
    assert isinstance(failed[0], ZeroDivisionError), "the details are in the log"
    assert window.isVisible()
