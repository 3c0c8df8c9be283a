"""A subject from a few clicked frames and a run: lengths, and where the bones lie in the body.

The tracker registers cones to the cloud; a person clicks the skeleton inside. The offset between
both is the person's, alike in all frames (:mod:`body.offsets`). It is the mean of its posterior:
people differ by a centimetre, and each frame is blurred by the clicks and by the tracked pose.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
import scipy

from stereotrack_core.annotation.click import Click, Sigmas, measurements
from stereotrack_core.annotation.click_points import MeasuredLength, click_pixels, measured_lengths
from stereotrack_core.annotation.fit.fit import ClickFit, clicks_in
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.model import BodyModel, landmarks_of_frames
from stereotrack_core.body.offsets import NO_OFFSETS, TRUNK, offset_axes, offsets_by_landmark
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.proportions import AVERAGE, Proportions, proportions_of
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.shape_fit import LENGTH_SIGMAS, FreeBody
from stereotrack_core.tracking.stored import body_of_run, pose_of_run, subject_of_meta
from stereotrack_core.worker_processes import Asker

PRESET = "accurate"  # preset for tracking if there is no run yet
FEWEST = 3  # clicked frames that bring the first gain (docs/personal.md)


@dataclass(frozen=True, eq=False)
class PersonalSubject:
    """A subject by clicks, the one that was tracked before, and how certain the offsets are."""

    subject: Subject
    before: Subject  # with all lengths of the body that was tracked
    found: PersonalOffsets


def offset_table(one: PersonalSubject) -> Table:
    """Offsets of every landmark with their standard deviations, and those before."""
    rows = []
    for name, offsets, sigma in zip(LANDMARKS, one.found.offsets, one.found.sigma, strict=True):
        before = 1000.0 * np.array(one.before.offsets.get(name, (0.0, 0.0, 0.0)))
        cells = (
            f"{1000 * value:+z.0f} ± {1000 * spread:.0f}"
            for value, spread in zip(offsets, sigma, strict=True)
        )
        was = " ".join(f"{value:+z.0f}" for value in before) if before.any() else "none"
        rows.append((name.replace("_", " "), *cells, was))
    title = f"Offsets from {counted(len(one.found.frames), 'clicked frame')}, mm"
    heads = ("landmark", ">right / along", ">front / inwards", ">up / across", ">before")
    return Table(title, heads, rows)


def lean_words(one: PersonalSubject) -> str:
    """``The trunk leans +1.2 ± 0.4 degrees forward of the tracked one.``"""
    degrees, spread = one.found.lean(proportions_of(one.subject).torso_length)
    return f"The trunk leans {degrees:+z.1f} ± {spread:.1f} degrees forward of the tracked one."


def left_out_words(one: PersonalSubject) -> tuple[str, ...]:
    """Landmarks that the estimate leaves out, a sentence each."""
    why = "tracker and clicks contradict each other; left out"
    named = ((frame, name.replace("_", " ")) for frame, name in one.found.left_out)
    return tuple(f"frame {frame}, {name}: {why}" for frame, name in named)


@dataclass(frozen=True, eq=False)
class Personalise:
    """Estimate a subject from clicks and a run, also as a task of a process.

    Without a run the frames up to the last clicked one are tracked first.
    """

    recording: Recording  # with the subject that is known
    clicks: tuple[Click, ...]
    sigma: Sigmas
    settings: FitSettings
    where: str
    run: Run | None = None
    views: Sequence[str] | None = None  # in which clicks count; all if not given

    @cached_property
    def by_frame(self) -> dict[int, list[Click]]:
        """Clicks of the nine landmarks as measurements, by frame."""
        used = clicks_in(self.recording, self.clicks, self.views)
        by_frame: dict[int, list[Click]] = defaultdict(list)
        for click in measurements(used, NINE.names, self.sigma):
            by_frame[click.frame].append(click)
        return dict(by_frame)

    def __call__(self, asker: Asker) -> PersonalSubject:
        """Do it in the process."""
        return self.estimated(lambda _frame: asker.on_frames(1), asker.cancelled)

    def estimated(
        self, on_frame: Callable[[int], None], cancelled: Callable[[], bool]
    ) -> PersonalSubject:
        """Lengths and offsets. Raises InputError if no clicked frame tells them; Cancelled."""
        run = self._tracked(on_frame, cancelled) if self.run is None else self.run
        if cancelled():
            raise Cancelled
        body, own = body_of_run(run), self.recording
        lengths = body.skeleton.proportions
        fit = ClickFit(own.cameras, NINE, lengths, self.settings, fps=own.fps)
        clicked = []
        for i in np.flatnonzero(np.isin(run.frame, list(self.by_frame))):
            frame, pose = int(run.frame[i]), pose_of_run(run, int(i))
            if pose is not None:
                clicked.append(clicked_frame(frame, self.by_frame[frame], fit, body, pose))
        found = personal_offsets(clicked)
        if not found.frames:
            remedy = (
                "Click the trunk and the arms in at least two views of frames in which the tracker "
                "follows the person."
            )
            what = "no clicked frame is tracked and clicked well enough"
            raise InputError(what, self.where, remedy)
        before = replace(subject_of_meta(run.meta) or Subject(), **asdict(lengths))
        name = (own.subject or Subject()).name or own.name
        offsets = offsets_by_landmark(found.offsets)
        return PersonalSubject(replace(before, name=name, offsets=offsets), before, found)

    def _tracked(self, on_frame: Callable[[int], None], cancelled: Callable[[], bool]) -> Run:
        """The frames up to the last clicked one, tracked now with known or clicked lengths."""
        if self.recording.subject is None:
            used = clicks_in(self.recording, self.clicks, self.views)
            measured = measured_lengths(click_pixels(used, self.recording.cameras, LANDMARKS))
            lengths = lengths_by_clicks(measured)
        else:
            lengths = proportions_of(self.recording.subject)
        own = self.recording.subject or Subject(self.recording.name)
        known = replace(own, **asdict(lengths))
        unaided = replace(self.recording, reference=None, subject=known)
        return track(
            unaided,
            RunSpec(preset(PRESET, ()), preset=PRESET, frames=range(max(self.by_frame) + 1)),
            on_advance=lambda advance: on_frame(advance.gained.first),
            hooks=Hooks(cancelled=cancelled),
        )


_SPREAD: Mapping[str, tuple[tuple[float, float, float], float]] = MappingProxyType(
    {
        "shoulder": ((0.003, 0.007, 0.007), 0.003),
        "hip": ((0.003, 0.007, 0.007), 0.003),
        "elbow": ((0.005, 0.004, 0.010), 0.003),
        "hand": ((0.006, 0.006, 0.008), 0.003),
    }
)
"""Standard deviations among people, metres: along the three axes, shared by both sides, and of each
side from that.

