"""Errors of runs against what may explain them: worked out, and ready to be drawn."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.evaluation.circumstances import (
    Circumstances,
    circumstances_of,
    trend,
    views_that_see,
)
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording

from ...services.tasks.task import Task, TaskList
from ...session.judgement import MEASURED_LIMBS, Judgement, reference_at
from ...session.runs import RunEntry
from ...widgets.plots.cloud_plot import CloudContent, PointCloud, style_at
from ...widgets.plots.histograms import Steps
from ...widgets.style.limb_colours import LIMB_COLOURS
from .per_run import PerRun

KINDS: tuple[tuple[str, str], ...] = (
    ("histogram", "% of frames over error [deg]"),
    ("distance", "error [deg] over distance from the nearest camera [m]"),
    ("speed", "error [deg] over speed of the limb's far end [m/s]"),
    ("views", "error [deg] over number of views with an unoccluded limb"),
)
"""What can be drawn: key and words."""

_BIN_DEG = 2.5
_LAST_DEG = 90.0
_APART = 0.07


@dataclass(frozen=True, eq=False)
class Explained:
    """A run with its circumstances; F frames of the run, limbs in the order of ``LIMBS``."""

    name: str
    judgement: Judgement
    circumstances: Circumstances
    views: FloatArray | None = None
    """Shape (F, 6). How many views see each limb; None while that is not worked out."""

    def against(self, kind: str) -> FloatArray | None:
        """What stands on the x axis (F, 6); None while it is not known."""
        if kind == "views":
            return self.views
        return self.circumstances.distance if kind == "distance" else self.circumstances.speed


class RunCircumstances:
    """Keeps the circumstances of runs, and what each view sees of them."""

    def __init__(self, tasks: TaskList, growing: Callable[[], RunEntry | None]) -> None:
        self._growing = growing
        self.views: PerRun[FloatArray] = PerRun(tasks, "computing visibility")
        self._known: WeakKeyDictionary[RunEntry, tuple[Judgement, Circumstances]]
        self._known = WeakKeyDictionary()

    def explained(
        self,
        entries: Sequence[RunEntry],
        judgements: Mapping[RunEntry, Judgement],
        recording: Recording,
        *,
        with_views: bool,
    ) -> list[Explained]:
        """Runs with what is known about them; asks for what each view sees where that is wanted."""
        result = []
        for entry in entries:
            judgement = judgements.get(entry)
            if judgement is None or not len(judgement.frame):
                continue
            known = self._known.get(entry)
            if known is None or known[0] is not judgement:
                known = (judgement, circumstances(entry, judgement, recording))
                self._known[entry] = known
            state = judgement.truth, len(judgement.frame)
            if with_views and entry is not self._growing():
                self._ask(entry, judgement, recording, state)
            seen = self.views.of(entry, state)
            result.append(Explained(entry.name, judgement, known[1], seen))
        return result

    def _ask(
        self, entry: RunEntry, judgement: Judgement, recording: Recording, state: Hashable
    ) -> None:
        if self.views.asked(entry) == state:
            return
        cameras, body, frames = cameras_of(entry, recording), entry.body, poses(entry, judgement)

        def work(task: Task) -> FloatArray:
            return views_that_see(
                body, frames, cameras,
                on_progress=lambda done: task.report(done / len(frames)),
                cancelled=task.token.cancelled,
            )  # fmt: skip

        self.views.ask(entry, state, work)


def places(entry: RunEntry, judgement: Judgement) -> FloatArray:
    """Landmarks (F, 9, 3) of a run's frames: the reference's where there is one, else its own."""
    if judgement.truth is None:
        return np.array([entry.frames[k].landmarks for k in judgement.frame.tolist()])
    known = judgement.truth.trajectory
    points: FloatArray = np.full((len(judgement.frame), 9, 3), np.nan)
    _, own, other = np.intersect1d(judgement.frame, known.frame, return_indices=True)
    points[own] = known.points[other]
    return points


def poses(entry: RunEntry, judgement: Judgement) -> list[Pose | None]:
    """Poses of a run's frames: by the reference where it knows all landmarks, else the run's."""
    result: list[Pose | None] = []
    truth = None if judgement.truth is None else judgement.truth.trajectory
    for tracked in (entry.frames[k] for k in judgement.frame.tolist()):
        points = reference_at(truth, tracked.frame)
        true = None if points is None else _pose(points)
        result.append(tracked.pose if true is None else true)
    return result


def circumstances(entry: RunEntry, judgement: Judgement, recording: Recording) -> Circumstances:
    """Distances and speeds in a run's frames."""
    cameras = cameras_of(entry, recording)
    return circumstances_of(judgement.frame, places(entry, judgement), cameras, recording.fps)


