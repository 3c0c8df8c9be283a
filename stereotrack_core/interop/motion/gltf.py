"""glTF 2.0 in one binary file (``.glb``): the body as a moving model, for Blender and others.

https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html. The file is y-up in metres and the person
faces +Z when facing south: (X, Y, Z) = (x, z, -y) of this program's world, which a node named
``world`` does, so that everything below it is in the world's own axes. Each part of the body is a
node below its parent with its cones as a mesh, moved by one animation; each landmark is a node
without a mesh. Time is the recording's frame over the frame rate. The format has no missing values:
in frames that are not tracked the node ``person`` has the scale zero, so that nothing is seen.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import PARENTS, PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, fps_of_run, pose_of_run, upright_run

_FLOAT, _UNSIGNED = 5126, 5125  # component types
_VERTICES, _INDICES = 34962, 34963  # targets of buffer views
_Y_UP = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]  # a quarter turn about x, as x, y, z, w
_GREY = "#b4b4b4"


def write_glb(path: Path, run: Run, colours: Mapping[str, str]) -> None:
    """Write the movement of a run's body; `colours`: #rrggbb by limb, others are grey.

    InputError where no frame is tracked, the run's states are not those of a body, it does not
    state its frame rate, or the file cannot be written.
    """
    run = upright_run(run)
    fps = fps_of_run(run)
    poses = [pose_of_run(run, i) for i in range(len(run.frame))]
    tracked = [pose for pose in poses if pose is not None]
    if not tracked:
        raise InputError(
            "no frame of the run is tracked", where=str(path), remedy="Track it again first."
        )
    body = body_of_run(run)
    stack = Pose(
        np.stack([pose.position for pose in tracked]), np.stack([p.rotations for p in tracked])
    )
    scene = _Scene()
    person = scene.node("person", scene.node("world", None, rotation=_Y_UP))
    known = np.array([pose is not None for pose in poses])
    seconds = run.frame / fps
    times = scene.accessor(seconds[known].astype(np.float32), "SCALAR", bounds=True)
    _add_parts(scene, body, stack, person, times, colours)
    for k, name in enumerate(LANDMARKS):
        mark = scene.node(f"landmark {name}", person)
        scene.animate(mark, "translation", times, run.landmarks[known, k])
    _hide_gaps(scene, person, seconds, known)
    write_file(path, scene.encoded(path.stem))


def _add_parts(
    scene: _Scene,
    body: BodyModel,
    poses: Pose,
    person: int,
    times: int,
    colours: Mapping[str, str],
) -> None:
    """Nodes of the parts that have a surface, parents first, each moved against its parent."""
    frames = body.frames(poses)
    meshes: dict[int, list[PartMesh]] = {}
    for mesh in body_mesh(body, poses[0]):
        meshes.setdefault(mesh.part, []).append(mesh)
    rotations, origins = _relative(frames)
    nodes: dict[int, int] = {}
    for part, parent in enumerate(PARENTS):
        if part not in meshes:
            continue
        node = scene.node(PARTS[part], nodes.get(parent, person))
        nodes[part] = node
        vertices = np.concatenate([mesh.vertices for mesh in meshes[part]])
        local = (vertices - frames.origins[0, part]) @ frames.rotations[0, part]
        firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[part])])
        triangles = np.concatenate(
            [mesh.triangles + n for mesh, n in zip(meshes[part], firsts[:-1], strict=True)]
        )
        limb = meshes[part][0].limb
        scene.give_mesh(node, local, triangles, limb, colours.get(limb, _GREY))
        scene.animate(node, "rotation", times, _quaternions(rotations[:, part]))
        scene.animate(node, "translation", times, origins[:, part])


def _relative(frames: PartFrames) -> tuple[FloatArray, FloatArray]:
    """Rotations (F, P, 3, 3) and origins (F, P, 3) of all parts in their parents' frames."""
    rotations, origins = frames.rotations.copy(), frames.origins.copy()
    for part, parent in enumerate(PARENTS):
        if parent >= 0:
            turned = np.swapaxes(frames.rotations[:, parent], -1, -2)
            rotations[:, part] = turned @ frames.rotations[:, part]
            away = frames.origins[:, part] - frames.origins[:, parent]
            origins[:, part] = np.einsum("fij,fj->fi", turned, away)
    return rotations, origins


