"""A person ready to be drawn: flesh contoured once, clothes, and a surface that follows the bones.

Round cones along the bones, with muscles, are joined smoothly to one closed surface, which shares
nothing with the tracker's own body. Weights are smooth, and blended by dual quaternions: Kavan et
al., "Skinning with dual quaternions", I3D 2007, doi:10.1145/1230100.1230107. The surface is posed
first as if the shoulder girdle only followed the arms. What the shoulders do beside that moves it
once more: the arm goes along with its joint, and the flesh between arm, neck and chest turns about
the clavicle's inner end, less and less towards head and ribs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.simulation.room import borders, material_table, worn
from stereotrack_core.simulation.skeleton import (
    BONE,
    BONES,
    SIDES,
    SIGN,
    Person,
    PosedBones,
    girth_scale,
    head_centre,
    rest_joints,
)
from stereotrack_core.vtk_build import vtk_module

_SPACING = 0.012  # of the grid on which the surface is contoured, metres


@dataclass(frozen=True, eq=False)
class Flesh:
    """A round cone from `a` to `b`, flattened along `flat` by the factor `by`."""

    a: FloatArray
    radius_a: float
    b: FloatArray
    radius_b: float
    flat: tuple[float, float, float] = (0.0, 0.0, 1.0)
    by: float = 1.0
    blend: float = 0.03


def rest_surface(person: Person) -> tuple[FloatArray, FloatArray, IntArray]:
    """Closed surface of `person` at rest: its flesh contoured on a grid.

    Vertices (V, 3) in metres, their normals outwards, from the field, so that the mesh's own facets
    do not show in the light, and triangles (T, 3), counter-clockwise seen from outside.
    """
    pieces = tuple(flesh(person))
    low = np.min([np.minimum(p.a - p.radius_a, p.b - p.radius_b) for p in pieces], axis=0) - 0.04
    high = np.max([np.maximum(p.a + p.radius_a, p.b + p.radius_b) for p in pieces], axis=0) + 0.04
    axes = [np.arange(lo, hi, _SPACING) for lo, hi in zip(low, high, strict=True)]
    field = _distance_on_grid(pieces, axes)
    # VTK takes its time to load, and a window that simulates nothing does without
    numpy_support = vtk_module("util.numpy_support")
    image = vtk_module("vtkCommonDataModel").vtkImageData()
    image.SetDimensions(*field.shape)
    image.SetSpacing(_SPACING, _SPACING, _SPACING)
    image.SetOrigin(*low)
    values = np.ascontiguousarray(field.ravel(order="F"), dtype=np.float32)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(values, deep=1))
    contour = vtk_module("vtkFiltersCore").vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    contour.ComputeNormalsOff()
    contour.Update()
    mesh = contour.GetOutput()
    vtk_to_numpy = numpy_support.vtk_to_numpy
    vertices = vtk_to_numpy(mesh.GetPoints().GetData()).astype(np.float64)
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)[:, ::-1]
    normals = _field_normals(field, (vertices - low) / _SPACING)
    return vertices, normals, triangles.astype(np.int64)


def _field_normals(field: FloatArray, cells: FloatArray) -> FloatArray:
    """Directions (V, 3) in which the field grows at points (V, 3) in units of its grid."""
    grown = [scipy.ndimage.gaussian_filter(field, 1.0, order=o) for o in np.eye(3, dtype=int)]
    slopes = [scipy.ndimage.map_coordinates(one, cells.T, order=1) for one in grown]
    normals = np.stack(slopes, axis=1)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None])


def _distance_on_grid(pieces: tuple[Flesh, ...], axes: list[FloatArray]) -> FloatArray:
    """Signed distance of the joined pieces on the grid of `axes`, negative inside.

    Far from a piece only its own box is touched; the polynomial smooth minimum has no
    effect further away than its width.
    """
    field = np.full([len(axis) for axis in axes], 0.2)
    for piece in pieces:
        reach = max(piece.radius_a, piece.radius_b) + 0.06
        low = np.minimum(piece.a, piece.b) - reach
        high = np.maximum(piece.a, piece.b) + reach
        box = tuple(
            slice(int(np.searchsorted(axis, lo)), int(np.searchsorted(axis, hi)))
            for axis, lo, hi in zip(axes, low, high, strict=True)
        )
        grid = np.meshgrid(*(axis[s] for axis, s in zip(axes, box, strict=True)), indexing="ij")
        distance = flesh_distance(piece, np.stack(grid, axis=-1))
        h = np.maximum(piece.blend - np.abs(field[box] - distance), 0.0) / piece.blend
        field[box] = np.minimum(field[box], distance) - h * h * piece.blend / 4
    return field


def flesh_distance(piece: Flesh, points: FloatArray) -> FloatArray:
    """Signed distance (...,) of points (..., 3) to one piece."""
    flat = np.asarray(piece.flat)

    def stretched(p: FloatArray) -> FloatArray:
        return np.asarray(p + (piece.by - 1.0) * (p @ flat)[..., None] * flat)

    a, b = stretched(piece.a), stretched(piece.b)
    p = stretched(points) - a
    axis = b - a
    squared = float(axis @ axis)
    if squared < 1e-12:
        return np.asarray(np.linalg.norm(p, axis=-1) - piece.radius_a)
    along = np.clip(p @ axis / squared, 0.0, 1.0)
    radius = piece.radius_a + along * (piece.radius_b - piece.radius_a)
    return np.asarray(np.linalg.norm(p - along[..., None] * axis, axis=-1) - radius)


def flesh(person: Person) -> Iterator[Flesh]:
    """All pieces of a person at rest."""
    yield from _trunk(person)
    yield from _head(person)
    for side in (0, 1):
        yield from _arm(person, side)
        yield from _leg(person, side)


def _trunk(person: Person) -> Iterator[Flesh]:
    joints = rest_joints(person)
    hip_z = joints[0, 2]
    length = person.torso_length
    half = person.shoulder_width / 2
    g = person.girth * girth_scale(person)

    def bar(
        width: float, y: float, z: float, radius: float, flat: float, blend: float = 0.08
    ) -> Flesh:
        ends = np.array([[-width, y, z], [width, y, z]])
        return Flesh(ends[0], radius, ends[1], radius, (0.0, 1.0, 0.0), flat, blend)

    hips = person.hips * person.hip_width / 2
    yield bar(hips * 0.72, -0.005, hip_z + 0.02, 0.112 * g, 1.08)
    yield bar(hips * 0.62, -0.050, hip_z - 0.03, 0.078 * g, 1.0, 0.06)
    yield bar(0.045 * g, 0.0, hip_z + 0.22 * length, 0.108 * g, 1.12)
    yield bar(0.045 * g, 0.0, hip_z + 0.42 * length, 0.105 * g, 1.12)
    yield bar(half * 0.36, -0.005, hip_z + 0.66 * length, 0.116 * g, 1.12)
    yield bar(half * 0.42, -0.005, hip_z + 0.80 * length, 0.110 * g, 1.10)
    yield bar(half * 0.62, -0.010, hip_z + 0.94 * length, 0.066 * g, 1.0)
    for s in SIGN:
        chest = np.array([s * half * 0.42, 0.055 * g, hip_z + 0.78 * length])
        yield Flesh(chest, 0.068 * g, chest, 0.068 * g, blend=0.06)
        blade = np.array([s * half * 0.5, -0.065 * g, hip_z + 0.84 * length])
        yield Flesh(blade, 0.060 * g, blade, 0.060 * g, blend=0.06)
        shoulder = joints[BONE["upper_arm_right"]] * [s, 1, 1]
        neck = joints[BONE["neck"]] + [s * 0.02, -0.005, 0.03]
        yield Flesh(shoulder * [0.72, 1, 1] + [0, -0.012, 0.005], 0.046, neck, 0.045, blend=0.06)


def _head(person: Person) -> Iterator[Flesh]:
    centre = head_centre(person)
    k = girth_scale(person)
    neck = rest_joints(person)[BONE["neck"]]
    skull_base = centre + [0, -0.005, -0.06]
    yield Flesh(neck + [0, 0, -0.04], 0.062 * k, skull_base, 0.055 * k, blend=0.05)
    crown, chin = centre + [0, -0.012, 0.028 * k], centre + [0, 0.038, -0.072 * k]
    yield Flesh(crown, 0.094 * k, chin, 0.052 * k, (1.0, 0.0, 0.0), 1.16, 0.03)
    nose = centre + [0, 0.098 * k, -0.022]
    yield Flesh(nose + [0, -0.012, 0.03], 0.009, nose, 0.014, blend=0.02)
    for s in SIGN:
        ear = centre + [s * 0.080 * k, -0.010, -0.018]
        yield Flesh(ear, 0.020, ear + [0, 0, 0.025], 0.020, (1.0, 0.0, 0.0), 2.0, 0.01)


def _arm(person: Person, side: int) -> Iterator[Flesh]:
    s = SIGN[side]
    joints = rest_joints(person)
    bones_of_arm = ("upper_arm", "forearm", "hand")
    shoulder, elbow, wrist = (joints[BONE[f"{b}_{SIDES[side]}"]] for b in bones_of_arm)
    m = person.muscle * girth_scale(person)

    def on_upper(share: float) -> FloatArray:
        return np.asarray(shoulder + share * (elbow - shoulder))

    def on_fore(share: float) -> FloatArray:
        return np.asarray(elbow + share * (wrist - elbow))

    deltoid = on_upper(0.04) + [0, 0, 0.004]
    yield Flesh(deltoid, 0.060 * m, on_upper(0.34), 0.050 * m, blend=0.05)
    yield Flesh(shoulder, 0.054 * m, elbow, 0.041 * m)
    front, back = np.array([0, 0.014, 0]), np.array([0, -0.012, 0])
    yield Flesh(on_upper(0.40) + front, 0.043 * m, on_upper(0.66) + front, 0.042 * m)
    yield Flesh(on_upper(0.30) + back, 0.043 * m, on_upper(0.58) + back, 0.043 * m)
    yield Flesh(elbow, 0.041 * m, wrist, 0.027 * m)
    yield Flesh(on_fore(0.14), 0.043 * m, on_fore(0.42), 0.041 * m)
    hand = np.array([s * person.hand, 0.0, 0.0])
    across = np.array([0.0, 1.0, 0.0])
    thin = (0.0, 0.0, 1.0)
    yield Flesh(wrist, 0.028 * m, wrist + 0.10 * hand, 0.029 * m, thin, 1.25, 0.02)
    for offset, tip in ((0.026, 0.90), (0.009, 1.0), (-0.009, 0.96), (-0.026, 0.84)):
        start = wrist + 0.22 * hand + offset * across
        end = wrist + tip * hand + 1.1 * offset * across - np.array([s * 0.010, 0, 0])
        yield Flesh(start, 0.019, end, 0.010, thin, 1.3, 0.016)
    thumb = wrist + 0.12 * hand + 0.022 * across
    yield Flesh(thumb, 0.018, wrist + 0.52 * hand + 0.068 * across, 0.011, blend=0.02)


def _leg(person: Person, side: int) -> Iterator[Flesh]:
    joints = rest_joints(person)
    hip, knee, ankle = (joints[BONE[f"{b}_{SIDES[side]}"]] for b in ("thigh", "shank", "foot"))
    g = (person.girth + person.muscle) / 2 * girth_scale(person)
    upper = hip + [0, 0.0, -0.03]
    yield Flesh(upper, 0.084 * g, knee, 0.056 * g, blend=0.04)
    thigh = knee - hip
    yield Flesh(hip + 0.3 * thigh + [0, 0.02, 0], 0.066 * g, hip + 0.6 * thigh, 0.066 * g)
    yield Flesh(knee, 0.056 * g, ankle, 0.040 * g)
    shank = ankle - knee
    calf = np.array([0, -0.018, 0])
    yield Flesh(knee + 0.18 * shank + calf, 0.050 * g, knee + 0.46 * shank + calf, 0.044 * g)
    floor = ankle * [1, 1, 0]
    heel = floor + [0, -0.040, 0.036]
    ball = floor + [0, 0.085 * person.stature, 0.030]
    yield Flesh(heel, 0.036, ball, 0.030, blend=0.02)
    yield Flesh(ball + [-0.018, -0.03, 0], 0.028, ball + [0.018, -0.03, 0], 0.028, blend=0.02)


def _skin_weights(person: Person, vertices: FloatArray) -> FloatArray:
    """Weights (V, B) of every bone on the vertices (V, 3) at rest; rows sum to one."""
    joints = rest_joints(person)
    weights = np.zeros((len(vertices), len(BONES)))
    trunk = np.ones(len(vertices))
    x, y, z = vertices.T
    for name, sign in zip(SIDES, SIGN, strict=True):
        shoulder, elbow, wrist, hip, knee, ankle = (
            joints[BONE[f"{bone}_{name}"]]
            for bone in ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
        )
        out = sign * x
        # the border of the arm leans, so that the flank below the armpit stays trunk
        below = np.minimum(0.0, z - (shoulder[2] - 0.05))
        arm = _smooth_step(out + 0.6 * below, abs(shoulder[0]) - 0.004, 0.062)
        twisted = np.clip((out - abs(shoulder[0])) / (0.75 * person.upper_arm), 0.0, 1.0)
        past_elbow = _smooth_step(out, abs(elbow[0]), 0.042)
        past_wrist = _smooth_step(out, abs(wrist[0]), 0.028)
        weights[:, BONE[f"swing_{name}"]] = arm * (1 - past_elbow) * (1 - twisted)
        weights[:, BONE[f"upper_arm_{name}"]] = arm * (1 - past_elbow) * twisted
        weights[:, BONE[f"forearm_{name}"]] = arm * past_elbow * (1 - past_wrist)
        weights[:, BONE[f"hand_{name}"]] = arm * past_elbow * past_wrist
        leg = (1 - _smooth_step(z, hip[2] - 0.045, 0.075)) * _smooth_step(out, 0.0, 0.012)
        past_knee = 1 - _smooth_step(z, knee[2], 0.055)
        past_ankle = 1 - _smooth_step(z + 0.15 * (y - ankle[1]), ankle[2], 0.032)
        weights[:, BONE[f"thigh_{name}"]] = leg * (1 - past_knee)
        weights[:, BONE[f"shank_{name}"]] = leg * past_knee * (1 - past_ankle)
        weights[:, BONE[f"foot_{name}"]] = leg * past_knee * past_ankle
        trunk -= arm + leg
    _share_trunk(joints, vertices, np.maximum(trunk, 0.0), weights)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _smooth_step(x: FloatArray, middle: float, half_width: float) -> FloatArray:
    """0 to 1 over `middle` +- `half_width`, smoothly."""
    t = np.clip((x - middle) / (2 * half_width) + 0.5, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _share_trunk(joints: FloatArray, p: FloatArray, trunk: FloatArray, weights: FloatArray) -> None:
    z = p[:, 2]
    spine = np.abs(joints[BONE["chest"], 2] - joints[BONE["waist"], 2])
    passed = [
        _smooth_step(z, joints[BONE["waist"], 2], 0.75 * spine),
        _smooth_step(z, joints[BONE["chest"], 2], 0.75 * spine),
        _smooth_step(z, joints[BONE["neck"], 2], 0.035),
        _smooth_step(z, joints[BONE["head"], 2] - 0.01, 0.04),
    ]
    rest = trunk
    for bone, share in zip(("pelvis", "waist", "chest", "neck"), passed, strict=True):
        weights[:, BONE[bone]] = rest * (1 - share)
        rest = rest * share
    weights[:, BONE["head"]] = rest
    chest = weights[:, BONE["chest"]].copy()
    shoulder = joints[BONE["upper_arm_right"]]
    for side, name in enumerate(SIDES):
        girdle = _smooth_step(SIGN[side] * p[:, 0], 0.5 * shoulder[0], 0.4 * shoulder[0])
        girdle *= _smooth_step(z, shoulder[2] - 0.08, 0.09)
        weights[:, BONE[f"clavicle_{name}"]] = chest * girdle
        weights[:, BONE["chest"]] -= chest * girdle


def _dual_quaternions(rest: FloatArray, bones: PosedBones) -> FloatArray:
    """Unit dual quaternions (B, 8), w x y z, then the dual part; signs make blending go short."""
    shift = bones.joint - np.einsum("bij,bj->bi", bones.rotation, rest)
    result = _rigid_quaternions(bones.rotation, shift)
    result[result[:, :4] @ result[BONE["chest"], :4] < 0] *= -1
    return result


def _rigid_quaternions(rotation: FloatArray, shift: FloatArray) -> FloatArray:
    """Unit dual quaternions (N, 8) of turns (N, 3, 3) and then shifts (N, 3)."""
    real = np.roll(scipy.spatial.transform.Rotation.from_matrix(rotation).as_quat(), 1, axis=1)
    real *= np.where(real[:, :1] < 0, -1.0, 1.0)
    dual = 0.5 * _product(np.concatenate([np.zeros((len(shift), 1)), shift], axis=1), real)
    return np.concatenate([real, dual], axis=1)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Hamilton product (..., 4) of quaternions w x y z."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    q, r, s, t = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            w * q - x * r - y * s - z * t,
            w * r + x * q + y * t - z * s,
            w * s - x * t + y * q + z * r,
            w * t + x * s - y * r + z * q,
        ],
        axis=-1,
    )


def _skinned(
    vertices: FloatArray, normals: FloatArray, weights: FloatArray, quaternions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Vertices and normals (V, 3), world, of a surface at rest under posed bones."""
    blended = weights @ quaternions
    blended /= np.linalg.norm(blended[:, :4], axis=1, keepdims=True)
    w, v = blended[:, :1], blended[:, 1:4]
    dual_w, dual_v = blended[:, 4:5], blended[:, 5:8]

    def turned(p: FloatArray) -> FloatArray:
        return p + 2 * np.cross(v, np.cross(v, p) + w * p)

    shift = 2 * (w * dual_v - dual_w * v + np.cross(v, dual_v))
    return turned(vertices) + shift, turned(normals)


