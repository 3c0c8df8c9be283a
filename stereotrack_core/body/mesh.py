"""The body's surface as triangles, for drawing."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, PlacedCones, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS, limb_of_part


@dataclass(frozen=True, eq=False)
class PartMesh:
    """A cone as triangles of vertices (V, 3), world, metres; counter-clockwise from outside."""

    limb: str
    part: int
    vertices: FloatArray
    triangles: IntArray


def body_mesh(
    body: BodyModel, pose: Pose, *, around: int = 24, limbs: tuple[str, ...] = PARTS[:6]
) -> tuple[PartMesh, ...]:
    """Surface of the body in one pose, a mesh for each cone of the named parts."""
    placed = placed_cones(body, body.frames(pose))
    names = [limb_of_part(part) or PARTS[part] for part in body.cones["part"].tolist()]
    return tuple(_cone_mesh(placed, c, around) for c, name in enumerate(names) if name in limbs)


def _cone_mesh(placed: PlacedCones, c: int, around: int) -> PartMesh:
    profile = _profile(placed, c)
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    radius, z = profile[:, :1], profile[:, 1:]
    flat = placed["flatness"][c]
    rings = np.stack(
        [
            radius * np.cos(angle),
            flat * radius * np.sin(angle),
            np.broadcast_to(z, (len(profile), around)),
        ],
        axis=-1,
    )
    local = rings.reshape(-1, 3)
    vertices = local @ placed["rotation"][c].T + placed["origin"][c]
    part = int(placed["part"][c])
    triangles = _triangles_of_rings(len(profile), around)
    return PartMesh(limb_of_part(part) or PARTS[part], part, vertices, triangles)


def _profile(placed: PlacedCones, c: int) -> FloatArray:
    """Radius and height (K, 2) from the base's centre to the end's centre."""
    cone = placed[c]
    r1, r2, height = cone["r1"], cone["r2"], cone["height"]
    quarter = np.linspace(0.0, 0.5 * np.pi, 5)
    base = [(0.0, 0.0)]
    if cone["round_base"]:
        base = [(r1 * np.sin(a), -r1 * np.cos(a)) for a in quarter[:-1]]
    end = [(0.0, height)]
    if cone["round_end"]:
        end = [(r2 * np.cos(a), height + r2 * np.sin(a)) for a in quarter[1:]]
    return np.array([*base, (r1, 0.0), (r2, height), *end])


def _triangles_of_rings(rings: int, around: int) -> IntArray:
    here = np.arange(around)
    beside = (here + 1) % around
    rows = []
    for ring in range(rings - 1):
        low, high = ring * around, (ring + 1) * around
        rows.append(np.stack([low + here, low + beside, high + beside], axis=1))
        rows.append(np.stack([low + here, high + beside, high + here], axis=1))
    return np.concatenate(rows).astype(np.int64)
