"""Surface of the body where the clicks of a frame put it, and what of it the images show."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.context import CLICKED_SHAPE, pose_at, standing, watched_place
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.predict import predicted_point
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.body.sampling import inside_other_cone, regular_points, segment_blocked
from stereotrack_core.body.skeleton import FOREARMS, HEAD, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.camera import Camera

_POINTS = 700  # on the whole surface, of which about a third is seen by a camera
_FACING = 0.25  # cosine of the angle at which surface is still followed
_SKIN = 1e-3  # metres over the surface, free of it
_MOVED = (TORSO, HEAD, *UPPER_ARMS, *FOREARMS)
_NAMES = NINE.names
_ARMS = {
    UPPER_ARMS[0]: ("left_shoulder", "left_elbow"),
    UPPER_ARMS[1]: ("right_shoulder", "right_elbow"),
    FOREARMS[0]: ("left_elbow", "left_hand"),
    FOREARMS[1]: ("right_elbow", "right_hand"),
}
"""The landmarks at the ends of the arms' parts."""

_FEWEST = 3  # landmarks of the trunk, without which nobody knows how it stands


def clicked_places(clicks: Iterable[Click], cameras: Mapping[str, Camera]) -> dict[str, FloatArray]:
    """Where the landmarks of a frame (3,) are that are clicked in two images."""
    by_name: dict[str, list[Click]] = {}
    for click in clicks:
        by_name.setdefault(click.landmark, []).append(click)
    points = {name: predicted_point(cameras, own) for name, own in by_name.items()}
    return {name: point.world for name, point in points.items() if point is not None}


@dataclass(frozen=True, eq=False)
class ClickedSurface:
    """Points (N,) on the body where the clicks of a frame put it."""

    cameras: Mapping[str, Camera]
    landmarks: FloatArray  # (9, 3), world, NaN where they are not known
    own: FloatArray  # (n, 3) of all that is clicked, world
    own_names: tuple[str, ...]
    part: IntArray  # (N,)
    points: FloatArray  # (N, 3), world
    visible: Mapping[str, BoolArray]  # mapping from camera to (N,)
    offset: Mapping[str, FloatArray]  # by camera (P, 2), pixels: clicks lie beside a part

    @classmethod
    def of(
        cls,
        clicks: Sequence[Click],
        frame: int,
        found: Mapping[str, FloatArray],
        cameras: Mapping[str, Camera],
        proportions: Proportions,
    ) -> ClickedSurface | None:
        """The surface; None where too little of the trunk is known."""
        by_name: dict[str, list[Click]] = {}
        for click in clicks:
            if click.frame == frame and click.position is not None:
                by_name.setdefault(click.landmark, []).append(click)
        trunk = [name for name in _landmarks_of(TORSO) if name in found]
        if len(trunk) < _FEWEST:
            return None
        known = np.array([found.get(name, np.full(3, np.nan)) for name in _NAMES])
        body = body_model(proportions, CLICKED_SHAPE)
        pose = pose_at(known, body, NINE, standing(body, watched_place(cameras)))
        frames = body.frames(pose)
        placed, surface = placed_cones(body, frames), regular_points(body.cones, _POINTS)
        points = frames.apply(surface.part, surface.points)
        told = [p for p in _MOVED if p == TORSO or all(n in found for n in _landmarks_of(p))]
        keep = np.isin(surface.part, told) & ~inside_other_cone(points, surface.cone, placed)
        normals = np.einsum("nij,nj->ni", frames.rotations[surface.part], surface.normals)
        part, points, normals = surface.part[keep], points[keep], normals[keep]
        visible = {}
        for name, camera in cameras.items():
            sight = camera.position_world - points
            sight /= np.linalg.norm(sight, axis=1, keepdims=True)
            visible[name] = np.einsum("ni,ni->n", normals, sight) > _FACING
            at = np.flatnonzero(visible[name])
            free = points[at] + _SKIN * normals[at]
            visible[name][at] = ~segment_blocked(free, camera.position_world, placed)
        points = _to_clicked(points, part, known, NINE.places(body, frames))
        offset = {name: _offsets(camera, by_name, found, told) for name, camera in cameras.items()}
        names = tuple(found)
        own = np.array([found[name] for name in names])
        return cls(cameras, known, own, names, part, points, visible, offset)

    def guessed(self, expected: Mapping[str, FloatArray]) -> FloatArray:
        """Where the points (N, 3) are expected."""
        shift = np.zeros((len(PARTS), 3))
        for part in _MOVED:
            ends = [expected[n] for n in _landmarks_of(part) if n in expected]
            ends = [end for end in ends if np.isfinite(end).all()]
            if ends:
                shift[part] = np.mean(ends, axis=0)
        return self.points + shift[self.part]

    def seen_by(self, name: str, guess: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Points (M,) that a camera sees, their pixels (M, 2), and the expected ones (M, 2)."""
        camera, shown = self.cameras[name], np.flatnonzero(self.visible[name])
        offset = self.offset[name][self.part[shown]]
        starts = camera.project(self.points[shown]) + offset
        ends = camera.project(guess[shown]) + offset
        inside = ((starts > 0) & (starts < (camera.width - 1, camera.height - 1))).all(axis=1)
        inside &= np.isfinite(ends).all(axis=1)
        return shown[inside], starts[inside], ends[inside]


def _landmarks_of(part: int) -> tuple[str, ...]:
    if part == HEAD:
        return ("head",)
    return _ARMS.get(part, ("left_shoulder", "right_shoulder", "left_hip", "right_hip"))


def _to_clicked(
    points: FloatArray, part: IntArray, known: FloatArray, placed: FloatArray
) -> FloatArray:
    """Points on the arms shifted with their ends, which the body's lengths put beside the clicks"""
    moved = points.copy()
    for one, (near, far) in _ARMS.items():
        own, a, b = part == one, _NAMES.index(near), _NAMES.index(far)
        along = placed[b] - placed[a]
        share = np.clip((points[own] - placed[a]) @ along / (along @ along), 0.0, 1.0)[:, None]
        moved[own] += (1.0 - share) * (known[a] - placed[a]) + share * (known[b] - placed[b])
    return moved


def _offsets(
    camera: Camera,
    clicks: Mapping[str, Sequence[Click]],
    found: Mapping[str, FloatArray],
    parts: Iterable[int],
) -> FloatArray:
    """How far clicks on every part (P, 2) lie beside its landmarks in an image."""
    result = np.zeros((len(PARTS), 2))
    for part in parts:
        off = [
            np.array(click.position) - camera.project(found[name])
            for name in _landmarks_of(part)
            if name in found
            for click in clicks[name]
            if click.camera == camera.name
        ]
        if off:
            result[part] = np.mean(off, axis=0)
    return result
