"""Runs, references, subjects, sets, parameters and corrections come back as they were saved."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.landmark_set import NINE, Landmark, LandmarkSet
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.project import entries
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import LANDMARK_SET, SUBJECT
from stereotrack_core.recording.description import Subject
from stereotrack_core.recording.landmarks import LANDMARKS

PERSON = Subject("P", shoulder_width=0.4, torso_length=0.5)


def reference(frames: int = 4) -> Reference:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(frames, 9, 3))
    points[1, 3] = np.nan
    return Reference(
        frame=np.arange(frames) * 2,
        points=points,
        covariance=rng.normal(size=(frames, 9, 3, 3)),
        filled=np.arange(frames) % 2 == 1,
        meta={"clicks": 17},
    )


def test_a_reference_comes_back_bit_by_bit(project, project_path):
    project.apply(entries.save_reference("mine", reference()))
    project.close()
    with Project.open(project_path) as again:
        assert dict(again.references.get("mine").facts) == {"frames": 4}
        found = entries.load_reference(again.references, "mine")
    for name in ("frame", "points", "covariance", "filled"):
        np.testing.assert_array_equal(getattr(found, name), getattr(reference(), name))
    assert found.limb_sigma_deg is None
    assert (found.landmark_names, dict(found.meta)) == (LANDMARKS, {"clicks": 17})


def test_a_reference_of_another_set_gives_the_landmarks_it_shares():
    names = ("left_wrist", "head")
    points = np.arange(12.0).reshape(2, 2, 3)
    trajectory = Reference(np.array([3, 5]), points, landmark_names=names).trajectory()
    known = np.isfinite(trajectory.points).all(axis=(0, 2))
    assert [name for name, is_known in zip(LANDMARKS, known, strict=True) if is_known] == ["head"]
    np.testing.assert_array_equal(trajectory.points[:, LANDMARKS.index("head")], points[:, 1])


def test_subjects_are_saved_chosen_and_taken_away(project):
    assert project.subject() is None
    project.apply(entries.save_subject(PERSON))
    project.apply(entries.choose(SUBJECT, "P"))
    assert project.subject() == PERSON
    assert project.history.to_undo().words == "use subject P"
    assert project.apply(entries.save_subject(PERSON)) is None
    longer = replace(PERSON, torso_length=0.55)
    project.apply(entries.save_subject(longer, origin="measured from clicks"))
    assert project.subject() == longer
    assert project.subjects.get("P").facts["origin"] == "measured from clicks"
    project.undo()
    assert entries.load_subject(project.subjects, "P") == PERSON
    project.apply(entries.delete_entry(SUBJECT, "P"))
    assert project.subject() is None
    with pytest.raises(InputError, match="no subject 'P'"):
        project.apply(entries.choose(SUBJECT, "P"))
    with pytest.raises(InputError, match="has no name"):
        project.apply(entries.save_entry(SUBJECT, " ", "{}"))


def test_the_nine_landmarks_are_there_without_saying_so(project):
    assert project.landmark_set() == NINE
    wrist = Landmark("left_wrist", "#112233", "left_forearm", "left_forearm", along=0.7)
    longer = LandmarkSet("with wrist", (*NINE.landmarks, wrist))
    project.apply(entries.save_landmark_set(longer))
    project.apply(entries.choose(LANDMARK_SET, "with wrist"))
    assert project.landmark_set() == longer
    project.apply(entries.choose(LANDMARK_SET, None))
    assert project.landmark_set() == NINE


def test_view_settings_are_kept_but_are_no_edits(project, project_path):
    project.view_settings.set("frame", 17)
    project.view_settings.set("switches", {"epipolar": True})
    project.view_settings.set("frame", None)
    project.close()
    with Project.open(project_path, read_only=True) as again:
        assert again.view_settings.get("switches") == {"epipolar": True}
        assert again.view_settings.get("frame", 0) == 0
        assert again.history.entries() == ()
        with pytest.raises(InputError, match="write-protected"):
            again.view_settings.set("frame", 3)
