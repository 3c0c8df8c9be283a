"""The stack of edits: those that the project stores and those of the window, in one order."""

import numpy as np
import pytest

from app.session.edits import EditStack, WindowEdit
from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import place
from stereotrack_core.project.entries import save_entry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import RUN


class Stage:
    """A project, its stack, and a value that a window has."""

    def __init__(self, project):
        self.value, self.project, self.messages = 0, project, []
        self.edits = EditStack(lambda *_: None, self.messages.append)
        self.edits.set_project(project)
        project.on_change(self.edits.follow)

    def put(self, value):
        self.value = value

    def set(self, value, slot=None):
        self.edits.do(WindowEdit(f"set value to {value}", self.put, self.value, value, slot=slot))

    def click(self, frame=0):
        self.project.apply(place(Click(frame, "N_right", "head", (1.0, 2.0))))

    def keep(self, name):
        """Keep something in place of a run; what it holds does not matter to the history."""
        self.project.apply(save_entry(RUN, name, "{}", name.encode()))

    def words(self):
        both = self.edits.to_undo(), self.edits.to_redo()
        return tuple("" if one is None else one.words for one in both)

    def frames(self):
        return self.project.clicks.frames().tolist()


@pytest.fixture
def path(small_recording, tmp_path):
    path = tmp_path / "mine.stereotrack"
    Project.create(path, small_recording, who="A").close()
    return path


@pytest.fixture
def stage(path):
    with Project.open(path, who="A") as project:
        yield Stage(project)


def test_changes_of_the_same_thing_in_a_row_are_one(stage):
    for value in (1, 2, 3):
        stage.set(value, slot="value")
    stage.click()
    stage.set(4, slot="value")
    stage.set(6)
    values = []
    while stage.edits.to_undo() is not None:
        stage.edits.undo()
        values.append(stage.value)
    assert values == [4, 3, 3, 0]
    stage.set(1, slot="value")
    stage.set(0, slot="value")
    assert stage.edits.to_undo() is None, "as it was before"


def test_what_the_window_did_ends_with_its_project_and_what_is_stored_comes_with_it(stage):
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


def test_whatever_is_done_the_states_are_those_of_a_plain_list(stage):
    """An oracle: lists of what is done, and of what is undone in the order of redo.

    A stored edit ends redo of both, an edit of the window that of the window alone; a run that is
    kept meanwhile is nobody's edit.
    """
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
            case 4 | 5:
                stage.set(step)
                done, undone = [*done, ("set", step)], [u for u in undone if u[0] != "set"]
            case _:
                stage.click(step)
                done, undone = [*done, ("click", step)], []
        values = {kind: [value for one, value in done if one == kind] for kind, _ in done}
        assert stage.value == values.get("set", [0])[-1]
        assert stage.frames() == values.get("click", [])
        following = [made[-1:] if k == 0 else made[:1] for k, made in enumerate((done, undone))]
        assert [words.rpartition(" ")[2] for words in stage.words()] == [
            str(made[0][1]) if made else "" for made in following
        ]
    assert stage.messages == []
