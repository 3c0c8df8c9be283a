"""Edits are made, undone and redone without limit, also after reopening."""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from stereotrack_core.annotation.click import (
    UNCERTAIN,
    Click,
    ClickKey,
    Prediction,
    Seen,
    Visibility,
)
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import (
    accept_points,
    blind_repeat,
    delete_clicks,
    mark_clicks,
    move_clicks,
    place,
    place_clicks,
    swap_landmarks,
)
from stereotrack_core.project.database import make_database
from stereotrack_core.project.edit import together
from stereotrack_core.project.entries import choose
from stereotrack_core.project.marks import FrameFlag, flag_frames, mark_keyframes
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import SUBJECT

ELBOW = Click(1, "N_right", "left_elbow", (10.25, 20.5))
OTHER = Click(1, "N_right", "right_elbow", (40.0, 21.0), Visibility.GUESSED)
HIDDEN = Click(1, "S_cam", "left_elbow", None, Visibility.OUTSIDE)


def said(clicks: tuple[Click, ...]) -> dict[ClickKey, Click]:
    """What clicks say, whoever said it when."""
    return {click.key: replace(click, who="", at="") for click in clicks}


def test_a_click_is_there_the_moment_it_is_placed_and_after_reopening(project, project_path):
    project.apply(place_clicks((ELBOW, OTHER, HIDDEN)))
    expected = {click.key: click for click in (ELBOW, OTHER, HIDDEN)}
    assert said(project.clicks.at(1)) == expected
    project.close()
    with Project.open(project_path) as again:
        assert said(again.clicks.at(1)) == expected
        assert {click.who for click in again.clicks.all()} == {"A"}
        assert all(click.at.endswith("+00:00") for click in again.clicks.all())


def test_undo_and_redo_work_through_everything_after_reopening(project, project_path):
    edits = [
        place(ELBOW),
        place_clicks((OTHER, HIDDEN)),
        move_clicks((ELBOW.key,), (0.5, -0.25)),
        mark_clicks((ELBOW.key, OTHER.key), flag=UNCERTAIN, sigma=4.0),
        swap_landmarks(1, "N_right", "left_elbow", "right_elbow"),
        delete_clicks((OTHER.key, HIDDEN.key)),
        flag_frames((FrameFlag(2, "left_elbow", "gap"),)),
        mark_keyframes((0, 1, 2)),
        mark_keyframes((1,), "done"),
        blind_repeat(place_clicks((replace(ELBOW, position=(11.0, 20.0)),))),
    ]
    states = [content(project)]
    for edit in edits:
        project.apply(edit)
        states.append(content(project))
    assert len({repr(state) for state in states}) == len(states)
    project.close()
    for expected in reversed(states[:-1]):
        with Project.open(project_path) as again:
            assert again.undo() is not None
            assert content(again) == expected
    with Project.open(project_path) as again:
        assert again.undo() is None
        for expected in states[1:]:
            assert again.redo() is not None
            assert content(again) == expected
        assert again.redo() is None


def content(project: Project) -> tuple[object, ...]:
    return (
        project.clicks.all(with_deleted=True),
        project.clicks.again(),
        project.marks.flags(),
        project.marks.keyframes(),
    )


def test_edits_are_told_in_words(project):
    project.apply(place(ELBOW))
    assert project.history.to_undo().words == "place left elbow in N_right, frame 1"
    project.apply(place_clicks((replace(ELBOW, frame=4), replace(OTHER, camera="S_cam"))))
    assert project.history.to_undo().words == "place 2 landmarks in 2 cameras, frames 1 to 4"
    project.apply(mark_clicks((ELBOW.key,), visibility=Visibility.GUESSED))
    words = project.history.to_undo().words
    assert words == "mark left elbow in N_right, frame 1, as guessed"
    project.undo()
    assert project.history.to_redo().words == words


def test_nudges_of_two_people_stay_two_edits(project):
    project.apply(place(ELBOW))
    for project.who in ("A", "A", "B", "B"):
        project.apply(move_clicks((ELBOW.key,), (0.5, 0.0)), continues=True)
    assert [entry.who for entry in project.history.entries()] == ["B", "A", "A"]
    project.undo()
    assert project.clicks.get(ELBOW.key).position == (11.25, 20.5)


def test_outside_takes_the_place_away_and_seen_does_not_invent_one(project):
    project.apply(place_clicks((ELBOW, HIDDEN)))
    project.apply(mark_clicks((ELBOW.key,), visibility=Visibility.OUTSIDE))
    assert project.clicks.get(ELBOW.key).position is None
    with pytest.raises(InputError, match=r"left elbow in S_cam.*Click its position"):
        project.apply(mark_clicks((HIDDEN.key,), visibility=Visibility.SEEN))
    project.undo()
    assert project.clicks.get(ELBOW.key).position == ELBOW.position
    with pytest.raises(InputError, match="0 px"):
        mark_clicks((ELBOW.key,), sigma=0.0)


