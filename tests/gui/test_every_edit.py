"""Every edit, its undo and its redo, on every kind of frame: window, project and file agree."""

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from app.features.annotate.lanes import AnnotationLanes
from app.widgets.timeline.lanes import Mark
from stereotrack_core.annotation.click import UNCERTAIN, Click, Prediction, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import choose, save_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from tests.gui.hands import click, trigger, truth, view

pytestmark = pytest.mark.window

VIEWS = "NOSW"
CLICKED, PARTLY, EMPTY = 0, 1, 2
FRAMES = {"clicked": CLICKED, "partly": PARTLY, "proposed": EMPTY, "empty": EMPTY, "blind": CLICKED}
"""Every kind of frame, and which frame of the recording is one."""
COMMANDS = (
    *("accept_view", "accept_frame", "confirm", "delete_click"),
    *("delete_everywhere", "mark_seen", "mark_guessed", "mark_outside", "mark_uncertain"),
    *("nudge_right", "nudge_up_coarse", "annotate-clear", "annotate-gap", "annotate-no-gap"),
    *("annotate-flag", "annotate-unflag", "annotate-done", "annotate-not-done"),
    *("annotate-no-keyframes", "annotate-accept", "annotate-accept-fit", "undo", "redo"),
    "annotate-camera-2",
)
CLICKS = st.tuples(st.sampled_from(NINE.names), st.sampled_from(VIEWS))
EDITS = st.lists(st.one_of(CLICKS, st.sampled_from(COMMANDS)), min_size=1, max_size=4)
PLAIN = (Mark.NONE, Mark.INTERPOLATED, Mark.PROPOSED, Mark.MISSING)
"""Marks that say nothing of clicks."""


def places(window, frame, views=VIEWS, names=NINE.names):
    window.context.session.document.visit(frame)
    return [
        (frame, f"{name}_right", landmark, truth(window, landmark, name))
        for name in views
        for landmark in names
    ]


def fitted(window) -> Reference:
    """A reference as a fit of all frames would leave it."""
    truths = window.context.session.document.recording.reference
    count = len(truths.frame)
    return Reference(
        truths.frame, truths.points, np.tile(1e-4 * np.eye(3), (count, 9, 1, 1)),
        np.full((count, 6), 2.0), np.zeros(count, np.bool_),
    )  # fmt: skip


@pytest.fixture
def annotated(four, qtbot):
    """A window with frames of every kind, predictions and a reference."""
    project = four.context.session.project.project
    first, *others = (Click(*place) for place in places(four, PARTLY, "NO", NINE.names[:5]))
    outside = Click(*first.key, None, Visibility.OUTSIDE)
    guess, doubt = (Click(*one.key, one.position) for one in others[:2])
    guess = Click(*guess.key, guess.position, Visibility.GUESSED)
    doubt = Click(*doubt.key, doubt.position, flag=UNCERTAIN)
    every = [Click(*place) for place in places(four, CLICKED)]
    project.apply(place_clicks((*every, outside, guess, doubt, *others[2:])))
    project.apply(save_reference("fit", fitted(four)))
    project.apply(choose(REFERENCE, "fit"))
    found = [Prediction(*place[:3], "fit", place[3]) for place in places(four, EMPTY)]
    project.predictions.replace("fit", found)
    qtbot.waitUntil(four.context.tasks.settled)
    return four


def content(project):
    """All that edits have changed, and what undo and redo do next."""
    history = project.history
    return (
        project.clicks.all(with_deleted=True), project.clicks.again(), project.marks.flags(),
        (project.marks.keyframes(), project.marks.unused_cameras()), history.to_undo(),
        history.to_redo(),
    )  # fmt: skip