_ARM = ("swing", "upper_arm", "forearm", "hand")


def _girdle_weights(person: Person, vertices: FloatArray, weights: FloatArray) -> FloatArray:
    """Shares (V, 5) of what stays, of the left girdle and arm, and of the right ones, at rest."""
    shoulder = rest_joints(person)[BONE["upper_arm_right"]]
    half, z = shoulder[0], vertices[:, 2] - shoulder[2]
    height = _smooth_step(z, -0.10, 0.12) * (1 - _smooth_step(z, 0.10, 0.09))
    height *= 1 - weights[:, BONE["head"]]
    shares = np.zeros((len(vertices), 5))
    for side, name in enumerate(SIDES):
        arm = weights[:, [BONE[f"{bone}_{name}"] for bone in _ARM]].sum(axis=1)
        across = _smooth_step(SIGN[side] * vertices[:, 0], 0.45 * half, 0.4 * half)
        shares[:, 1 + 2 * side] = (1 - arm) * across * height
        shares[:, 2 + 2 * side] = arm
    shares[:, 0] = 1 - shares[:, 1:].sum(axis=1)
    return shares


def _without_own_girdle(bones: PosedBones) -> PosedBones:
    """The bones as they were if the shoulders only followed the arms; the same if they do."""
    if np.array_equal(bones.girdle, np.tile(np.eye(3), (2, 1, 1))):
        return bones
    rotation, joint = bones.rotation.copy(), bones.joint.copy()
    for side, name in enumerate(SIDES):
        rotation[BONE[f"clavicle_{name}"]] = (
            bones.girdle[side].T @ rotation[BONE[f"clavicle_{name}"]]
        )
        joint[[BONE[f"{bone}_{name}"] for bone in _ARM]] -= _arm_shift(bones, side)
    return PosedBones(rotation, joint)