def test_nudges_become_one_edit_but_not_with_what_was_before_an_undo(project):
    project.apply(place(ELBOW))
    nudge = move_clicks((ELBOW.key,), (0.5, 0.0))
    for _ in range(4):
        project.apply(nudge, continues=True)
    assert project.clicks.get(ELBOW.key).position == (12.25, 20.5)
    assert len(project.history.entries()) == 2
    project.apply(move_clicks((ELBOW.key,), (9.0, 0.0)))
    project.undo()
    project.apply(nudge, continues=True)
    assert [entry.state for entry in project.history.entries()] == ["done", "dropped"] + [
        "done"
    ] * 2
    project.undo()
    project.undo()
    assert project.clicks.get(ELBOW.key).position == ELBOW.position


def test_an_edit_that_fails_in_part_does_nothing(project):
    project.apply(place(ELBOW))
    wrong = together("both", (place(OTHER), choose(SUBJECT, "nobody")))
    with pytest.raises(InputError, match="no subject 'nobody'"):
        project.apply(wrong)
    assert said(project.clicks.at(1)) == {ELBOW.key: ELBOW}
    assert len(project.history.entries()) == 1


def test_listeners_are_told_what_changed_and_when_it_is_taken_back(project):
    heard = []
    forget = project.on_change(heard.append)
    project.apply(place_clicks((ELBOW, replace(OTHER, frame=7))))
    project.undo()
    project.redo()
    forget()
    project.undo()
    assert [changed.how for changed in heard] == ["done", "undone", "redone"]
    assert {changed.frames() for changed in heard} == {frozenset({1, 7})}
    assert heard[0].tables == {"click"}


def test_threads_do_not_disturb_each_other(project):
    """Each places its own clicks and reads, while predictions are replaced."""

    def edit(camera: str) -> None:
        for frame in range(15):
            project.apply(place(replace(ELBOW, camera=camera, frame=frame)))
            project.predictions.replace(
                camera, [Prediction(frame, camera, "head", camera, (1.0, 2.0))]
            )
            assert project.clicks.get(ClickKey(frame, camera, "left_elbow")) is not None
            assert len(project.clicks.all()) > frame

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(edit, ["N_left", "N_right", "S_cam"]))
    assert project.clicks.count() == 45
    assert len(project.predictions.at(14)) == 3
    numbers = [entry.number for entry in project.history.entries()]
    assert numbers == list(range(45, 0, -1))
    while project.undo() is not None:
        pass
    assert project.clicks.all(with_deleted=True) == ()


def test_accepted_predictions_never_replace_what_a_person_said(project):
    predicted = [
        Prediction(frame, "N_right", "left_elbow", "run", (50.0, float(frame)))
        for frame in (1, 2, 3)
    ]
    project.apply(place_clicks((ELBOW, replace(ELBOW, frame=2))))
    project.apply(delete_clicks((replace(ELBOW, frame=2).key,)))
    project.apply(accept_points(tuple(predicted)))
    assert {click.frame: click.origin for click in project.clicks.all()} == {
        1: "hand",
        3: "accepted",
    }
    assert project.clicks.at(3)[0].position == (50.0, 3.0)
    words = "accept left elbow in N_right, frames 1 to 3"
    assert project.history.to_undo().words == words
    project.apply(accept_points((predicted[1],), even_deleted=True))
    assert project.clicks.at(2)[0].position == (50.0, 2.0)
    assert project.apply(accept_points((predicted[0],), even_deleted=True)) is None


def test_edits_of_a_second_reading_do_what_they_do_to_the_first(project):
    first = (ELBOW, OTHER)
    project.apply(place_clicks(first))
    outside = replace(OTHER, position=None, visibility=Visibility.OUTSIDE)
    there = (replace(ELBOW, position=(12.0, 19.0)), outside)

    def after(edit):
        project.apply(blind_repeat(place_clicks(there)))
        made = project.apply(blind_repeat(edit))
        found = {click.landmark: click for click in project.clicks.again_at(1)}
        if made is not None:
            assert made.words == f"{edit.words}, blind repeat"
            project.undo()
        assert tuple(said(project.clicks.at(1)).values()) == first
        return found if made is not None else None

    head = replace(ELBOW, landmark="head")
    assert after(place(head))["head"].position == head.position
    moved = after(move_clicks((ELBOW.key, OTHER.key), (1.0, -1.0)))
    assert moved["left_elbow"].position == (13.0, 18.0)
    assert moved["right_elbow"].position is None
    assert "left_elbow" not in after(delete_clicks((ELBOW.key,)))
    assert after(delete_clicks((head.key,))) is None
    marked = after(mark_clicks((ELBOW.key,), visibility=Visibility.OUTSIDE))["left_elbow"]
    assert (marked.position, marked.visibility) == (None, Visibility.OUTSIDE)
    assert after(mark_clicks((ELBOW.key,), flag=UNCERTAIN, sigma=3.0))["left_elbow"].sigma == 3.0
    predicted = [Prediction(*key, "x", (5.0, 5.0)) for key in (ELBOW.key, head.key)]
    accepted = after(accept_points(tuple(predicted)))
    assert accepted["left_elbow"].origin == "hand"
    assert accepted["head"].origin == "accepted"
    swapped = after(swap_landmarks(1, "N_right", "left_elbow", "right_elbow"))
    assert swapped["right_elbow"].position == (12.0, 19.0)


