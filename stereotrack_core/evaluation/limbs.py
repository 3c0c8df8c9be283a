"""Ends and colours of limbs, and how much of each a camera sees."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import inside_other_cone, regular_points, visible
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS

LIMB_COLOURS: MappingProxyType[str, str] = MappingProxyType(
    {
        "torso": "#8c8c8c",
        "head": "#009E73",
        "left_upper_arm": "#0072B2",
        "left_forearm": "#56B4E9",
        "right_upper_arm": "#D55E00",
        "right_forearm": "#E69F00",
    }
)
"""Colour of each limb as #rrggbb."""


def limb_bgr(limb: str) -> tuple[int, int, int]:
    """Blue, green and red of a limb, 0 to 255, as OpenCV has them; legs are a light grey."""
    text = LIMB_COLOURS.get(limb, "#b4b4b4")
    return int(text[5:7], 16), int(text[3:5], 16), int(text[1:3], 16)


POINTS_PER_CONE = 24
"""Points on each cone of the body by which it is judged what a camera sees."""


def limb_ends(points: FloatArray) -> FloatArray:
    """Near and far ends (F, 6, 2, 3), world, metres, of the limbs of landmarks (F, 9, 3)."""
    result: FloatArray = np.empty((len(points), len(LIMBS), 2, 3))
    for i, limb in enumerate(LIMBS):
        for end, names in enumerate(LIMB_ENDS[limb]):
            own = [LANDMARKS.index(name) for name in names]
            result[:, i, end] = points[:, own].mean(axis=1)
    return result


def seen_shares(body: BodyModel, pose: Pose, cameras: Sequence[Camera]) -> FloatArray:
    """Share (V, 6) of every limb's side facing a camera that this camera sees.

    Points of the surface that lie inside another part of the body count for neither.
    """
    frames = body.frames(pose)
    sampled = regular_points(body.cones, POINTS_PER_CONE * len(body.cones))
    sampled = sampled[LIMB_OF_PART[sampled.part] < len(LIMBS)]
    placed = placed_cones(body, frames)
    points = frames.apply(sampled.part, sampled.points)
    outside = ~inside_other_cone(points, sampled.cone, placed)
    sampled, points = sampled[outside], points[outside]
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    result: FloatArray = np.zeros((len(cameras), len(LIMBS)))
    of_limb = LIMB_OF_PART[sampled.part]
    for v, camera in enumerate(cameras):
        place = camera.position_world
        facing = np.einsum("ni,ni->n", normals, place - points) > 0
        free = visible(points, normals, place[None], placed) & in_image(camera, points)
        for limb in range(len(LIMBS)):
            own = facing & (of_limb == limb)
            result[v, limb] = free[own].mean() if own.any() else 0.0
    return result


def in_image(camera: Camera, points: FloatArray) -> BoolArray:
    """Whether points (N, 3), world, metres, are within a camera's image (N,)."""
    pixels = camera.project(points)
    with np.errstate(invalid="ignore"):
        within = (pixels > -0.5) & (pixels < np.array([camera.width, camera.height]) - 0.5)
    result: BoolArray = np.asarray(within.all(axis=-1))
    return result
