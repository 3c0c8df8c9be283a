"""Descriptions of studies, points of their grids, and the jobs that they ask for."""

import dataclasses
import shutil

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.project.project import Project
from stereotrack_core.study import run as plan_module
from stereotrack_core.study.description import (
    Study,
    StudyRecording,
    StudySettings,
    read_study,
    selected,
    with_recordings,
    write_study,
)
from stereotrack_core.study.points import Axis, Point, grid_points, parsed_axis
from tests.study.conftest import SMALL

ROWS = tuple(
    StudyRecording(f"data/{subject}/{speed}", factors={"subject": subject, "speed": speed})
    for subject in ("anna", "ben")
    for speed in ("slow", "fast")
)


@pytest.fixture
def made(tmp_path):
    return Study(tmp_path / "walks.study.toml", ROWS)


@pytest.mark.parametrize(
    "settings",
    [
        StudySettings(),
        StudySettings(
            preset="fast",
            changes=("iterations=3", "fit_shape=no", "loss_scale=0.0375"),
            grid=("views=NS,NOSW", "smooth=yes,no"),
            seeds="0,3",
            frames="0:20",
            init="tpose",
        ),
    ],
)
def test_what_is_written_is_read_again(made, settings):
    odd = StudyRecording("data/x", "p, q.stereotrack", "k.csv", {"subject": 'a "b" = 1'})
    study = dataclasses.replace(made, rows=(*ROWS, odd), settings=settings)
    write_study(study)
    assert read_study(study.path) == study


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("sedes = [1]", "unknown key 'sedes'"),
        ("[settings]\nitertions = 2", "unknown parameter"),
        ('preset = "none"', "accurate, thesis, fast"),
        ('[[recording]]\nsubject = "anna"', "has no folder"),
        ('[[recording]]\nrecording = "r"\nvalue = 1', "a column of the results"),
        ('[[recording]]\nrecording = "r"\n[[recording]]\nrecording = "./r"', "listed twice"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(made, text, what):
    made.path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=what) as refused:
        read_study(made.path)
    assert refused.value.remedy
    assert "walks.study.toml" in refused.value.where


@pytest.mark.parametrize(
    ("select", "expected"),
    [
        ([], ["anna/slow", "anna/fast", "ben/slow", "ben/fast"]),
        (["speed=slow", "subject=b*"], ["ben/slow"]),
        (["speed=slow,fast", "subject=ben"], ["ben/slow", "ben/fast"]),
    ],
)
def test_rows_are_selected_by_their_columns(made, select, expected):
    found = [row.recording.removeprefix("data/") for row in selected(made, select)]
    assert found == expected


def test_listing_again_adds_what_is_new_and_keeps_what_a_person_wrote(study, tmp_path):
    first = study.rows[0]
    written = dataclasses.replace(first, factors={"subject": "Anna B", "shoes": "old"})
    study = dataclasses.replace(study, rows=(*study.rows[:0:-1], written))
    shutil.copytree(tmp_path / "data/ben/slow", tmp_path / "data/ben/fast")
    Project.create(tmp_path / "data/ben/fast.stereotrack", tmp_path / "data/ben/fast").close()

    made = with_recordings(study, [tmp_path / "data"])
    assert made.added == ("data/ben/fast",)
    rows = {row.recording: row for row in made.study.rows}
    assert list(rows)[:3] == [row.recording for row in study.rows]
    assert rows[first.recording] == written
    assert rows["data/ben/fast"].project == "data/ben/fast.stereotrack"


