"""The stack of edits: those that the project stores and those of the window, in one order."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session.edits import EditStack, WindowEdit
from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.clicks import MoveClicks, PlaceClicks, place
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.entries import SaveEntry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import RUN
from tests.gui.hands import CTRL, SHIFT, key, truth


class Stage:
    """A project, its stack, and a value and a setting that a window has."""

    def __init__(self, project):
        self.value, self.setting, self.project, self.edits = 0, 0, project, EditStack()
        self.messages = []
        self.edits.message.connect(self.messages.append)
        self.edits.set_project(project)
        project.on_change(self.edits.follow)

    def put(self, value):
        self.value = value

    def set(self, value, slot=None, **how):
        words, change = f"set value to {value}", (self.put, self.value, value)
        self.edits.do(WindowEdit(words, *change, slot=slot, is_data=True), **how)

    def choose(self, setting):
        """Change what is no data."""

        def put(value):
            self.setting = value

        self.edits.do(WindowEdit(f"choose {setting}", put, self.setting, setting))

    def click(self, frame=0):
        self.project.apply(place(Click(frame, "N_right", "head", (1.0, 2.0))))

    def keep(self, name):
        """Keep something in place of a run; what it holds does not matter to the history."""
        self.project.apply(SaveEntry(RUN.name, name, "{}", name.encode()))

    def words(self):
        both = self.edits.to_undo(), self.edits.to_redo()
        return tuple("" if one is None else one.words for one in both)

    def frames(self):
        return self.project.clicks.frames().tolist()

    def listed(self):
        return [(entry.words, entry.state) for entry in self.edits.entries()]


@pytest.fixture
def path(small_recording, tmp_path):
    path = tmp_path / "mine.stereotrack"
    Project.create(path, small_recording, who="A").close()
    return path


@pytest.fixture
def stage(path, qapp):
    with Project.open(path, who="A") as project:
        yield Stage(project)


def test_what_was_done_last_is_undone_first_whoever_stores_it(stage):
    stage.set(1)
    stage.click(3)
    stage.set(2)
    stage.click(5)
    done = []
    while stage.edits.to_undo() is not None:
        done.append(stage.words()[0])
        stage.edits.undo()
    first, second = (f"place head in N_right, frame {frame}" for frame in (3, 5))
    assert done == [second, "set value to 2", first, "set value to 1"]
    assert (stage.value, stage.frames(), stage.words()) == (0, [], ("", "set value to 1"))
    again = []
    while stage.edits.to_redo() is not None:
        again.append(stage.words()[1])
        stage.edits.redo()
    assert again == done[::-1]
    assert (stage.value, stage.frames()) == (2, [3, 5])
    assert stage.listed() == [(words, "done") for words in done]


def test_an_edit_of_either_kind_ends_redo_of_both(stage):
    for kind in (lambda: stage.set(7), lambda: stage.click(7)):
        stage.set(1)
        stage.click(3)
        stage.edits.undo()
        stage.edits.undo()
        kind()
        assert stage.edits.to_redo() is None
        stage.edits.redo()
        assert stage.project.history.to_redo() is None
        stage.edits.undo()
        assert (stage.value, stage.frames()) == (0, [])


def test_a_run_that_is_kept_meanwhile_is_nobody_s_edit(stage):
    stage.set(1)
    stage.set(2)
    stage.edits.undo()
    stage.keep("a")
    assert stage.words() == ("set value to 1", "set value to 2")
    stage.edits.redo()
    stage.keep("b")
    stage.edits.undo()
    stage.edits.undo()
    assert (stage.value, stage.project.runs.names(), stage.words()[0]) == (0, ("a", "b"), "")


def test_changes_of_the_same_thing_in_a_row_are_one(stage):
    for value in (1, 2, 3):
        stage.set(value, slot="value")
    assert stage.listed() == [("set value to 3", "done")]
    stage.click()
    stage.set(4, slot="value")
    stage.edits.close_last()
    stage.set(5, slot="value")
    stage.set(6)
    values = []
    while stage.edits.to_undo() is not None:
        stage.edits.undo()
        values.append(stage.value)
    assert values == [5, 4, 3, 3, 0]
    stage.set(1, slot="value")
    stage.set(0, slot="value")
    assert stage.listed()[:1] == [("place head in N_right, frame 0", "dropped")], "as it was before"


def test_a_part_of_a_stored_edit_goes_with_it(stage):
    stage.click()
    stage.set(1, joined=True)
    stage.keep("a")
    stage.set(2)
    stage.edits.undo()
    assert stage.words() == ("place head in N_right, frame 0", "set value to 2")
    stage.edits.undo()
    assert (stage.value, stage.frames()) == (0, [])
    stage.edits.redo()
    assert (stage.value, stage.frames()) == (1, [0])
    assert stage.words() == ("place head in N_right, frame 0", "set value to 2")
    assert [words for words, _ in stage.listed()] == [
        *("set value to 2", "save run a", "place head in N_right, frame 0")
    ]


def test_of_a_project_that_can_only_be_read_nothing_is_undone(stage, path, small_recording):
    stage.click()
    stage.edits.set_project(None)
    stage.project.close()
    with Project.open(path, read_only=True) as project:
        reader = Stage(project)
        assert reader.words() == ("", "")
        reader.set(1)
        assert reader.words() == ("set value to 1", "")
        reader.edits.undo()
        reader.edits.undo()
        assert (reader.value, reader.frames(), reader.messages) == (0, [0], [])
        assert [state for _, state in reader.listed()] == ["undone", "done"]


def test_what_the_window_did_ends_with_its_project_and_what_is_stored_comes_with_it(stage, path):
    stage.click(2)
    stage.set(1)
    stage.edits.set_project(None)
    assert stage.words() == ("", "")
    stage.set(5)
    stage.edits.set_project(stage.project)  # it was still being opened
    assert stage.words() == ("set value to 5", "")
    stage.edits.undo()
    assert stage.words() == ("place head in N_right, frame 2", "set value to 5")
    stage.edits.clear()
    assert stage.words() == ("place head in N_right, frame 2", "")


def test_what_cannot_be_undone_stays_and_is_told(stage, path):
    stage.click()
    stage.set(1)
    path.rename(path.with_suffix(".away"))
    stage.edits.undo()
    assert (stage.value, stage.messages) == (0, [])
    stage.edits.undo()
    assert "moved, deleted or replaced" in stage.messages[0].what
    assert stage.words() == ("place head in N_right, frame 0", "set value to 1")


def test_a_run_that_was_kept_is_let_go_and_kept_again_with_what_made_it_a_run(stage):
    def put(made):
        if not made:
            stage.project.let_run_go("a")

    stage.edits.do(WindowEdit("make it a run", put, before=False, after=True))
    stage.keep("a")
    stage.project.apply(SaveEntry(RUN.name, "a", '{"note":"good"}', b"a", replacing=True))
    for _ in range(2):
        stage.edits.undo()
        assert stage.project.runs.names() == ("a",)
        stage.edits.undo()
        assert stage.project.runs.names() == ()
        assert stage.listed()[:2] == [("save run a", "undone"), ("save run a", "let go")]
        stage.edits.redo()
        assert stage.project.runs.names() == ("a",), "with what made it a run"
        stage.edits.redo()
        assert stage.project.runs.get("a").facts == {"note": "good"}
    assert stage.project.let_run_go("b") is None
    with pytest.raises(ProjectDamaged):
        stage.project.let_run_go("a")


def test_what_is_no_edit_of_data_leaves_all_that_can_be_redone(stage):
    for frame in range(20):
        stage.click(frame)
    stage.set(1)
    for _ in range(21):
        stage.edits.undo()
    stage.choose(5)
    assert stage.words() == ("choose 5", "place head in N_right, frame 0")
    stage.edits.undo()
    assert (stage.setting, stage.words()) == (0, ("", "choose 5"))
    while stage.edits.to_redo() is not None:
        stage.edits.redo()
    assert (stage.value, stage.setting, stage.frames()) == (1, 5, list(range(20)))


def test_a_setting_that_is_changed_before_the_project_comes_leaves_its_redo(stage):
    stage.click(2)
    stage.edits.undo()
    stage.edits.set_project(None)
    stage.choose(5)
    stage.edits.set_project(stage.project)
    assert stage.words() == ("choose 5", "place head in N_right, frame 2")


def test_whatever_is_done_the_states_are_those_of_a_plain_list(stage):
    """An oracle: lists of what is done, and of what is undone in the order of redo."""
    rng = np.random.default_rng(4)
    done, undone = [], []
    for step in range(1, 251):
        match int(rng.integers(9)):
            case 0 | 1:
                stage.edits.undo()
                undone = [*done[-1:], *undone]
                done = done[:-1]
            case 2:
                stage.edits.redo()
                done = [*done, *undone[:1]]
                undone = undone[1:]
            case 3:
                stage.keep(f"run {step}")
            case 4:
                stage.choose(step)
                done, undone = [*done, ("choose", step)], [u for u in undone if u[0] != "choose"]
            case 5 | 6:
                stage.set(step)
                done, undone = [*done, ("set", step)], []
            case _:
                stage.click(step)
                done, undone = [*done, ("click", step)], []
        values = {kind: [value for one, value in done if one == kind] for kind, _ in done}
        assert stage.value == values.get("set", [0])[-1]
        assert stage.setting == values.get("choose", [0])[-1]
        assert stage.frames() == values.get("click", [])
        assert [words == "" for words in stage.words()] == [not done, not undone]
        numbers = [entry.words.rpartition(" ")[2] for entry in stage.edits.entries(1000)
                   if entry.state == "undone"]  # fmt: skip
        assert numbers == [str(value) for _, value in reversed(undone)]
    assert stage.messages == []


def test_nudges_with_something_between_are_two_edits(annotating):
    """The same click is moved on, but not into an edit from before something else."""
    window = annotating
    window.context.session.project.apply(place(Click(0, "N_right", "head", (100.0, 100.0))))
    clicking = window.features.annotate.clicking.annotating
    clicking.pick(ClickKey(0, "N_right", "head"))
    edits = window.context.session.edits
    for between in (False, False, True, False):
        if between:
            edits.do(WindowEdit("set value", lambda _value: None, 0, 1))
        clicking.nudge(1.0, 0.0)
    assert [entry.words.split(" ")[0] for entry in edits.entries()] == [
        *("move", "set", "move", "place")
    ]
    assert MoveClicks.kind == edits.entries()[0].kind


def test_a_swap_that_was_dismissed_is_offered_again_by_undo(four, qtbot):
    names, mixed = four.context.docks.views.tiles, {"left_elbow", "right_elbow"}
    clicks = []
    for view in names:
        camera = four.context.session.document.recording.view(view).image.camera
        for landmark in NINE.names:
            (other,) = mixed - {landmark} if landmark in mixed else {landmark}
            seen = truth(four, other if view == "S" else landmark, view)
            clicks.append(Click(0, camera, landmark, seen))
    four.context.session.project.apply(PlaceClicks(tuple(clicks)))
    four.context.session.project.apply(place(Click(2, "N_right", "head", (100.0, 100.0))))
    undone = four.context.session.edits.to_undo().words
    key(four, Qt.Key.Key_Z, CTRL)
    four.context.session.document.visit(0)
    qtbot.waitUntil(lambda: "swapped" in four.messages.text())
    qtbot.waitUntil(four.context.tasks.settled)
    (said,) = (one for one in four.messages._messages if "swapped" in one.what)
    while said in four.messages._messages:  # others may lie above it
        QTest.mouseClick(four.messages.close_button, Qt.MouseButton.LeftButton)
    edits = four.context.session.edits
    assert edits.to_undo().words == "dismiss swap of left elbow and right elbow, frame 0"
    assert edits.to_redo().words == undone, "a dismissed note is no edit of data"
    four.context.session.document.visit(1)
    four.context.session.document.visit(0)
    qtbot.waitUntil(four.context.tasks.settled)
    assert said.what not in [one.what for one in four.messages._messages], "it was dismissed"
    four.context.session.document.visit(1)
    key(four, Qt.Key.Key_Z, CTRL)
    assert four.context.session.document.frame == 0
    qtbot.waitUntil(lambda: said.what in [one.what for one in four.messages._messages])
    key(four, Qt.Key.Key_Z, CTRL | SHIFT)
    assert said.what not in [one.what for one in four.messages._messages]
    qtbot.waitUntil(four.context.tasks.settled)
