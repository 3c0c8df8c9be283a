"""The moving body as glTF, read back by VTK."""

import json
import struct

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOGeometry import vtkGLTFReader

from stereotrack_core.body.mesh import body_mesh
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.interop.motion.gltf import write_glb
from stereotrack_core.tracking.stored import body_of_run, pose_of_run


def surfaces_at(path, seconds):
    """Vertices (V, 3) of every surface at some time, in the file's order, by VTK."""
    reader = vtkGLTFReader()
    reader.SetFileName(str(path))
    reader.ApplyDeformationsToGeometryOn()
    reader.SetFrameRate(1000)
    reader.UpdateInformation()
    reader.EnableAnimation(0)
    reader.UpdateInformation()
    reader.UpdateTimeStep(seconds)
    blocks = reader.GetOutput().NewIterator()
    found = []
    blocks.InitTraversal()
    while not blocks.IsDoneWithTraversal():
        points = blocks.GetCurrentDataObject().GetPoints()
        found.append(vtk_to_numpy(points.GetData()).astype(float))
        blocks.GoToNextItem()
    return found


def content_of(path):
    """The JSON of the file."""
    data = path.read_bytes()
    magic, version, length, size, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    return json.loads(data[20 : 20 + size])


def depth_first(nodes, index=0):
    """Parts that have a surface, in the order in which VTK gives them."""
    own = [PARTS.index(nodes[index]["name"])] if "mesh" in nodes[index] else []
    return sum((depth_first(nodes, child) for child in nodes[index].get("children", ())), own)


def test_the_body_moves_as_in_the_run(tmp_path, random, body_run):
    run = body_run(random)
    write_glb(tmp_path / "a.glb", run, LIMB_COLOURS)
    body = body_of_run(run)
    for i in (0, 1, 5):
        expected = body_mesh(body, pose_of_run(run, i))
        found = surfaces_at(tmp_path / "a.glb", run.frame[i] / 10.0)
        assert len(found) == len({mesh.part for mesh in expected})
        there = np.concatenate(found)
        world = np.stack([there[:, 0], -there[:, 2], there[:, 1]], axis=1)
        order = depth_first(content_of(tmp_path / "a.glb")["nodes"])
        surface = [mesh.vertices for part in order for mesh in expected if mesh.part == part]
        np.testing.assert_allclose(world, np.concatenate(surface), atol=2e-5)


def test_nothing_is_seen_where_the_run_is_lost(tmp_path, random, body_run):
    run = body_run(random)
    write_glb(tmp_path / "a.glb", run, LIMB_COLOURS)
    for surface in surfaces_at(tmp_path / "a.glb", run.frame[2] / 10.0):
        assert np.ptp(surface, axis=0).max() < 1e-9
    assert not run.tracked[2]


def test_parts_are_below_their_parents_and_landmarks_are_named(tmp_path, random, body_run):
    run = body_run(random, untracked=())
    write_glb(tmp_path / "a.glb", run, LIMB_COLOURS)
    content = content_of(tmp_path / "a.glb")
    nodes = content["nodes"]
    parent = {nodes[k]["name"]: n["name"] for n in nodes for k in n.get("children", ())}
    assert parent["left_forearm"] == "left_upper_arm"
    assert parent["left_upper_arm"] == "torso"
    assert parent["landmark left_hand"] == parent["torso"] == "person"
    assert not [c for c in content["animations"][0]["channels"] if c["target"]["path"] == "scale"]
    colours = {
        one["name"]: one["pbrMetallicRoughness"]["baseColorFactor"] for one in content["materials"]
    }
    assert colours["left_forearm"][2] > colours["left_forearm"][0]  # a blue


def test_a_run_without_poses_is_refused(tmp_path, random, body_run, make_run):
    with pytest.raises(InputError, match="no frame of the run is tracked"):
        write_glb(tmp_path / "a.glb", body_run(random, untracked=range(6)), {})
    with pytest.raises(InputError, match="do not fit the body"):
        write_glb(tmp_path / "a.glb", make_run(random), {})
    assert not list(tmp_path.iterdir())
