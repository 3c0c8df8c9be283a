"""Damaged projects and projects of strangers in the window: a sentence, and it goes on."""

import shutil
import sqlite3
from contextlib import closing

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import choose, save_landmark_set, save_subject
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import keep_run
from stereotrack_core.project.schema import LANDMARK_SET, SUBJECT
from stereotrack_core.recording.description import Subject
from tests.gui.hands import heard, trigger
from tests.project.test_runs import run

pytestmark = pytest.mark.window

TRIGGER = "CREATE TRIGGER t AFTER INSERT ON owner BEGIN DELETE FROM click; END"
VALUES = (
    'UPDATE subject SET facts = \'{"hip_width": "wide"}\'',
    "UPDATE click SET frame = frame + 10000000",
)
SETTINGS = ("window", "lanes", "runs shown", "wanted", "repeat_frame", "repeat_share", "against")


@pytest.fixture(scope="module")
def whole(small_recording, tmp_path_factory):
    """A project of the small recording that holds something of everything."""
    folder = tmp_path_factory.mktemp("foreign")
    shutil.copytree(small_recording, folder / "walk")
    path = folder / "whole.stereotrack"
    with Project.create(path, folder / "walk", who="A") as project:
        for edit in (
            save_subject(Subject("P", shoulder_width=0.4)),
            save_landmark_set(NINE),
            keep_run("accurate", run()),
            place_clicks((Click(1, "N_right", "head", (100.0, 120.0)),)),
        ):
            project.apply(edit)
        for table, name in ((SUBJECT, "P"), (LANDMARK_SET, NINE.name)):
            project.apply(choose(table, name))
        for name in SETTINGS:
            project.view_settings.set(name, "anything")
    return path


def opened_without_harm(window, qtbot, path) -> str:
    """What the window says of it; it is used, closed, and nothing unforeseen happens."""
    window.context.session.document.close()
    window.messages.clear()
    told = heard(window)
    window.context.session.open(path)
    qtbot.waitUntil(window.context.tasks.settled)
    said = window.messages.text()
    if window.context.session.document.recording is not None:
        window.context.docks.show_named("annotate")
        for frame in (0, 1, 3):
            window.context.session.document.go_to(frame)
        for action in ("undo", "undo", "redo"):
            window.context.actions.refresh()
            trigger(window, action, qtbot)
        said += window.messages.text()
    window.context.session.project.give_up()
    said += "".join(message.sentence() for message in told)
    assert "Unexpected error" not in said
    return said


@pytest.mark.parametrize("statements", [*VALUES, TRIGGER])
def test_the_window_says_what_is_wrong(window, qtbot, whole, monkeypatch, statements):
    monkeypatch.setattr(
        "app.features.project.files.QFileDialog.getExistingDirectory", lambda *_: ""
    )
    path = whole.with_name("spoilt.stereotrack")
    shutil.copyfile(whole, path)
    with closing(sqlite3.connect(path)) as database:
        database.executescript(statements)
    said = opened_without_harm(window, qtbot, path)
    if "subject" in statements:
        assert "'wide' is not a finite number" in said
    if statements == TRIGGER:
        assert "modified by another program" in said
        assert window.context.session.project.project is None
    for one in path.parent.glob("*spoilt*"):
        one.unlink()
