"""What views see of a body, cast ray by ray, without the noise of stereo."""

import numpy as np

from stereotrack_core.body.model import placed_cones
from stereotrack_core.depth.cloud import Cloud, DepthGeometry, ViewDepth
from stereotrack_core.geometry.transform import RigidTransform
from tests.oracle.raycast import cast

WIDTH, HEIGHT, FOCAL = 400, 320, 400.0
WALL = 6.0
"""Range of the empty scene."""

EYES = {"N": (0.0, 3.0, 1.6), "E": (3.0, 0.3, 1.6), "S": (-0.3, -3.0, 1.6), "W": (-3.0, 0.0, 1.6)}


def looking(eye, at=(0.0, 0.0, 1.15)) -> RigidTransform:
    """world_from_camera of an upright camera."""
    z = np.subtract(at, eye)
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return RigidTransform(np.column_stack([x, np.cross(z, x), z]), np.array(eye))


def geometry_at(place: RigidTransform) -> DepthGeometry:
    """Stereo camera with a base line of 25 cm."""
    c_x, c_y = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
    return DepthGeometry(FOCAL, c_x, c_y, 0.25, 0.0, WIDTH, HEIGHT, place)


def solids(placed, wider=None):
    """Cones as plain tuples, each `wider` (C, 2) along its x and y."""
    wider = np.zeros((len(placed), 2)) if wider is None else wider
    x, y = wider.T
    r1, r2 = placed["r1"], placed["r2"]
    mean = 0.5 * (r1 + r2)
    s = (placed["flatness"] * mean + y) / (mean + x)
    turns, origins = placed["rotation"], placed["origin"]
    values = turns, origins, r1 + x, r2 + x, placed["height"], s, placed["round_end"]
    return list(zip(*values, strict=True))


def view_of(bodies, place) -> ViewDepth:
    """Exact ranges and outline of solids in front of a wall."""
    g = geometry_at(place)
    ranges = cast(bodies, g.focal, g.c_x, g.c_y, place, g.width, g.height)
    person = np.isfinite(ranges)
    range_z = np.where(person, ranges, WALL).astype(np.float32)
    return ViewDepth(g, range_z, person, person, person)


def cloud_seen(bodies, eyes="NESW") -> Cloud:
    """Cloud of some views without points."""
    depths = {name: view_of(bodies, looking(EYES[name])) for name in eyes}
    nobody = np.empty(0, dtype=np.int64)
    return Cloud(0, np.empty((0, 3)), nobody, np.empty((0, 2), np.int64), tuple(eyes), depths)


def cloud_of_body(body, pose, eyes="NESW", wider=None) -> Cloud:
    """What some views see of a body, whose outline is `wider` (C, 2) than its surface."""
    outline = body.cones["outline"] if wider is None else wider
    return cloud_seen(solids(placed_cones(body, body.frames(pose)), outline), eyes)