Hip joint centres that are predicted from the body's surface are off by 12 mm with a standard
deviation of 6 mm in 67 people (Mantovani et al. 2016, Harrington's regression), so 8 mm along each
axis. Little of that is sideways: the surface is seen from both sides. Those of arms, and what
follows, are as large as on two rendered human meshes (docs/annotation-fit.md).
"""

_HEAD = 0.010  # metres; annotators place the head differently
_MOVED, _TURNED, _BENT = 0.006, np.radians(1.5), 0.040
"""Metres and radians by which a tracked trunk is off in a frame, and metres more for the sine of
its inclination: a rigid trunk cannot follow a bent spine."""

_TRUNK_OFF, _ARM_OFF = 0.005, 0.016  # metres per axis by which tracked landmarks are off besides
_TOGETHER = 2.0
"""Factor on the clicks' variances: landmarks of one trunk are off together, and count as one
another's witnesses here. What the fit says of them jointly is too sure of their differences: with
it, ten frames clicked at 10 px made things worse."""

_LENGTH_OFF = 0.02
"""Metres by which one clicked length is off at least; how far a few of them scatter says little,
so that all lengths are believed to scatter as much as their median does."""

_ONE_RADIAN = 0.45  # metres of the trunk, over which bending turns it
_KNOWN = 0.10  # metres of standard deviation beyond which the clicks do not show a landmark
_CONTRADICTS = 21.1  # of chi squared with three degrees of freedom in one right case of 10,000


@dataclass(frozen=True, eq=False)
class ClickedFrame:
    """One clicked frame: what the clicks show, and what was tracked there."""

    frame: int
    places: FloatArray  # (9, 3), world, metres. Landmarks that the clicks show.
    covariance: FloatArray  # (9, 3, 3), square metres, world
    tracked: FloatArray  # (9, 3), world, metres; of the tracked surface, without offsets
    frames: PartFrames  # frames of the parts in the tracked pose

    @property
    def known(self) -> BoolArray:
        """Landmarks (9,) that the clicks show."""
        return np.linalg.eigvalsh(self.covariance)[:, -1] < _KNOWN**2


@dataclass(frozen=True, eq=False)
class PersonalOffsets:
    """Where a person's landmarks lie in the tracked body, and how certain that is."""

    offsets: FloatArray  # (9, 3), metres; see :mod:`body.offsets`
    covariance: FloatArray  # (27, 27), square metres
    frames: tuple[int, ...]  # frames that they were estimated from
    left_out: tuple[tuple[int, str], ...]  # where tracker or clicks were wrong

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations (9, 3), metres."""
        return np.sqrt(np.diagonal(self.covariance)).reshape(-1, 3)

    def lean(self, torso_length: float) -> tuple[float, float]:
        """Degrees by which the trunk leans forward of the tracked one, and their sigma."""
        weights = np.zeros((len(LANDMARKS), 3))
        for k, name in enumerate(LANDMARKS):
            weights[k, 1] = 0.5 * (name.endswith("shoulder") - float(name.endswith("hip")))
        w = weights.ravel() / torso_length
        slope, variance = float(w @ self.offsets.ravel()), float(w @ self.covariance @ w)
        return float(np.degrees(slope)), float(np.degrees(np.sqrt(variance)))


def lengths_by_clicks(measured: Mapping[str, MeasuredLength]) -> Proportions:
    """Lengths that a few clicked frames tell, held to those of average people (height, others)."""
    free = FreeBody(AVERAGE, BodyShape(), lengths=tuple(LENGTH_SIGMAS), surface=())
    A, b = free.information, np.zeros(len(free.lengths))
    every = [one.sigma * np.sqrt(one.count) for one in measured.values()]
    scatter = max(_LENGTH_OFF, float(np.median(every)) if every else 0.0)
    for name, one in measured.items():
        expected = float(getattr(AVERAGE, name))
        row = np.zeros(len(b))
        if name == "elbow_to_hand":
            share = AVERAGE.forearm_length / expected
            row[free.lengths.index("forearm_length")] = share
            row[free.lengths.index("hand_length")] = 1.0 - share
        else:
            row[free.lengths.index(name)] = 1.0
        sigma = float(np.hypot(one.sigma, scatter / np.sqrt(one.count))) / expected
        A = A + np.outer(row, row) / sigma**2
        b = b + row * np.log(one.length / expected) / sigma**2
    theta: FloatArray = np.asarray(np.linalg.solve(A, b), dtype=np.float64)
    return free.parts(theta)[0]


def clicked_frame(
    frame: int, clicks: Sequence[Click], fit: ClickFit, body: BodyModel, pose: Pose
) -> ClickedFrame:
    """Fit the skeleton to the clicks of a frame, beside the pose tracked there, without offsets."""
    found = fit.frame(clicks)
    frames = body.frames(pose)
    tracked = landmarks_of_frames(replace(body, offsets=NO_OFFSETS), frames)
    return ClickedFrame(frame, found.landmarks_world, found.landmark_covariance, tracked, frames)


def prior_covariance() -> FloatArray:
    """Covariance (27, 27) with which people differ, square metres; sides differ little."""
    P = np.zeros((3 * len(LANDMARKS), 3 * len(LANDMARKS)))
    for k, name in enumerate(LANDMARKS):
        side, _, place = name.rpartition("_")
        own = slice(3 * k, 3 * k + 3)
        if place not in _SPREAD:
            P[own, own] = _HEAD**2 * np.eye(3)
            continue
        shared, apart = _SPREAD[place]
        P[own, own] = np.diag(np.square(shared) + apart**2)
        if side == "left":
            other = 3 * LANDMARKS.index(f"right_{place}")
            P[own, other : other + 3] = P[other : other + 3, own] = np.diag(np.square(shared))
    return P


def personal_offsets(clicked: Sequence[ClickedFrame]) -> PersonalOffsets:
    """Offsets that clicked frames tell, mean of their posterior; contradictions left out."""
    P = prior_covariance()
    A, b = np.linalg.inv(P), np.zeros(len(P))
    used, left_out = [], []
    for one in clicked:
        H = scipy.linalg.block_diag(*offset_axes(one.frames))  # by the offsets
        S = _blur(one)
        d = (one.places - one.tracked).ravel()
        expected = S + H @ P @ H.T
        kept = one.known.copy()  # and where both agree as well as they can
        for k in np.flatnonzero(kept):
            own = slice(3 * k, 3 * k + 3)
            kept[k] = d[own] @ np.linalg.solve(expected[own, own], d[own]) < _CONTRADICTS
        left_out += [(one.frame, LANDMARKS[k]) for k in np.flatnonzero(one.known & ~kept)]
        if not kept.any():
            continue
        used.append(one.frame)
        rows = np.repeat(kept, 3)
        W = np.linalg.inv(S[np.ix_(rows, rows)])
        A += H[rows].T @ W @ H[rows]
        b += H[rows].T @ W @ d[rows]
    covariance = np.linalg.inv(A)
    offsets = (covariance @ b).reshape(-1, 3)
    return PersonalOffsets(offsets, covariance, tuple(used), tuple(left_out))


def _blur(one: ClickedFrame) -> FloatArray:
    """Covariance (27, 27) of one frame's differences: of the clicks, and of the tracked pose."""
    count = len(LANDMARKS)
    S, moved = np.zeros((3 * count, 3 * count)), np.zeros((3 * count, 6))
    hips = one.frames.origins[TORSO]
    for k, name in enumerate(LANDMARKS):
        own = slice(3 * k, 3 * k + 3)
        off = _TRUNK_OFF if name.rpartition("_")[2] in TRUNK else _ARM_OFF
        S[own, own] = _TOGETHER * one.covariance[k] + off**2 * np.eye(3)
        moved[own, :3] = np.eye(3)
        moved[own, 3:] = np.cross(np.eye(3), one.tracked[k] - hips).T
    bent = _BENT * np.sqrt(max(0.0, 1.0 - one.frames.rotations[TORSO, 2, 2] ** 2))
    shifts, turns = np.hypot(_MOVED, bent), np.hypot(_TURNED, bent / _ONE_RADIAN)
    return np.asarray(S + (moved * np.repeat([shifts**2, turns**2], 3)) @ moved.T)
