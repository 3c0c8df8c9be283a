"""Landmarks that a person clicked, as measurements of the pose.

A click is the projection of a landmark, which moves rigidly with its part. Clicks also tell where a
lost body is: :func:`pose_by_clicks` needs no cloud.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import Pose, orthonormal
from stereotrack_core.body.posing import pose_showing
from stereotrack_core.body.skeleton import ARM_PARTS, FOREARMS, HEAD, TORSO, UPPER_ARMS
from stereotrack_core.geometry.rotation import (
    angle_between,
    rotation_from_vector,
    vector_from_rotation,
)
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.detections import Detection
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.correction import gathered, solved
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.residuals.detections import DetectionResidual, residual_at
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.state import Belief, Setup

_PARTS = (*UPPER_ARMS, *FOREARMS, *FOREARMS, HEAD, TORSO, TORSO)  # of the nine landmarks
_OFF = 0.012  # metres by which a landmark may lie beside its place on the body: people differ
_WIDENED = (60.0, 30.0, 15.0, 8.0, 4.0, 0.0, 0.0, 0.0)  # pixels, added to sigmas step by step
_FROM = np.radians(60.0)
_AWAY = 0.5  # radians of every joint, and metres, by which a lost body may be elsewhere
_WELL_SHOWN = 4.0  # pixels by which clicks are missed on average that a pose shows well
_HEADINGS = tuple(np.radians((0.0, 90.0, 180.0, 270.0)))
_LEANS = tuple(np.radians((0.0, 60.0)))  # radians that a lost body may face elsewhere, lean forward
_LIMB, _TURN, _PLACE = np.radians(25.0), np.radians(20.0), 0.12  # from which clicks contradict


@dataclass(frozen=True)
class ClickObservation:
    """Clicks of one frame; `widened` pixels are added to their standard deviations."""

    clicks: tuple[Detection, ...]
    widened: float = 0.0

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[DetectionResidual, ...]:
        """One residual for each click; far from the landmark, it loses its weight."""
        if not self.clicks:
            return ()
        frames, places = body.frames(pose), landmarks(body, pose)
        found = list[DetectionResidual]()
        for click in self.clicks:
            k = LANDMARKS.index(click.kind)
            part, place = _PARTS[k], places[k]
            assert click.camera is not None  # noqa: S101 - clicks are made in pictures
            depth = max(float(click.camera.camera_from_world.apply(place)[2]), _OFF)
            off = _OFF * float(click.camera.matrix[0, 0]) / depth
            local = frames.rotations[part].T @ (place - frames.origins[part])
            widened = float(np.hypot(self.widened, off))
            found.append(residual_at(click, part, local, frames, widened))
        return tuple(found)


def pose_by_clicks(setup: Setup, near: Pose, clicks: tuple[Detection, ...]) -> Pose:
    """Pose that shows the clicks of a frame, and is as near to another as they allow.

    A lost body may be anywhere and even upside down: the descent also begins at the landmarks that
    two pictures show and, where all this shows the clicks badly, upright and stooping in several
    headings.
    """

    def best_from(starts: Iterable[Pose]) -> tuple[float, Pose]:
        found = [_fitted(setup, start, clicks) for start in starts]
        ranked = [(missed(setup.body, pose, clicks), k, pose) for k, pose in enumerate(found)]
        off, _, pose = min(ranked)
        return off, pose

    points = _triangulated(clicks)
    shown = pose_showing(points, setup.body, near)
    off, best = best_from((near, turned_round(near), shown))
    if off > _WELL_SHOWN * len(clicks):
        other, pose = best_from(_stood(setup, near, points))
        best = pose if other < off else best
    return best


def _stood(setup: Setup, near: Pose, points: Mapping[str, FloatArray]) -> Iterator[Pose]:
    """The body of a pose on its feet, its landmarks on average where points (3,), world, are."""
    world_from_upright = setup.upright.rotation.T
    for heading, lean in product(_HEADINGS, _LEANS):
        turn = rotation_from_vector(np.array([0.0, 0.0, heading]))
        rotations = near.rotations.copy()
        bent = rotation_from_vector(np.array([-lean, 0.0, 0.0]))
        rotations[TORSO] = world_from_upright @ turn @ bent
        pose = Pose(near.position, rotations)
        at = dict(zip(LANDMARKS, landmarks(setup.body, pose), strict=True))
        away = [point - at[name] for name, point in points.items()]
        yield replace(pose, position=near.position + np.mean(away, axis=0)) if away else pose


def _triangulated(clicks: Sequence[Detection]) -> dict[str, FloatArray]:
    """Points (3,), world, of landmarks that two pictures show, by name."""
    origins: dict[str, list[FloatArray]] = {}
    rays: dict[str, list[FloatArray]] = {}
    for click in clicks:
        assert click.camera is not None  # noqa: S101 - clicks are made in pictures
        origins.setdefault(click.kind, []).append(click.camera.position_world)
        rays.setdefault(click.kind, []).append(click.camera.rays_world(click.position))
    points = {name: nearest_to_rays(np.array(origins[name]), np.array(rays[name])) for name in rays}
    return {name: point for name, point in points.items() if np.isfinite(point).all()}


def _fitted(setup: Setup, start: Pose, clicks: tuple[Detection, ...]) -> Pose:
    sigma = np.full(setup.columns.n, _FROM)
    sigma[:3] = _AWAY
    at = prior = Belief(start, np.diag(sigma**2))
    for widened in _WIDENED:
        pose = orthonormal(at.pose)
        frames, clicked = setup.body.frames(pose), ClickObservation(clicks, widened)
        rows = [each.rows(frames) for each in clicked.residuals(setup.body, pose)]
        rows.append(limit_rows(setup.body, pose, setup.parameters, setup.joints))
        told = gathered(rows, frames, setup.columns)
        at, _ = solved(setup.joints, prior, pose, told)
    return orthonormal(at.pose)


def missed(body: BodyModel, pose: Pose, clicks: Sequence[Detection]) -> float:
    """Sum of the distances of clicks from a pose, pixels; of each at most that of another place."""
    places, total = landmarks(body, pose), 0.0
    for click in clicks:
        assert click.camera is not None  # noqa: S101 - clicks are made in pictures
        pixel = click.camera.project(places[LANDMARKS.index(click.kind)])
        off = float(np.linalg.norm(pixel - click.position))
        total += min(off, _WIDENED[0]) if np.isfinite(off) else _WIDENED[0]
    return total


def contradicted(body: BodyModel, pose: Pose, clicked: Pose) -> bool:
    """Whether clicks put the body elsewhere than a pose has it, by more than following mends."""
    turn = float(np.linalg.norm(vector_from_rotation(clicked.torso @ pose.torso.T)))
    away = float(np.linalg.norm(clicked.position - pose.position))
    one, other = (body.frames(each).rotations[ARM_PARTS, :, 2] for each in (pose, clicked))
    return turn > _TURN or away > _PLACE or float(angle_between(one, other).max()) > _LIMB