def cameras_of(entry: RunEntry, recording: Recording) -> list[Camera]:
    """Reference cameras of the views that a run was tracked with; all where it does not say."""
    used: Sequence[str] = ()
    if entry.origin is not None:
        used = entry.origin.spec.views or ()
    elif entry.stored is not None:
        used = entry.stored.meta.get("views") or ()
    chosen = [view for view in recording.views if view.name in used] or recording.views
    return [recording.reference_camera(view) for view in chosen]


def content_of(
    kind: str, runs: Sequence[Explained], selection: range | None
) -> CloudContent | None:
    """What is drawn; None where there is nothing.

    Parameters
    ----------
    kind : str
        Key of :data:`KINDS`.
    runs : sequence of Explained
        The active one first.
    """
    if not runs:
        return None
    if kind == "histogram":
        return _histogram(runs, selection)
    clouds = tuple(
        cloud for place, run in enumerate(runs) for cloud in _clouds(kind, run, place, selection)
    )
    said = _words(kind, runs, selection)
    return CloudContent(said, kind == "views", clouds)


def _clouds(kind: str, run: Explained, place: int, selection: range | None) -> list[PointCloud]:
    x = run.against(kind)
    if x is None:
        return []
    frame = run.judgement.frame
    chosen = np.ones(len(frame), dtype=np.bool_) if not selection else np.isin(frame, selection)
    result = []
    for i, limb in enumerate(MEASURED_LIMBS):
        own, y = x[:, LIMBS.index(limb)], run.judgement.limbs[limb]
        # the curve is that of the selection, where it says enough
        curve = trend(own[chosen], y[chosen])
        # whole numbers would hide each other: every limb stands a little aside
        aside = _APART * (i - (len(MEASURED_LIMBS) - 1) / 2.0) if kind == "views" else 0.0
        result.append(
            PointCloud(
                run.name, place, limb, LIMB_COLOURS[limb], frame, own + aside, y, chosen,
                curve.x + aside, curve.median, curve.low, curve.high,
            )
        )  # fmt: skip
    return result


def _histogram(runs: Sequence[Explained], selection: range | None) -> CloudContent:
    edges = np.arange(0.0, _LAST_DEG + _BIN_DEG, _BIN_DEG)
    steps = []
    top = 0.0
    for place, run in enumerate(runs):
        frame = run.judgement.frame
        chosen = np.ones(len(frame), dtype=np.bool_) if not selection else np.isin(frame, selection)
        for limb in MEASURED_LIMBS:
            values = run.judgement.limbs[limb][chosen]
            known = np.minimum(values[np.isfinite(values)], _LAST_DEG - 1e-9)
            if not len(known):
                continue
            top = max(top, float(known.max()))
            share = 100.0 * np.histogram(known, edges)[0] / len(known)
            style, colour = style_at(place), LIMB_COLOURS[limb]
            steps.append(Steps(run.name, place, limb, colour, style, edges, share))
    last = int(np.searchsorted(edges, top, side="right"))
    steps = [replace(s, edges=s.edges[: last + 1], height=s.height[:last]) for s in steps]
    return CloudContent(_words("histogram", runs, selection), steps=tuple(steps))


def _words(kind: str, runs: Sequence[Explained], selection: range | None) -> str:
    judgement = runs[0].judgement
    if judgement.truth is None:
        said = "No reference: the tracker's standard deviation is shown in place of the error."
    else:
        said = f"Errors against {judgement.truth.words}."
    if kind == "histogram":
        said += " The last bin includes all larger errors." if _reaches_end(runs) else ""
        return f"{said} {_selected(selection)}".strip()
    if kind == "views" and any(run.views is None for run in runs):
        said += " Visibility is being computed."
    elif kind == "views":
        said += (
            " A view counts as unoccluded where at least half of the limb's camera-facing surface "
            "is visible."
        )
    lines = " Lines: running medians with quartile bands. Click a point to go to its frame."
    if len(runs) > 1:
        lines += " Other runs have other symbols and line styles."
    return f"{said}{lines} {_selected(selection)}".strip()


def _reaches_end(runs: Sequence[Explained]) -> bool:
    with np.errstate(invalid="ignore"):
        return any(np.any(v >= _LAST_DEG) for run in runs for v in run.judgement.limbs.values())


def _selected(selection: range | None) -> str:
    if not selection:
        return ""
    return f"Frames {selection.start} – {selection.stop - 1} are selected."


def _pose(points: FloatArray) -> Pose | None:
    try:
        pose = pose_of_landmarks(points)
    except ValueError:
        return None
    return pose if np.isfinite(pose.rotations).all() else None
