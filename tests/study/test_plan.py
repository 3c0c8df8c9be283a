"""Identities of jobs: equal where the result is, different where it may be."""

import dataclasses

from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.study import run as plan_module
from stereotrack_core.study.points import Point, grid_points, parsed_axis
from tests.study.conftest import SMALL


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
