"""Errors of a run against the recording's or the project's reference, and how good that is."""

from dataclasses import replace

import numpy as np
import pytest

from app.features.review.feature import heading_words, lanes_of
from app.features.track.comparison import compared
from app.features.track.controller import number_rows
from app.session.judgement import judged, project_truth, recorded_truth, score_words
from app.session.runs import RunEntry, entry_of_run
from app.session.session import Snapshot
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.accuracy import reference_quality
from stereotrack_core.project.entries import choose, save_reference
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.gui.hands import trigger

FRAMES = 8


def snapshot_of(entry, judgement, frame):
    """What panels are shown of a frame of a run."""
    return Snapshot(frame=frame, active=entry, judgements={entry: judgement})


def stating(trajectory: LandmarkTrajectory, shift=0.0, sigma=None) -> Reference:
    """A reference beside a trajectory that says how good it is, frame by frame."""
    count = len(trajectory.frame)
    angles = np.full((count, 6), 2.0) if sigma is None else sigma
    covariance = np.tile(1e-4 * np.eye(3), (count, 9, 1, 1))
    return Reference(trajectory.frame, trajectory.points + shift, covariance, angles)


@pytest.fixture(scope="module")
def tracked(small_recording, tmp_path_factory):
    """The recording, and a run of it read from a file."""
    recording = open_recording(small_recording)
    settings = preset("fast").replaced(fit_shape=False, second_look=0, least_focal=0.0)
    return recording, track(recording, RunSpec(settings, preset="fast", init="tpose"))


@pytest.fixture
def entry(tracked, tmp_path) -> RunEntry:
    return entry_of_run(tracked[1], tmp_path / "run.npz")


def test_every_number_says_how_good_the_reference_is_there(tracked, entry):
    sigma = np.full((FRAMES, 6), 2.0)
    sigma[3] = 7.0
    sigma[5, LIMBS.index("left_forearm")] = np.nan
    reference = stating(tracked[0].reference, sigma=sigma)
    found = judged(entry.now(), project_truth("mine", reference))
    values = {row[1]: row[2] for row in number_rows(snapshot_of(entry, found, 3))}
    assert "°, reference uncertainty 7.0  (±" in values["left forearm"]
    assert values["torso position"].endswith("mm, reference uncertainty 17")
    values = {row[1]: row[2] for row in number_rows(snapshot_of(entry, found, 5))}
    assert "reference" not in values["left forearm"], "it does not say there"
    assert "reference uncertainty 2.0" in values["torso"]
    whole = reference_quality(reference, np.arange(FRAMES))
    shown = compared((entry,), found, None)
    assert shown.words.endswith("of the run, against the project's reference “mine”.")
    good = f"left upper arm [°], reference uncertainty {whole['left_upper_arm']:.1f}"
    assert good in [row[0].text for row in shown.rows]
    part = compared((entry,), found, range(3, 4))
    labelled = [row[0].text for row in part.rows]
    assert "left upper arm [°], reference uncertainty 7.0" in labelled
    lane = lanes_of(found, FRAMES, (), None)[0]
    assert lane.value_text(1).endswith(f"°, reference uncertainty {whole['torso_long']:.1f}")
    arms = [
        whole[f"{side}_{part}"] for side in ("left", "right") for part in ("forearm", "upper_arm")
    ]
    good = np.sqrt(np.mean(np.square(arms)))
    assert score_words(found).endswith(f"°, reference uncertainty {good:.1f}")
    assert heading_words(found)[0] == f"angular error, reference uncertainty {good:.1f}° (arms)"


def test_a_reference_that_does_not_say_how_good_it_is_leaves_the_error_alone(tracked, entry):
    for truth in (
        recorded_truth(tracked[0].reference),
        project_truth("bare", Reference(tracked[0].reference.frame, tracked[0].reference.points)),
    ):
        found = judged(entry.now(), truth)
        assert found.measure == "error"
        assert "uncertainty" not in score_words(found)
        assert not any("uncertainty" in row[2] for row in number_rows(snapshot_of(entry, found, 3)))
        assert heading_words(found)[2].endswith("whose uncertainty is not known.")
    assert judged(entry.now(), None).quality == {}


def triggered(window, qtbot, name):
    trigger(window, name, qtbot)


def bring_up(window, qtbot, panel):
    window.context.docks.bring_up(panel)
    qtbot.waitUntil(window.context.tasks.settled)


def labels(window, qtbot):
    bring_up(window, qtbot, "comparison")
    return [row[0].text for row in window.features.track.comparison.table.cells.rows]


@pytest.mark.window
def test_the_person_chooses_what_errors_are_measured_against(annotating, qtbot, entry):
    window, project = annotating, annotating.context.session.project.project
    window.context.session.runs.add(entry)
    qtbot.waitUntil(window.context.tasks.settled)
    recorded = window.context.session.document.recording.reference
    command = window.context.actions.command
    assert (
        command("errors_against_project").why_not()
        == "The whole recording has not been fitted yet. Choose Fit whole recording first."
    )
    assert command("errors_against_recording").checked()
    assert "torso long axis [°]" in labels(window, qtbot)
    by_recording = window.context.session.judging.of(entry).limbs["left_forearm"]
    turned = stating(recorded)
    points = turned.points.copy()
    points[:, 4] += (0.0, 0.0, 0.1)
    project.apply(save_reference("by hand", replace(turned, points=points)))
    project.apply(choose(REFERENCE, "by hand"))
    qtbot.waitUntil(lambda: window.context.session.judging.has("project"))
    qtbot.waitUntil(window.context.tasks.settled)
    assert (
        window.features.annotate.panels.reference.now.words
        == "“by hand”: 8 frames, arm uncertainty 2.0°."
    )
    assert command("errors_against_recording").checked(), "what came with the recording goes first"
    triggered(window, qtbot, "errors_against_project")
    assert command("errors_against_project").checked()
    assert "torso long axis [°], reference uncertainty 2.0" in labels(window, qtbot)
    assert (
        "against the project's reference “by hand”" in window.features.track.comparison.words.text()
    )
    bring_up(window, qtbot, "numbers")
    assert "reference uncertainty 2.0" in window.features.track.numbers.table.copied_text()
    assert window.features.review.plot.plot._heading.toolTip().startswith(
        "Against the project's reference “by hand”"
    )
    assert window.features.track.panel.tree.topLevelItem(0).text(2).endswith("± 2.0")
    limbs = window.context.session.judging.of(entry).limbs
    moved = {limb for limb, values in limbs.items() if not np.allclose(
        values, judged(entry.now(), recorded_truth(recorded)).limbs[limb], equal_nan=True
    )}  # fmt: skip
    assert moved, "another reference gives other errors"
    triggered(window, qtbot, "errors_against_recording")
    np.testing.assert_array_equal(
        window.context.session.judging.of(entry).limbs["left_forearm"], by_recording
    )
    triggered(window, qtbot, "errors_against_project")
    folder = window.context.session.document.recording.folder
    triggered(window, qtbot, "close")
    window.context.session.open(folder)
    qtbot.waitUntil(lambda: window.context.session.judging.has("project"))
    qtbot.waitUntil(window.context.tasks.settled)
    assert window.context.session.judging.truth.against == "project", "it is kept with the project"
