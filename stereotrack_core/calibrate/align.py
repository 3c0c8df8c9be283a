"""Turn a calibration's world so that z is up, y north, and the origin stands on the floor.

Every function returns new_from_old; :func:`aligned` applies it to the cameras.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import Sightings, nearest_to_rays, point_of_sightings
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS

ORIGIN, NORTH, FLOOR = POINTS = "origin", "north", "floor"
"""Names of the three points that are clicked: the origin, one north of it, a third on the floor."""

_TRIALS, _SEED = 500, 0
_ON_FLOOR_M = 0.03
_LEAST_FLOOR = 500  # points
_LEAST_SHARE = 0.08  # of all points that lie on the floor at least
_MOST_TILT = np.radians(60.0)  # between a camera's upright and the floor's normal
_LEAST_POINT_M = 0.1  # from the line through the other two
_HIP_HEIGHT = 1.84
"""Height of the hip joints over the torso's length: 0.530 over 0.818 - 0.530 of the body height (D.
A. Winter, Biomechanics and Motor Control of Human Movement, figure 4.1)."""

_LEAST_STANDING = 0.8  # mean of the torso's unit vectors; less is no standing person


@dataclass(frozen=True, eq=False)
class Alignment:
    """Alignment of the world; `spread_m` along z of its points or frames, NaN if unknown."""

    new_from_old: RigidTransform
    source: str
    points: int
    spread_m: float

    @property
    def tilt_deg(self) -> float:
        """Angle between the old z axis and the new one."""
        cosine = self.new_from_old.rotation[2, 2]
        return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))

    @property
    def heading_deg(self) -> float:
        """Angle about the new z axis from the old y axis to the new one, -180 to 180."""
        across, along = self.new_from_old.rotation[0, 1], self.new_from_old.rotation[1, 1]
        return float(np.degrees(np.arctan2(across, along)))

    @property
    def moved_m(self) -> float:
        """Distance from the old origin to the new one."""
        return float(np.linalg.norm(self.new_from_old.translation))


def aligned(cameras: Cameras, new_from_old: RigidTransform) -> dict[str, Camera]:
    """The same cameras in the new world."""
    old_from_new = new_from_old.inverse()
    places = {name: one.camera_from_world @ old_from_new for name, one in cameras.items()}
    return {name: replace(cameras[name], camera_from_world=at) for name, at in places.items()}


def world_of_axes(up: FloatArray, north: FloatArray, origin: FloatArray) -> RigidTransform:
    """new_from_old with z along `up` and y as near to `north` as can be. Raises InputError."""
    z = up / np.linalg.norm(up)
    y = north - (north @ z) * z
    length = float(np.linalg.norm(y))
    if not length > 1e-3 * float(np.linalg.norm(north)):
        what = "north cannot be told from up"
        raise InputError(what, "north", "Choose a direction along the floor.")
    y = y / length
    rotation = np.stack([np.cross(y, z), y, z])
    return RigidTransform(rotation, -rotation @ origin)


def from_floor(points: FloatArray, cameras: Sequence[Camera], north: Camera) -> Alignment:
    """The largest plane of points (N, 3) below upright cameras is the floor.

    The origin is where the cameras' common gaze meets it; `north` is the camera in the north.
    Raises InputError.
    """
    known = points[np.isfinite(points).all(axis=1)]
    plane = _floor(known, cameras)
    if plane is None:
        textured = "Use a frame in which much of the floor is seen, and has texture"
        remedy = f"{textured}; or lay the board on it."
        raise InputError("no floor was found in the depth images", "--floor", remedy)
    up, height, on_floor = plane
    spread = float(np.std(known[on_floor] @ up - height))
    centre = _common_gaze(cameras)
    origin = centre - (centre @ up - height) * up
    # a camera in the north looks south
    world = world_of_axes(up, -north.camera_from_world.rotation[2], origin)
    return Alignment(world, "floor", int(on_floor.sum()), spread)


def _floor(
    points: FloatArray, cameras: Sequence[Camera]
) -> tuple[FloatArray, float, BoolArray] | None:
    """Normal (3,), height along it and the points on it, or None (RANSAC, Fischler 1981)."""
    if len(points) < _LEAST_FLOOR:
        return None
    rng = np.random.default_rng(_SEED)
    some = points[rng.choice(len(points), min(len(points), 4000), replace=False)]
    upright = np.mean([-camera.camera_from_world.rotation[1] for camera in cameras], axis=0)
    places = np.array([camera.position_world for camera in cameras])
    best, most = None, 0
    for _ in range(_TRIALS):
        a, b, c = some[rng.choice(len(some), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = float(np.linalg.norm(normal))
        if length < 1e-6:
            continue
        normal *= np.sign(normal @ upright) / length
        if normal @ upright < np.cos(_MOST_TILT) * np.linalg.norm(upright):
            continue
        above = some @ normal - a @ normal
        if (places @ normal - a @ normal).min() < 10 * _ON_FLOOR_M:
            continue
        count = int((np.abs(above) < _ON_FLOOR_M).sum()) - int((above < -3 * _ON_FLOOR_M).sum())
        if count > most:
            best, most = (normal, float(a @ normal)), count
    if best is None or most < _LEAST_SHARE * len(some):
        return None
    normal, height = best
    for _ in range(5):
        near = np.abs(points @ normal - height) < _ON_FLOOR_M
        middle = points[near].mean(axis=0)
        _, _, axes = np.linalg.svd(points[near] - middle, full_matrices=False)
        normal = axes[2] * np.sign(axes[2] @ normal)
        height = float(middle @ normal)
    return normal, height, np.abs(points @ normal - height) < _ON_FLOOR_M


def _common_gaze(cameras: Sequence[Camera]) -> FloatArray:
    """The point (3,) nearest to all optical axes; 2 m ahead where they are parallel."""
    places = np.array([camera.position_world for camera in cameras])
    axes = np.array([camera.camera_from_world.rotation[2] for camera in cameras])
    point = nearest_to_rays(places, axes)
    ahead = np.einsum("ci,ci->c", point - places, axes)
    if np.isfinite(point).all() and (ahead > 0).all() and (ahead < 20).all():
        return point
    return np.asarray((places + 2.0 * axes).mean(axis=0), dtype=np.float64)


def from_board(old_from_board: RigidTransform, corners: FloatArray) -> Alignment:
    """The board lies on the floor; where its upper side points is north, its middle the origin."""
    up, north = -old_from_board.rotation[:, 2], -old_from_board.rotation[:, 1]
    origin = old_from_board.apply(corners.mean(axis=0))
    return Alignment(world_of_axes(up, north, origin), "board", len(corners), float("nan"))


def from_cameras(new: Cameras, old: Cameras) -> Alignment:
    """Lay cameras over those of the same names in another calibration, whose world is kept.

    By least squares (Kabsch), from the world of `new` to that of `old`. Raises InputError.
    """
    names = [name for name in new if name in old]
    if not names:
        remedy = "Name the folders or videos as the cameras of the recording."
        raise InputError("no camera has the same name in both calibrations", "cameras", remedy)
    here = np.array([new[name].position_world for name in names])
    there = np.array([old[name].position_world for name in names])
    both = ((old[name].world_from_camera, new[name].camera_from_world) for name in names)
    axes = sum(one.rotation @ other.rotation for one, other in both)
    spread = (there - there.mean(axis=0)).T @ (here - here.mean(axis=0))
    u, _, v = np.linalg.svd(spread + axes)
    rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    shift = there.mean(axis=0) - rotation @ here.mean(axis=0)
    world = RigidTransform(rotation, shift)
    apart = float(np.sqrt(np.mean(np.sum((there - world.apply(here)) ** 2, axis=1))))
    return Alignment(world, "cameras", len(names), apart)


def from_points(
    origin: FloatArray, north: FloatArray, floor: FloatArray, above: FloatArray
) -> Alignment:
    """Points (3,) of the floor: origin, north, a third; one `above` it. Raises InputError."""
    along = north - origin
    up = np.cross(along, floor - origin)
    apart = float(np.linalg.norm(up) / max(float(np.linalg.norm(along)), 1e-9))
    if not (np.linalg.norm(along) > _LEAST_POINT_M and apart > _LEAST_POINT_M):
        third = "a third point of the floor beside the line from origin to north"
        remedy = f"Choose {third}, at least half a metre away."
        raise InputError("the three points lie nearly on a line", "--points", remedy)
    up = up * np.sign(up @ (above - origin))
    return Alignment(world_of_axes(up, along, origin), "points", 3, float("nan"))


def from_clicks(cameras: Cameras, clicks: Mapping[str, Mapping[str, FloatArray]]) -> Alignment:
    """Three points of the floor, clicked: pixels (2,) by point and camera. Raises InputError."""
    points = triangulated(cameras, clicks)
    above = np.mean([camera.position_world for camera in cameras.values()], axis=0)
    return from_points(points[ORIGIN], points[NORTH], points[FLOOR], above)


def triangulated(
    cameras: Cameras, clicks: Mapping[str, Mapping[str, FloatArray]]
) -> dict[str, FloatArray]:
    """Points (3,) clicked in two cameras: pixels (2,) by both. Raises InputError."""
    found = {}
    for name in POINTS:
        seen = clicks.get(name, {})
        if len(seen) < 2:
            what = f"the point {name!r} is clicked in {counted(len(seen), 'camera')}"
            remedy = f"Click {', '.join(POINTS)} in at least two cameras each."
            raise InputError(what, "--points", remedy)
        pixels = np.array(list(seen.values()))
        sightings = Sightings.of([cameras[one] for one in seen], pixels, np.ones(len(seen)))
        point = point_of_sightings(sightings)
        if point is None:
            remedy = "Check that the same point was clicked in all cameras."
            raise InputError(f"the clicks of {name!r} do not meet in one point", "--points", remedy)
        found[name] = point.world
    return found


def from_person(points: FloatArray) -> Alignment:
    """A person who stands facing north over frames of landmarks (F, 9, 3).

    The floor under the hips follows from the torso's length. Raises InputError where it is unknown
    or not upright.
    """
    middle = {
        name: points[:, [LANDMARKS.index(f"{side}_{name}") for side in ("left", "right")]]
        for name in ("hip", "shoulder")
    }
    known = np.isfinite(np.concatenate(list(middle.values()), axis=1)).all(axis=(1, 2))
    if not known.any():
        what = "no frame has both hips and both shoulders"
        raise InputError(what, "--person", "Give landmarks in which these four are known.")
    hips, shoulders = (middle[name][known] for name in ("hip", "shoulder"))
    torso = shoulders.mean(axis=1) - hips.mean(axis=1)
    length = float(np.median(np.linalg.norm(torso, axis=1)))
    direction = (torso / np.linalg.norm(torso, axis=1, keepdims=True)).mean(axis=0)
    if np.linalg.norm(direction) < _LEAST_STANDING:
        what = "the person does not stand upright in these frames"
        raise InputError(what, "--person", "Choose frames in which the person stands.")
    path = hips.mean(axis=1)
    up = direction / np.linalg.norm(direction)
    across = (shoulders[:, 1] - shoulders[:, 0] + hips[:, 1] - hips[:, 0]).mean(axis=0)
    north = np.cross(up, across)
    origin = np.median(path, axis=0) - _HIP_HEIGHT * length * up
    sway = float(np.std(path @ up))
    return Alignment(world_of_axes(up, north, origin), "person", int(known.sum()), sway)