def _hide_gaps(scene: _Scene, person: int, seconds: FloatArray, known: NDArray[np.bool_]) -> None:
    """Scale the person to nothing where the pose is not known."""
    changes = np.flatnonzero(np.diff(known, prepend=~known[:1]))
    if known.all():
        return
    times = scene.accessor(seconds[changes].astype(np.float32), "SCALAR", bounds=True)
    sizes = np.repeat(known[changes].astype(np.float64)[:, None], 3, axis=1)
    scene.animate(person, "scale", times, sizes, "STEP")


def _quaternions(rotations: FloatArray) -> FloatArray:
    """Unit quaternions (F, 4), x y z w, each the nearer of the two to the one before it."""
    import scipy

    quaternions = scipy.spatial.transform.Rotation.from_matrix(rotations).as_quat()
    turns = np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1))
    signs = np.cumprod(np.concatenate([[1.0], np.where(turns < 0, -1.0, 1.0)]))
    result: FloatArray = quaternions * signs[:, None]
    return result


class _Scene:
    """A glTF document that grows, with its one buffer."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._lists: dict[str, list[dict[str, Any]]] = {}
        self._materials: dict[str, int] = {}

    def _add(self, name: str, /, **entry: Any) -> int:
        """Add an entry to one of the document's lists; its index."""
        entries = self._lists.setdefault(name, [])
        entries.append(entry)
        return len(entries) - 1

    def node(self, name: str, parent: int | None, **keywords: Any) -> int:
        """Add a node; its index."""
        index = self._add("nodes", name=name, **keywords)
        if parent is not None:
            self._lists["nodes"][parent].setdefault("children", []).append(index)
        return index

    def accessor(
        self, values: NDArray[Any], kind: str, *, target: int | None = None, bounds: bool = False
    ) -> int:
        """Add numbers, four bytes each, to the buffer; index of their accessor."""
        data = np.ascontiguousarray(values).tobytes()
        place = {"buffer": 0, "byteOffset": len(self._buffer), "byteLength": len(data)}
        view = self._add("bufferViews", **place, **({"target": target} if target else {}))
        self._buffer += data
        rows = values.reshape(len(values), -1)
        limits = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        number = _UNSIGNED if values.dtype == np.uint32 else _FLOAT
        return self._add(
            "accessors", bufferView=view, componentType=number, count=len(values), type=kind,
            **(limits if bounds else {}),
        )  # fmt: skip

    def animate(
        self, node: int, path: str, times: int, values: FloatArray, interpolation: str = "LINEAR"
    ) -> None:
        """Move a node through values (F, 3) or (F, 4)."""
        output = self.accessor(values.astype(np.float32), f"VEC{values.shape[1]}")
        sampler = self._add("samplers", input=times, output=output, interpolation=interpolation)
        self._add("channels", sampler=sampler, target={"node": node, "path": path})

    def give_mesh(
        self, node: int, vertices: FloatArray, triangles: NDArray[Any], limb: str, colour: str
    ) -> None:
        """Give a node a surface of vertices (V, 3) and triangles (T, 3)."""
        if limb not in self._materials:
            linear = [(int(colour[k : k + 2], 16) / 255.0) ** 2.2 for k in (1, 3, 5)]
            shine = {"metallicFactor": 0.0, "roughnessFactor": 0.9}
            surface = {"baseColorFactor": [*linear, 1.0], **shine}
            self._materials[limb] = self._add(
                "materials", name=limb, pbrMetallicRoughness=surface, doubleSided=True
            )
        places = self.accessor(vertices.astype(np.float32), "VEC3", target=_VERTICES, bounds=True)
        corners = self.accessor(triangles.astype(np.uint32).ravel(), "SCALAR", target=_INDICES)
        own = self._lists["nodes"][node]
        own["mesh"] = self._add("meshes", name=own["name"], primitives=[
            {"attributes": {"POSITION": places}, "indices": corners,
             "material": self._materials[limb]},
        ])  # fmt: skip

    def encoded(self, name: str) -> bytes:
        """The file."""
        lists = dict(self._lists)
        movement = {key: lists.pop(key) for key in ("samplers", "channels")}
        document = {
            "asset": {"version": "2.0", "generator": "stereotrack"},
            "scene": 0,
            "scenes": [{"nodes": [0], "name": name}],
            "buffers": [{"byteLength": len(self._buffer)}],
            "animations": [{"name": "movement", **movement}],
            **lists,
        }
        text = json.dumps(document, allow_nan=False).encode()
        parts = (text + b" " * (-len(text) % 4), b"JSON"), (bytes(self._buffer), b"BIN\0")
        chunks = [struct.pack("<I4s", len(data), kind) + data for data, kind in parts]
        return struct.pack("<4sII", b"glTF", 2, 12 + sum(map(len, chunks))) + b"".join(chunks)
