"""What a whole run says: whether body, cameras and clouds fit, and why frames were not tracked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import ARM_PARTS
from stereotrack_core.depth.cloud import PointCounts
from stereotrack_core.depth.lost_points import Cause, LostPoints
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints, joined_keypoints
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.sighted_keypoints import KeypointsByFrame, keypoints_in_views
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.initialise.heading import ENOUGH
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.residuals.reprojection import KeypointFit, KeypointObservation
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.view_watch import views_left_out

WARNINGS = "warnings"  # key of a run's meta
HEADING = "heading"  # key of a run's meta: how sure it is which way the person faces
# Probability of a heading below which it is undecided. To turn a run round more is needed: what is
# right must not be made wrong.
LIKELY = 0.95
# Unexplained fraction, median over the tracked frames, above which nothing fits: sound recordings
# have 0.05 to 0.28, wrong calibrations 0.15 to 0.6 (docs/runs.md).
MOST_UNEXPLAINED = 0.3
# Share of the points that other views see through, median over the frames asked, above which views
# do not fit each other: sound recordings have up to 0.015, wrong calibrations mostly 0.04 to 0.7
# (docs/runs.md).
MOST_CONTRADICTED = 0.03
# Mean probability that an arm segment is lost above which a run has probably gone wrong: sound runs
# have 0.03 to 0.08, those that lost 2 to 50 % of the arms 0.16 to 0.47 (docs/runs.md).
MOST_LOST = 0.12
_ENOUGH_ARMS = 40  # arm segments of tracked frames without which their mean says little
# Measures of pictures, the medians beyond which arms suffer (docs/accuracy.md), and clauses.
_POOR = (
    ("noise", 6.0, "have noise of {:.0f} grey levels"),
    (
        "blur",
        0.7,
        "have lost detail against that of the empty scene, by focus, movement or "
        "compression, as by a blur of {:.1f} px",
    ),
)
MOST_LEFT_OUT = 0.05  # share of the frames in which a view may be left out without a warning
_MOST_BESIDE = 0.2  # share of a camera's images in which keypoints may be left out
_LEFT, _RIGHT = (LANDMARKS.index(f"{side}_shoulder") for side in ("left", "right"))
_TURNED = np.radians(120.0)  # turn of the shoulders between successive frames that nobody makes

CHECK = (
    "Look for the cause with `stereotrack info --deep`: it compares the light and the cameras' "
    "places with the pictures of the empty scene, and tells whether views or cameras are swapped, "
    "a rotation inverted, or a baseline or unit wrong."
)


def misfits(frames: Iterable[TrackedFrame], settings: Settings) -> tuple[str, ...]:
    """What looks wrong about a run, as clauses; :data:`CHECK` is what to do.

    What is unexplained says nothing about trackers whose body has no legs, or whose model looks for
    the data.
    """
    every, found = list(frames), []
    views = [frame.contradicted for frame in every if np.isfinite(frame.contradicted)]
    if views and (through := float(np.median(views))) > MOST_CONTRADICTED:
        found.append(
            f"{100 * through:.0f} % of the points of one view lie where another view sees the "
            "background behind them (hardly any in good recordings); the views are inconsistent"
        )
    with_legs = settings.tracking.matching == "data_to_model" and settings.body.legs
    shares = [frame.estimate.unexplained_fraction for frame in every if frame.tracked]
    shares = [share for share in shares if np.isfinite(share)]
    if with_legs and shares and (unexplained := float(np.median(shares))) > MOST_UNEXPLAINED:
        found.append(
            f"{100 * unexplained:.0f} % of the cloud is not explained by the body (at most 28 % "
            "in good recordings); the poses are probably wrong"
        )
    lost = [frame.estimate.limb_lost[ARM_PARTS] for frame in every if frame.tracked]
    expected = float(np.nanmean(lost)) if np.isfinite(lost).sum() > _ENOUGH_ARMS else 0.0
    if expected > MOST_LOST:
        found.append(
            f"{100 * expected:.0f} % of the arms are expected to be lost (3 to 8 % in good runs)"
        )
    pictures = (*_left_out(every), *_keypoints_left_out(every), *_poor_pictures(every))
    return (*found, *_turns(every), *pictures)


def _turns(frames: Sequence[TrackedFrame]) -> Iterator[str]:
    """Frames at which the body turned round at once, as a clause."""
    tracked = [frame for frame in frames if frame.tracked]
    shoulders = [f.landmarks[_RIGHT] - f.landmarks[_LEFT] for f in tracked]
    turned = [
        later.frame
        for later, a, b in zip(tracked[1:], shoulders[:-1], shoulders[1:], strict=True)
        if angle_between(a, b) > _TURNED
    ]
    if turned:
        numbers = ", ".join(map(str, turned[:5])) + (" ..." if len(turned) > 5 else "")
        yield (
            f"the body turned round from one frame to the next ({numbers}), so left and right are "
            "exchanged before or after; --heading states the direction at the first frame"
        )


def _left_out(frames: Sequence[TrackedFrame]) -> Iterator[str]:
    """Views that were left out in many frames, as clauses."""
    told = [(view, f.frame) for f in frames for view in views_left_out(f.problems)]
    for view in dict.fromkeys(view for view, _ in told):
        at = [frame for name, frame in told if name == view]
        if len(at) > MOST_LEFT_OUT * len(frames):
            yield (
                f"view {view} contradicts the others in {len(at)} of {len(frames)} frames "
                f"({min(at)} to {max(at)}), in which it was not used; its camera was moved, is "
                "late, or sees something else as part of the person"
            )


def _keypoints_left_out(frames: Sequence[TrackedFrame]) -> Iterator[str]:
    """Cameras in whose pictures the pose detector saw something else, as clauses."""
    seen = joined_keypoints([f.keypoints for f in frames if f.keypoints is not None])
    for camera in seen.cameras:
        own = seen[seen.camera == camera]
        looked, used = (len(np.unique(one.frame)) for one in (own, own[own.confidence > 0.0]))
        if looked - used > _MOST_BESIDE * looked:
            yield (
                f"keypoints of the pose detector lie beside the person in {looked - used} of the "
                f"{looked} images of camera {camera} that it looked at, and were not used there"
            )


def _poor_pictures(frames: Sequence[TrackedFrame]) -> Iterator[str]:
    """Noise and blur of views that make arms clearly less accurate, as clauses."""
    for what, most, words in _POOR:
        seen: dict[str, list[float]] = {}
        for frame in frames:
            for view, counts in frame.cloud.counts.items():
                seen.setdefault(view, []).append(getattr(counts, what))
        poor = {view: level for view, one in seen.items() if (level := np.median(one)) > most}
        if poor:
            views, level = f"view{'s' * (len(poor) > 1)} {', '.join(poor)}", max(poor.values())
            yield (
                f"the images of {views} {words.format(level)} (median), so "
                "arms may be up to twice as inaccurate"
            )


@dataclass(frozen=True)
class HeadingWords:
    """What a run says of the way that the person faces."""

    brief: str
    what: str  # a clause
    remedy: str  # sentences
    undecided: bool = False


def heading_words(heading: Mapping[str, Any] | None) -> HeadingWords | None:
    """Words for what a run states as :data:`HEADING`; None where that is no doubt or correction."""
    known = heading or {}
    probability = float(known.get("probability", 0.5))
    enough = int(known.get("frames", ENOUGH)) >= ENOUGH
    if known.get("state") == "undecided" and probability < LIKELY and enough:
        chance = 100.0 * probability
        return HeadingWords(
            "undecided",
            "which way the person faces is undecided, so left and right may be exchanged in the "
            f"whole run (right with a probability of {chance:.0f} %)",
            "Track again with the direction: --heading, or Track, Initial pose in the window. Or "
            "click a left or right landmark and track with the clicks.",
            undecided=True,
        )
    if (at := known.get("against")) is not None:
        return HeadingWords(
            f"corrected at frame {at}",
            f"frame {at} showed that the person faces the other way than the run began with",
            "The frames before it were tracked again, with left and right exchanged.",
        )
    return None


def run_warnings(
    frames: Sequence[TrackedFrame], body: BodyModel | None, recording: Recording, spec: RunSpec
) -> tuple[str, ...]:
    """What looks wrong about a run and its keypoints, as clauses; see :func:`misfits`."""
    found = misfits(frames, spec.settings)
    poses = [(frame.frame, pose) for frame in frames if (pose := frame.pose) is not None]
    if body is None or spec.keypoints is None:
        return found
    views = spec.views or tuple(view.name for view in recording.views)
    return (*found, *disagreeing_keypoints(poses, body, recording, views, spec.keypoints))


@dataclass(frozen=True)
class Untracked:
    """Why frames of a run are not tracked."""

    causes: tuple[Cause, ...]  # what took the points; views with the same cause together
    counts: Mapping[str, PointCounts]
    """What was left after each step, by view: medians over the untracked frames."""


def untracked_in(
    frames: Iterable[TrackedFrame], recording: Recording, settings: Settings
) -> Untracked:
    """Why some of the frames, with or without clouds, are not tracked; empty if all are."""
    lost = LostPoints(recording, settings.depth, settings.tracking.least_points)
    reasons = Counter[str]()
    for frame in frames:
        if not frame.tracked:
            reasons[frame.reason] += 1
            lost.note(frame.cloud)
    return Untracked(lost.causes(reasons.most_common(1)[0][0]) if reasons else (), lost.counts)


_NUMBER = re.compile(r"\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Gap:
    """A stretch of frames, half-open, that are not tracked for one reason."""

    first: int
    end: int
    reason: str


@dataclass(frozen=True)
class Blindness:
    """A stretch of frames, half-open, in which a view gives nothing, for one reason."""

    view: str
    first: int
    end: int
    reason: str


def gaps_of(reasons: Iterable[tuple[int, str]]) -> tuple[Gap, ...]:
    """Join successive frames whose reasons differ in their numbers at most."""
    gaps: list[tuple[int, list[str]]] = []  # first frame, and the reason of each frame
    for frame, reason in reasons:
        if gaps:
            first, told = gaps[-1]
            alike = _NUMBER.sub("#", told[0]) == _NUMBER.sub("#", reason)
            if alike and first + len(told) == frame:
                told.append(reason)
                continue
        gaps.append((frame, [reason]))
    return tuple(Gap(first, first + len(told), _joined(told)) for first, told in gaps)


def _joined(reasons: Sequence[str]) -> str:
    """One sentence for sentences that differ in their numbers only."""
    spans = []
    for told in zip(*map(_NUMBER.findall, reasons), strict=True):
        low, high = min(told, key=float), max(told, key=float)
        spans.append(low if low == high else f"{low} to {high}")
    spoken = iter(spans)
    return _NUMBER.sub(lambda _: next(spoken), reasons[0])


def blind_stretches(frames: Iterable[TrackedFrame]) -> tuple[Blindness, ...]:
    """What views lack, in the order of the views that lacked something first."""
    told: dict[str, list[tuple[int, str]]] = {}
    for one in frames:
        for view, sentence in one.problems.items():
            reason = sentence.removeprefix(f"View {view} provides no depth: ")
            reason = reason.removeprefix(f"View {view}, frame {one.frame}: ").rstrip(".")
            told.setdefault(view, []).append((one.frame, reason))
    return tuple(
        Blindness(view, gap.first, gap.end, gap.reason)
        for view, reasons in told.items()
        for gap in gaps_of(reasons)
    )


# Metres from the body, at the person's distance, from which a keypoint disagrees with it. Guessed
# ones behind the trunk are up to 0.1 m off.
_FAR = 0.15
# Share of a view's pictures in which a keypoint that is named disagrees at least, two standard
# deviations below the share that was found; usual detectors have gross errors in less than 0.1.
_OFTEN = 0.2
_FEWEST = 5  # pictures without which nothing is said about a keypoint in a view
_MOST_FRAMES = 150  # looked at, spread over the run: the window does it at the end of a run
_NAMED = 6  # keypoints that are named; the others are counted


def keypoint_fits(
    poses: Iterable[tuple[int, Pose]], body: BodyModel, seen: KeypointsByFrame
) -> Iterator[KeypointFit]:
    """Fit keypoints of frames to their poses, with sides exchanged back as in tracking."""
    for frame, pose in poses:
        fit = KeypointObservation(seen(frame), 1.0).fitted(body, pose)
        if fit is not None:
            yield fit


def disagreeing_keypoints(
    poses: Sequence[tuple[int, Pose]],
    body: BodyModel,
    recording: Recording,
    views: Sequence[str],
    keypoints: Keypoints | None,
) -> tuple[str, ...]:
    """A clause that names the keypoints that disagree with the body; none if all agree.

    `poses` are of the tracked frames; `views` and `keypoints` were tracked with.
    """
    if keypoints is None or not poses:
        return ()
    seen = keypoints_in_views(recording, views, keypoints)
    chosen = poses[:: -(-len(poses) // _MOST_FRAMES)]
    off: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for fit in keypoint_fits(chosen, body, seen):
        pixels = np.linalg.norm(fit.seen.pixel - fit.predicted, axis=2)
        for k, v in np.argwhere(np.isfinite(pixels)).tolist():
            one = off.setdefault((fit.seen.names[k], fit.seen.cameras[v]), [])
            one.append((float(pixels[k, v]), float(fit.off[k, v])))
    views_of = {view.image.camera: view.name for view in recording.views}
    found: list[tuple[float, str]] = []
    for (name, camera), distances in off.items():
        pixels, metres = np.array(distances).T
        share = float(np.mean(metres > _FAR))
        uncertain = float(np.sqrt(share * (1.0 - share) / len(pixels)))
        if len(pixels) >= _FEWEST and share - 2.0 * uncertain >= _OFTEN:
            where = views_of.get(camera, camera)
            how = f"{100 * share:.0f} %, median {np.median(pixels):.0f} px"
            found.append((-share, f"{name} in {where} ({how})"))
    if not found:
        return ()
    named = [words for _, words in sorted(found)]
    more = f" and {len(named) - _NAMED} more" if len(named) > _NAMED else ""
    return (
        f"keypoints disagree with the body in many pictures: {', '.join(named[:_NAMED])}{more}; "
        "the order of their points (--layout), the person (--person) or the calibration may be "
        "wrong",
    )