def _with_own_girdle(
    vertices: FloatArray, normals: FloatArray, shares: FloatArray, bones: PosedBones
) -> tuple[FloatArray, FloatArray]:
    """Move a surface (V, 3), world, that followed the bones without their own girdle."""
    turns = np.tile(np.eye(3), (5, 1, 1))
    shifts = np.zeros((5, 3))
    for side, name in enumerate(SIDES):
        pivot = bones.joint[BONE[f"clavicle_{name}"]]
        turns[1 + 2 * side] = bones.girdle[side]
        shifts[1 + 2 * side] = pivot - bones.girdle[side] @ pivot
        shifts[2 + 2 * side] = _arm_shift(bones, side)
    return _skinned(vertices, normals, shares, _rigid_quaternions(turns, shifts))


def _arm_shift(bones: PosedBones, side: int) -> FloatArray:
    """How far the girdle's own motion brings the shoulder, (3,) metres, world."""
    clavicle, shoulder = (
        bones.joint[BONE[f"{bone}_{SIDES[side]}"]] for bone in ("clavicle", "upper_arm")
    )
    out = shoulder - clavicle
    return np.asarray(out - bones.girdle[side].T @ out)


@dataclass(frozen=True, eq=False)
class Actor:
    """A dressed person to be posed; `vertices`, `normals` (V, 3) at rest, as the textures."""

    person: Person
    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray  # (T, 3)
    weights: FloatArray  # (V, B)
    materials: FloatArray  # (6, 9)
    marks: FloatArray  # (8,)

    @cached_property
    def _girdle_shares(self) -> FloatArray:
        return _girdle_weights(self.person, self.vertices, self.weights)

    def posed(self, bones: PosedBones) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals (V, 3), world."""
        following = _without_own_girdle(bones)
        quaternions = _dual_quaternions(rest_joints(self.person), following)
        posed = _skinned(self.vertices, self.normals, self.weights, quaternions)
        return posed if following is bones else _with_own_girdle(*posed, self._girdle_shares, bones)


@cache
def actor(person: Person, clothes: str) -> Actor:
    """Contour, weight and dress a person."""
    vertices, normals, triangles = rest_surface(person)
    weights = _skin_weights(person, vertices)
    materials = material_table(worn(person, clothes))
    return Actor(person, vertices, normals, triangles, weights, materials, borders(person))
