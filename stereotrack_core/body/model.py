"""The body: a skeleton with truncated cones around it (section 3.2.2)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS
from stereotrack_core.body.offsets import NO_OFFSETS, offsets_of, with_offsets
from stereotrack_core.body.parameters import BodyParameters, BodyShape
from stereotrack_core.body.pose import REST, PartFrames, Pose, part_frames
from stereotrack_core.body.proportions import AVERAGE, Proportions, proportions_of
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    FOREARMS,
    HEAD,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
    Skeleton,
    skeleton,
)
from stereotrack_core.compiled import compiled
from stereotrack_core.recording.description import Subject

# Margins of the outline along x and y of the thesis's 11 cones; legs are not measured.
CONTOUR_NAMES: tuple[tuple[str, str], ...] = (
    ("contour_torso_side", "contour_torso_front"),
    *[("contour_shoulder_top", "contour_shoulder_front")] * 2,
    ("contour_jaw_side", "contour_jaw_front"),
    ("contour_head_side", "contour_head_front"),
    *[("contour_upper_arm", "contour_upper_arm")] * 2,
    *[("contour_forearm", "contour_forearm"), ("contour_hand", "contour_hand")] * 2,
)

_NUMBERS = [(name, "f8") for name in ("r1", "r2", "height", "flatness")]
# A truncated cone: its base stands on its `origin`, its axis runs along its own z; metres. In the
# frame of its part, or in the world: p = rotation p_cone + origin. `flatness` is a factor on y, 1
# is round; an end that is round has a half sphere that takes data. The `outline` says how far the
# person's outline lies outside of the surface along x and y: block matching widens the clouds that
# the surface is fitted to.
_PLACE = [("part", "i8"), ("rotation", "f8", (3, 3)), ("origin", "f8", (3,))]
CONE = np.dtype([*_PLACE, *_NUMBERS, ("round_end", "?"), ("outline", "f8", (2,))], align=True)
Cones: TypeAlias = np.ndarray[Any, np.dtype[np.void]]  # ``CONE`` (C,), in the frames of their parts
PlacedCones: TypeAlias = np.ndarray[Any, np.dtype[np.void]]  # ``CONE`` (..., C), in the world


@dataclass(frozen=True)
class _Cone:
    part: int
    r1: float
    r2: float
    height: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    flatness: float = 1.0
    round_end: bool = False


def body_cones(proportions: Proportions, parameters: BodyParameters) -> Cones:
    """The 11 cones of the thesis, and four for the legs if the parameters ask for them."""
    shape = BodyShape.of(parameters)
    rows = [*_trunk(proportions, shape), *_arms(proportions, shape)]
    if shape.legs:
        rows += _legs(proportions, shape)
    cones: Cones = np.zeros(len(rows), dtype=CONE)
    for name in ("part", "origin", "r1", "r2", "height", "flatness", "round_end"):
        cones[name] = [getattr(row, name) for row in rows]
    # z is turned to the axis; y, the flattened side, stays upright.
    z = np.array([row.axis for row in rows])
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    x = np.stack([z[:, 2], np.zeros(len(z)), -z[:, 0]], axis=1)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    cones["rotation"] = np.stack([x, np.cross(z, x), z], axis=2)
    for outline, pair in zip(cones["outline"], CONTOUR_NAMES, strict=False):
        outline[:] = [getattr(shape, name) for name in pair]
    return cones


def _trunk(p: Proportions, b: BodyShape) -> list[_Cone]:
    k, top, below = p.scale, p.torso_length, 0.05
    length = top + below
    lean = b.torso_forward_high - b.torso_forward_low
    main = _Cone(
        TORSO,
        b.torso_radius_low * k,
        b.torso_radius_high * k,
        float(np.hypot(length, lean)),
        origin=(0.0, b.torso_forward_low, -below),
        axis=(0.0, lean, length),
        flatness=b.torso_flatness,
    )
    return [main, *_shoulders(p, b), *_head(p, b)]


def _shoulders(p: Proportions, b: BodyShape) -> list[_Cone]:
    k = p.scale * b.shoulder_radius_factor
    reach, rise = 0.5 * p.shoulder_width - 0.03, p.torso_length + b.shoulder_rise
    rows, joints = [], skeleton(p).joints
    for clavicle, side in zip(CLAVICLES, (-1.0, 1.0), strict=True):
        base, axis = np.array([0.03 * side, 0.0, rise]), np.array([side, 0.0, 0.0])
        part = TORSO
        if b.girdle:
            part = clavicle
            base, axis = (base - joints[part]) @ REST[part], axis @ REST[part]
        rows.append(_Cone(part, 0.075 * k, 0.07 * k, reach, origin=tuple(base), axis=tuple(axis)))
    return rows


def _head(p: Proportions, b: BodyShape) -> list[_Cone]:
    height, k = 0.135 * p.scale, p.scale * b.head_radius_factor
    middle = p.shoulder_to_head + b.head_rise
    neck, widest = (0.0, b.head_forward, middle - height), (0.0, b.head_forward, middle)
    return [
        _Cone(HEAD, 0.06 * k, 0.09 * k, height, origin=neck),
        _Cone(HEAD, 0.09 * k, 0.055 * k, height, origin=widest, round_end=True),
    ]


def _arms(p: Proportions, b: BodyShape) -> list[_Cone]:
    k = p.scale * b.arm_radius_factor
    rows = [_Cone(part, 0.058 * k, 0.045 * k, p.upper_arm_length) for part in UPPER_ARMS]
    for part in FOREARMS:
        wrist = (0.0, 0.0, p.forearm_length)
        rows.append(_Cone(part, 0.045 * k, 0.032 * k, p.forearm_length))
        rows.append(_Cone(part, 0.040 * k, 0.032 * k, p.hand_length, origin=wrist, round_end=True))
    return rows


def _legs(p: Proportions, b: BodyShape) -> list[_Cone]:
    k = p.scale * b.leg_radius_factor
    # A leg hangs with its y axis to the back.
    front = (0.0, -b.leg_forward, 0.0)
    parts = (
        *((part, 0.09, 0.062, b.leg_length_factor * p.thigh_length) for part in THIGHS),
        *((part, 0.06, 0.05, b.leg_length_factor * p.shank_length) for part in SHANKS),
    )
    return [_Cone(part, r1 * k, r2 * k, height, origin=front) for part, r1, r2, height in parts]


@dataclass(frozen=True, eq=False)
class BodyModel:
    """What is known about a person before tracking: lengths and shape."""

    skeleton: Skeleton
    cones: Cones
    shape: BodyShape  # what the cones were made of, besides the lengths
    # (9, 3), metres, of the landmarks; see :mod:`body.offsets`.
    offsets: FloatArray = field(default_factory=lambda: NO_OFFSETS)

    def with_shape(self, shape: BodyShape) -> BodyModel:
        """The same person with another surface."""
        made = body_model(self.skeleton.proportions, shape)
        return dataclasses.replace(made, offsets=self.offsets)

    def frames(self, pose: Pose) -> PartFrames:
        """Frames of all parts, computed once for each pose; see :func:`part_frames`."""
        known = pose.known_frames
        if known is None or known[0] is not self.skeleton:
            known = self.skeleton, part_frames(self.skeleton, pose)
            object.__setattr__(pose, "known_frames", known)
        return known[1]

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Joints of a state: arms, head, and of legs and clavicles those that have a surface."""
        always = (*THESIS_JOINTS, HEAD)
        return tuple(j for j in ALL_JOINTS if j in always or np.any(self.cones["part"] == j))