def test_values_are_read_by_their_rows():
    assert parsed_axis("model_points=24, 40") == Axis("model_points", (24, 40))
    assert parsed_axis("fit_shape=no,yes").values == (False, True)
    assert parsed_axis("views=NS,cam_0+cam_2").values == ("NS", "cam_0+cam_2")
    assert parsed_axis("smooth=yes,no").values == (True, False)
    assert parsed_axis("frames=0:20,20:").values == ("0:20", "20:")
    assert parsed_axis("seed=0,3").values == (0, 3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("model_points", "cannot be read"),
        ("model_points=1", "from 4"),
        ("model_points=24,24", "twice"),
        ("model_pionts=3", "Did you mean model_points[?] docs"),
        ("preset=best", "accurate, thesis, fast"),
        ("seed=-1", "from 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parsed_axis(text)


def test_a_grid_is_every_combination():
    points = grid_points([parsed_axis("model_points=24,40"), parsed_axis("views=N,S,NS")])
    assert len(points) == len(set(points)) == 6
    assert points[1] == Point((("model_points", 24), ("views", "S")))
    assert points[1].parameters == {"model_points": 24}
    assert points[1].special("views") == "S"
    assert points[1].special("preset") is None
    assert grid_points([]) == (Point(),)


def identity(plan, *values, **changes):
    (job,) = plan(Point(values), **changes)
    return job.identity


def test_jobs_are_recordings_times_points_times_seeds(plan):
    points = grid_points([parsed_axis("iterations=2,3"), parsed_axis("views=N,NS")])
    jobs = plan(*points, seeds=(0, 1))
    assert len(jobs) == len({job.identity for job in jobs}) == 8
    first = [(job.spec.settings.tracking.iterations, job.views, job.spec.seed) for job in jobs[:3]]
    assert first == [(2, ("N",), 0), (2, ("N",), 1), (2, ("N", "S"), 0)]
    assert len({job.clouds for job in jobs}) == 2


def test_the_same_work_said_otherwise_is_the_same_job(plan, copied):
    same = identity(plan, ("iterations", 3), ("views", "NS"))
    assert identity(plan, ("views", "S+N"), changes={**SMALL, "iterations": 3}) == same
    assert identity(plan, ("iterations", 3), views="NS") == same
    assert identity(plan, ("iterations", 3), ("views", "NS"), ("seed", 0), seeds=(5,)) == same
    assert identity(plan, ("iterations", 3), ("views", "NS"), recording=copied.open()) == same


def test_whatever_changes_the_result_changes_the_identity(plan, cones, copied, monkeypatch):
    found = [
        identity(plan),
        identity(plan, ("iterations", 2)),
        identity(plan, ("outlier_distance", 50.0)),
        identity(plan, ("preset", "accurate")),
        identity(plan, ("views", "NS")),
        identity(plan, ("frames", "1:4")),
        identity(plan, ("init", "auto")),
        identity(plan, ("smooth", True)),
        identity(plan, ("seed", 1)),
    ]
    camera = cones.cameras["N"]
    moved = RigidTransform(
        camera.camera_from_world.rotation, camera.camera_from_world.translation + 1e-6
    )
    cameras = {**cones.cameras, "N": dataclasses.replace(camera, camera_from_world=moved)}
    found.append(identity(plan, recording=dataclasses.replace(cones, cameras=cameras)))
    taller = dataclasses.replace(cones.subject, torso_length=0.6)
    found.append(identity(plan, recording=dataclasses.replace(cones, subject=taller)))
    mended = dataclasses.replace(cones.reference, points=cones.reference.points + 0.001)
    found.append(identity(plan, recording=dataclasses.replace(cones, reference=mended)))
    found.append(identity(plan, recording=dataclasses.replace(cones, reference=None)))
    (copied.folder / "detections.csv").write_text("frame,view,kind,x,y,z,sigma,confidence\n")
    found.append(identity(plan, recording=copied.open()))
    picture = copied.folder / "N_depth" / "0000.png"
    picture.write_bytes(picture.read_bytes() + b" ")
    found.append(identity(plan, recording=copied.open()))
    monkeypatch.setattr(plan_module, "__version__", "0.0.0-other")
    found.append(identity(plan))
    assert len(set(found)) == len(found)