def check(window, qtbot):
    """Compare what is shown with what is in the file."""
    session, annotate = window.context.session, window.features.annotate
    document, annotating = session.document, annotate.clicking.annotating
    frame = document.frame
    qtbot.waitUntil(lambda: document.frame_set is not None)
    annotate.clicking.show()
    with Project.open(session.project.path, read_only=True) as file:
        assert content(session.project.project) == content(file)
        stored = file.clicks.again_at(frame) if annotating.blind() else file.clicks.at(frame)
        assert dict(annotating.clicks()) == {one.key: one for one in stored}
        for name in VIEWS:
            there = [one for one in stored if one.camera == f"{name}_right" and one.position]
            marks = {mark.landmark: (mark.x, mark.y) for mark in view(window, name).marks.clicks}
            assert marks == {one.landmark: one.position for one in there}
        lanes = AnnotationLanes(file, document.frame_count, len(VIEWS))
        assert marks_of(annotate.panels.lanes) == marks_of(lanes)
        following = session.edits.to_undo(), session.edits.to_redo()
        assert following == (file.history.to_undo(), file.history.to_redo())
    return content(session.project.project)


def check_progress(window, qtbot):
    """Compare what is said of the whole project with the file; it is said a moment later."""
    panels = window.features.annotate.panels
    qtbot.waitUntil(lambda: not panels._soon.isActive())
    with Project.open(window.context.session.project.path, read_only=True) as file:
        assert panels.bar.progress.text() == file.progress().words()


def marks_of(lanes):
    every = [lane.values for lane in lanes.lanes() if lane.kind == "marks"]
    return [np.where(np.isin(marks, PLAIN), Mark.NONE, marks).tolist() for marks in every]


def make(window, edit):
    """Click, or do what a command does where it can be done."""
    if isinstance(edit, tuple):
        landmark, name = edit
        window.features.annotate.clicking.annotating.choose(landmark)
        click(window, *truth(window, landmark, name), name)
        return
    if edit.startswith("nudge"):
        trigger(window, "pick_click")
    window.context.actions.refresh()
    window.context.actions.action(edit).trigger()  # where it cannot be done, nothing happens


def begin(window, qtbot, kind):
    """Show a frame of that kind, with its proposals."""
    window.context.session.document.visit(FRAMES[kind])
    if kind == "blind":
        window.features.annotate.panels.begin_repeat(CLICKED)
    clicking = window.features.annotate.clicking
    if kind == "proposed":
        qtbot.waitUntil(clicking.proposals.settled)


@pytest.mark.parametrize("examples", [3, pytest.param(100, marks=pytest.mark.slow)])
def test_window_project_and_file_agree_after_every_edit_its_undo_and_its_redo(
    annotated, qtbot, failures, examples
):
    window, steps = annotated, window_steps(annotated, qtbot)
    before = check(window, qtbot)

    @settings(
        derandomize=True, max_examples=examples, deadline=None, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(kind=st.sampled_from(sorted(FRAMES)), edits=EDITS)
    @example(kind="empty", edits=["accept_frame"])
    @example(kind="proposed", edits=["accept_frame", ("head", "N")])
    @example(kind="blind", edits=[("head", "N"), "delete_click"])
    def agree(kind, edits):
        begin(window, qtbot, kind)
        for edit in edits:
            if edit != "undo" or window.context.session.edits.to_undo() != before[4]:
                make(window, edit)
            check(window, qtbot)
        states = steps("undo", before)
        assert states[-1][:4] == before[:4]
        again = steps("redo", None)
        assert [state[:4] for state in again[: len(states)]] == [s[:4] for s in states[::-1]]
        steps("undo", before)
        window.features.annotate.panels.finish_repeat()
        assert not failures, [message.sentence() for message in failures]

    agree()


def window_steps(window, qtbot):
    """Function that undoes (until `before`) or redoes all, and gives the states on the way."""
    edits = window.context.session.edits

    def steps(way, before):
        states = [check(window, qtbot)]
        while True:
            entry = edits.to_undo() if way == "undo" else edits.to_redo()
            if entry is None or (before is not None and entry == before[4]):
                check_progress(window, qtbot)
                return states
            trigger(window, way)
            states.append(check(window, qtbot))

    return steps