def body_model(proportions: Proportions, parameters: BodyParameters | None = None) -> BodyModel:
    """Body with these proportions, or with average ones where the parameters say so."""
    shape = BodyShape() if parameters is None else BodyShape.of(parameters)
    lengths = AVERAGE if shape.proportions == "average" else proportions
    bones = skeleton(lengths, shape.leg_length_factor)
    return BodyModel(bones, body_cones(lengths, shape), shape)


def body_of_subject(subject: Subject | None, parameters: BodyParameters | None = None) -> BodyModel:
    """Body of a person as far as known: measured lengths, average ones, and offsets."""
    body = body_model(proportions_of(subject), parameters)
    known = {} if subject is None else subject.offsets
    return dataclasses.replace(body, offsets=offsets_of(known))


def placed_cones(body: BodyModel, frames: PartFrames) -> PlacedCones:
    """The cones (..., C) where the parts of one pose, or of stacked ones, are."""
    rotations, origins = np.ascontiguousarray(frames.rotations), frames.origins
    lead = rotations.shape[:-3]
    origins = np.ascontiguousarray(origins).reshape(-1, *origins.shape[-2:])
    placed = np.empty((len(origins), len(body.cones)), dtype=CONE)
    _place(body.cones, rotations.reshape(-1, *rotations.shape[-3:]), origins, placed)
    return placed.reshape(*lead, len(body.cones))


@compiled()
def _place(cones: Any, rotations: Any, origins: Any, out_placed: Any) -> None:
    """Fill the cones (S, C) in S poses."""
    for s in range(out_placed.shape[0]):
        for c in range(out_placed.shape[1]):
            out_placed[s, c] = cones[c]
            cone, placed = cones[c], out_placed[s, c]
            R, origin = rotations[s, cone.part], origins[s, cone.part]
            for i in range(3):
                placed.origin[i] = origin[i]
                for j in range(3):
                    placed.origin[i] += R[i, j] * cone.origin[j]
                    placed.rotation[i, j] = (
                        R[i, 0] * cone.rotation[0, j]
                        + R[i, 1] * cone.rotation[1, j]
                        + R[i, 2] * cone.rotation[2, j]
                    )


def landmarks(body: BodyModel, pose: Pose) -> FloatArray:
    """The nine landmarks (..., 9, 3), world, metres, in the order of ``LANDMARKS``."""
    return landmarks_of_frames(body, body.frames(pose))


def landmarks_of_frames(body: BodyModel, frames: PartFrames) -> FloatArray:
    """The nine landmarks (..., 9, 3) where the parts' frames are known already."""
    lengths = body.skeleton.lengths
    shoulders = [frames.origins[..., part, :] for part in UPPER_ARMS]
    elbows = [frames.origins[..., part, :] for part in FOREARMS]
    hands = [_along(frames, part, lengths[part]) for part in FOREARMS]
    head = _along(frames, HEAD, lengths[HEAD])
    half_hips = 0.5 * body.skeleton.proportions.hip_width * frames.rotations[..., TORSO, :, 0]
    hip = frames.origins[..., TORSO, :]
    hips = [hip - half_hips, hip + half_hips]
    of_surface = np.stack([*shoulders, *elbows, *hands, head, *hips], axis=-2)
    return with_offsets(of_surface, body.offsets, frames)


def _along(frames: PartFrames, part: int, length: float) -> FloatArray:
    return frames.origins[..., part, :] + length * frames.rotations[..., part, :, 2]
