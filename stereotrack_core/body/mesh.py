"""The body's surface as triangles, for drawing."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, PlacedCones, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import limb_of_part


@dataclass(frozen=True, eq=False)
class PartMesh:
    """A cone as triangles of vertices (V, 3), world, metres; counter-clockwise from outside."""

    limb: str
    part: int
    vertices: FloatArray
    triangles: IntArray


def body_mesh(body: BodyModel, pose: Pose, *, around: int = 24) -> tuple[PartMesh, ...]:
    """Surface of the body in one pose without the legs, a mesh for each cone."""
    placed = placed_cones(body, body.frames(pose))
    return tuple(_cone_mesh(cone, around) for cone in placed if limb_of_part(cone["part"]))


def _cone_mesh(cone: PlacedCones, around: int) -> PartMesh:
    r1, r2, height, part = cone["r1"], cone["r2"], cone["height"], int(cone["part"])
    end = [(0.0, height)]
    if cone["round_end"]:
        quarter = np.linspace(0.0, 0.5 * np.pi, 5)[1:]
        end = [(r2 * np.cos(a), height + r2 * np.sin(a)) for a in quarter]
    # Radius and height (K, 2) from the base's centre to the end's centre.
    profile = np.array([(0.0, 0.0), (r1, 0.0), (r2, height), *end])
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    x = profile[:, :1] * np.cos(angle)
    y = cone["flatness"] * profile[:, :1] * np.sin(angle)
    rings = np.stack([x, y, np.broadcast_to(profile[:, 1:], x.shape)], axis=-1)
    vertices = rings.reshape(-1, 3) @ cone["rotation"].T + cone["origin"]
    return PartMesh(limb_of_part(part), part, vertices, _triangles_of_rings(len(profile), around))


@cache  # as long to make as all the rest of a mesh
def _triangles_of_rings(rings: int, around: int) -> IntArray:
    here = np.arange(around)
    beside, rows = (here + 1) % around, list[IntArray]()
    for low in range(0, (rings - 1) * around, around):
        high = low + around
        rows.append(np.stack([low + here, low + beside, high + beside], axis=1))
        rows.append(np.stack([low + here, high + beside, high + here], axis=1))
    return np.concatenate(rows)
