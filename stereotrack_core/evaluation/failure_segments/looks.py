"""Evidence on the limbs in pictures and clouds of single frames, view by view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.skeleton import HEAD, TORSO
from stereotrack_core.body.surface import limbs_of_cones, nearest_on_surface
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.evaluation.limbs import limb_ends
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.clouds import CloudSource
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, pose_of_run
from stereotrack_core.work import NO_WORK, Work

_ALONG = np.linspace(0.15, 1.0, 7)
_THICK = 0.05  # metres from a limb's axis to its surface, about
_AGREES = 0.13  # metres by which a range may differ from a limb's
_STRAY, _NEAR = 0.30, 0.60  # metres: from the person, to be a stranger's; from a limb
_FITS = 0.12  # metres from torso and head within which points tell how well a view fits
_LEAST_FITTING = 60


@dataclass(frozen=True, eq=False)
class Look:
    """One frame as the views measured it; V views."""

    frame: int
    points: FloatArray  # (V,). Points of each view in the cloud.
    agreed: FloatArray
    before: FloatArray
    unknown: FloatArray
    """`agreed`, `before` and `unknown`: (V, 6). Of places along each limb's axis, the shares that a
    view measures where they are, before which it measures something, and where it measures
    nothing. NaN for limbs whose place is not known."""
    stray: FloatArray  # (6,); points near each limb that are not the person's, over all points
    offset: FloatArray
    """(V, 3), metres. Movement of each view's points that would lay them onto torso and head; NaN
    where too few of them are there."""


class Looker:
    """Makes the clouds of single frames of a run's recording, with the run's views and settings."""

    def __init__(self, recording: Recording, run: Run) -> None:
        self._run = run
        known = {row.name for row in DepthParameters.rows()}
        stored = {k: v for k, v in run.meta.get("parameters", {}).items() if k in known}
        views = [v for v in run.meta.get("views", []) if v in {w.name for w in recording.views}]
        used = usable_views(recording, views or None)
        self._reader = FrameReader(recording, views=used, colour=False)
        given = DepthParameters().replaced(**stored)
        parameters = settled(recording, given, self._reader, used)
        self._chain = DepthChain(recording, parameters, views=used)
        self._body = body_of_run(run)
        self._learned = False

    @property
    def view_names(self) -> tuple[str, ...]:
        """Views in the order of the looks' rows."""
        return self._chain.view_names

    def __enter__(self) -> Looker:
        return self

    def __exit__(self, *_: object) -> None:
        self._chain.close()
        self._reader.close()

    def looks(self, frames: Sequence[int], points: FloatArray, work: Work = NO_WORK) -> list[Look]:
        """Look at some frames, ascending, with landmarks at `points` (F, 9, 3)."""
        if not self._learned:
            last = int(self._run.frame[-1]) if len(self._run.frame) else 0
            self._chain.learn_background(self._reader, range(last + 1))
            self._learned = True
        found = []
        for i, frame in enumerate(frames):
            work.step(i / len(frames), "analysing frames")
            cloud, _ = CloudSource(self._chain, self._reader).take(int(frame))
            found.append(self._look(cloud, points[i]))
        return found

    def _look(self, cloud: Cloud, landmarks: FloatArray) -> Look:
        names = cloud.view_names
        start, end = np.moveaxis(limb_ends(landmarks[None])[0], 1, 0)
        shares = np.full((3, len(names), len(LIMBS)), np.nan)
        for v, name in enumerate(names):
            depth = cloud.depths.get(name)
            for limb in range(len(LIMBS)):
                if np.isfinite([start[limb], end[limb]]).all():
                    shares[:, v, limb] = _shares(depth, start[limb], end[limb])
        return Look(
            frame=cloud.frame,
            points=np.bincount(cloud.view, minlength=len(names)).astype(np.float64),
            agreed=shares[0],
            before=shares[1],
            unknown=shares[2],
            stray=_stray(cloud.points, start, end),
            offset=self._offsets(cloud),
        )

    def _offsets(self, cloud: Cloud) -> FloatArray:
        result: FloatArray = np.full((len(cloud.view_names), 3), np.nan)
        for i in np.flatnonzero(self._run.frame == cloud.frame):
            pose = pose_of_run(self._run, int(i))
            if pose is None:
                continue
            placed = placed_cones(self._body, self._body.frames(pose))
            closest = nearest_on_surface(cloud.points, placed, np.inf)
            limb = limbs_of_cones(self._body, closest.cone)
            fits = (np.abs(closest.distance) < _FITS) & np.isin(limb, (TORSO, HEAD))
            for v in range(len(result)):
                own = fits & (cloud.view == v)
                if own.sum() >= _LEAST_FITTING:
                    # movement that takes the distances away, as far as they determine it
                    direction, distance = closest.direction[own], closest.distance[own]
                    normal = direction.T @ direction + 0.1 * len(direction) * np.eye(3)
                    result[v] = np.linalg.solve(normal, direction.T @ distance)
            result -= self._swelling(cloud, result, pose.position)
        return result

    def _swelling(self, cloud: Cloud, offset: FloatArray, person: FloatArray) -> FloatArray:
        """Part (V, 3) of the offsets that is one distance from all cameras: a wrong thickness."""
        geometry = self._chain.geometry
        centres = [geometry[name].world_from_depth.translation for name in cloud.view_names]
        towards = np.array(centres) - person
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        along = np.einsum("vi,vi->v", offset, towards)
        known = along[np.isfinite(along)]
        # of two views nobody can tell what is common to all
        return towards * (known.mean() if len(known) > 2 else 0.0)


def _shares(depth: ViewDepth | None, start: FloatArray, end: FloatArray) -> FloatArray:
    """Shares (3,) of places along an axis: measured there, before it, not at all."""
    if depth is None:
        return np.array([0.0, 0.0, 1.0])
    g = depth.geometry
    places = start + _ALONG[:, None] * (end - start)
    seen = g.world_from_depth.inverse().apply(places)
    z = np.maximum(seen[:, 2], 1e-6)
    u = np.round(g.focal * seen[:, 0] / z + g.c_x).astype(np.int64)
    v = np.round(g.focal * seen[:, 1] / z + g.c_y).astype(np.int64)
    inside = (u >= 0) & (v >= 0) & (u < g.width) & (v < g.height) & (seen[:, 2] > 0.1)
    measured = np.full(len(places), np.nan)
    measured[inside] = depth.range_z[v[inside], u[inside]]
    off = measured - (z - _THICK)
    counts = (np.abs(off) <= _AGREES, off < -_AGREES, np.isnan(off))
    return np.array([float(np.mean(each)) for each in counts])


def _stray(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Share (6,) of the cloud near each limb and not the person's; legs may be below the hips."""
    result = np.zeros(len(LIMBS))
    known: BoolArray = np.isfinite((start + end).sum(axis=1))
    if not len(points) or not known[TORSO]:
        return result
    p = points[:, None]
    away = segment_distance(p, p, start[None], end[None])
    away[:, ~known] = np.inf
    hips = start[TORSO]
    beside = np.linalg.norm(points[:, :2] - hips[:2], axis=1)
    legs = (points[:, 2] < hips[2] + 0.1) & (beside < 0.6)
    foreign: FloatArray = np.where(legs, 0.0, away.min(axis=1))
    for limb in np.flatnonzero(known):
        near = away[:, limb] < _NEAR + _STRAY
        result[limb] = np.count_nonzero((foreign > _STRAY) & near) / len(points)
    return result
