"""Recordings of Rerun, read back by its own reader."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.motion.rerun import SeenFrame, write_rerun
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.tracking.stored import body_of_run, pose_of_run


@pytest.fixture
def recording(tmp_path):
    lens = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    place = RigidTransform(np.eye(3), np.array([0.0, 0.0, 3.0]))
    camera = Camera("S", 64, 48, lens, np.zeros(5), False, place)
    return Recording(
        tmp_path, "walk", 10.0, (View("S", "mono", Stream("S", "%d.png")),), {"S": camera}
    )


def frames_of(run):
    image = np.zeros((48, 64), np.uint8)
    for frame in run.frame.tolist():
        points = np.full((4, 3), float(frame))
        cloud = Cloud(frame, points, np.zeros(4, int), np.zeros((4, 2), int), ("S",), {})
        yield SeenFrame(frame, {"S": image}, cloud)


def column(path, entity, name):
    """Values of one component of an entity with the frames they are logged at."""
    chunk = pytest.importorskip("rerun.chunk")
    found = []
    for one in chunk.RrdReader(str(path)).stream():
        batch = one.to_record_batch()
        if one.entity_path == entity and name in batch.schema.names:
            frames = batch.column("frame").to_pylist() if "frame" in batch.schema.names else [None]
            found += zip(frames, batch.column(name).to_pylist(), strict=True)
    return found


def test_images_cloud_and_model_of_every_frame(tmp_path, random, body_run, recording):
    pytest.importorskip("rerun")
    run = body_run(random)
    path = tmp_path / "a.rrd"
    assert write_rerun(path, run, recording, frames_of(run), {"torso": "#ff0000"}) == 6
    torso = dict(column(path, "/world/body/torso", "Transform3D:translation"))
    assert sorted(torso) == [4, 5, 7, 8, 9]
    origin = body_of_run(run).frames(pose_of_run(run, 3)).origins[0]
    np.testing.assert_allclose(torso[7][0], origin, atol=1e-6)
    assert [frame for frame, _ in column(path, "/world/body", "Clear:is_recursive")] == [6]
    cloud = dict(column(path, "/world/cloud", "Points3D:positions"))
    np.testing.assert_allclose(cloud[9], np.full((4, 3), 9.0))
    marks = dict(column(path, "/world/landmarks", "Points3D:positions"))
    assert [len(marks[frame]) for frame in (5, 6)] == [9, 0]
    assert len(column(path, "/world/cameras/S/image", "EncodedImage:blob")) == 6
    (placed,) = column(path, "/world/cameras/S", "Transform3D:translation")
    np.testing.assert_allclose(placed[1][0], [0, 0, -3])


def test_stopping_and_errors_leave_nothing(tmp_path, random, body_run, recording, monkeypatch):
    pytest.importorskip("rerun")
    run = body_run(random)

    def stopped():
        yield next(frames_of(run))
        raise Cancelled

    before = sorted(tmp_path.iterdir())
    with pytest.raises(Cancelled):
        write_rerun(tmp_path / "a.rrd", run, recording, stopped(), {})
    strange = replace(run, state_names=tuple(f"s{k}" for k in range(run.x.shape[1])))
    with pytest.raises(InputError, match="do not fit the body"):
        write_rerun(tmp_path / "a.rrd", strange, recording, frames_of(run), {})
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(InputError, match="rerun-sdk, which is not installed"):
        write_rerun(tmp_path / "a.rrd", run, recording, frames_of(run), {})
    assert sorted(tmp_path.iterdir()) == before