def test_lanes_and_progress_follow_from_what_is_stored(project):
    assert project.progress().words() == "0 clicks, no keyframes set"
    far = replace(OTHER, frame=6, flag=UNCERTAIN)
    project.apply(place_clicks((ELBOW, OTHER, HIDDEN, far, replace(ELBOW, camera="N_left"))))
    project.apply(place(replace(OTHER, frame=5)))
    project.apply(delete_clicks((replace(OTHER, frame=5).key,)))
    project.apply(mark_keyframes((1, 2, 6, 7)))
    project.apply(mark_keyframes((1, 6), "done"))
    project.apply(flag_frames((FrameFlag(2), FrameFlag(3), FrameFlag(7))))
    project.apply(flag_frames((FrameFlag(7),), off=True))
    places = {(one.frame, one.landmark) for one in project.clicks.all()}
    assert [one[:2] for one in project.clicks.seen()] == sorted(places)
    assert project.clicks.seen(2, 7) == (Seen(6, "right_elbow", 1, True),)
    assert Seen(1, "left_elbow", 2, False) in project.clicks.seen(0, 2)
    assert project.clicks.doubted_frames() == {6}
    assert project.progress().words() == "2 of 4 keyframes done, 2 flagged"


class EditedProject(RuleBasedStateMachine):
    """A project against a list of states; hypothesis looks for edits on which they differ."""

    keys = st.builds(
        ClickKey,
        st.integers(0, 2),
        st.sampled_from(["N_right", "S_cam"]),
        st.sampled_from(["left_elbow", "right_elbow"]),
    )

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        path = Path(self.folder.name) / "some.stereotrack"
        make_database(path)
        self.project = Project.open(path)
        self.states: list[dict[ClickKey, Click]] = [{}]
        self.now = 0

    def after(self, state: dict[ClickKey, Click]) -> None:
        if state != self.states[self.now]:
            self.states[self.now + 1 :] = [state]
            self.now += 1

    @rule(keys=st.lists(keys, min_size=1, max_size=4, unique=True), x=st.floats(0, 63))
    def place(self, keys, x):
        clicks = [Click(*key, (x, 2.0)) for key in keys]
        self.project.apply(place_clicks(tuple(clicks)))
        self.after({**self.states[self.now], **{click.key: click for click in clicks}})

    @rule(keys=st.lists(keys, min_size=1, max_size=4, unique=True))
    def delete(self, keys):
        self.project.apply(delete_clicks(tuple(keys)))
        state = dict(self.states[self.now])
        for key in keys:
            if key in state:
                state[key] = replace(state[key], deleted=True)
        self.after(state)

    @rule(frame=st.integers(0, 2))
    def swap(self, frame):
        self.project.apply(swap_landmarks(frame, "N_right", "left_elbow", "right_elbow"))
        state = dict(self.states[self.now])
        keys = [ClickKey(frame, "N_right", f"{side}_elbow") for side in ("left", "right")]
        there = [state.get(key) for key in keys]
        there = [None if click is None or click.deleted else click for click in there]
        for key, own, other in zip(keys, there, there[::-1], strict=True):
            if other is not None:
                state[key] = replace(other, landmark=key.landmark)
            elif own is not None:
                state[key] = replace(own, deleted=True)
        self.after(state)

    @rule()
    def undo(self):
        assert (self.project.undo() is not None) == (self.now > 0)
        self.now = max(0, self.now - 1)

    @rule()
    def redo(self):
        assert (self.project.redo() is not None) == (self.now < len(self.states) - 1)
        self.now = min(len(self.states) - 1, self.now + 1)

    @invariant()
    def both_say_the_same(self):
        clicks = said(self.project.clicks.all(with_deleted=True))
        assert clicks == self.states[self.now]

    def teardown(self):
        self.project.close()
        self.folder.cleanup()


TestEditedProject = EditedProject.TestCase
TestEditedProject.settings = settings(max_examples=15, stateful_step_count=20)


def test_a_blind_repeat_says_nothing_of_what_was_only_accepted(project):
    project.apply(place(ELBOW))
    hand = ELBOW.key._replace(landmark="left_hand")
    project.apply(accept_points((Prediction(*hand, "run", (50.0, 60.0), 2.0),)))
    again = (replace(ELBOW, position=(11.0, 20.0)), replace(ELBOW, landmark="left_hand"))
    project.apply(blind_repeat(place_clicks(again)))
    assert [one.key for one in project.clicks.repeat_differences()] == [ELBOW.key]
