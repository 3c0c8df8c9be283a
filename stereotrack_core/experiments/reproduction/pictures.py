"""Picture strips and curves of the motions that the thesis shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_file
from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.evaluation.failure_segments.drawing import Shown, best_view, picture_strip
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.experiments.benchmark.growth import Timing
from stereotrack_core.experiments.reproduction.plan import Places, PlannedRun
from stereotrack_core.experiments.reproduction.tables import Outcome, source_name
from stereotrack_core.experiments.reproduction.thesis import FILTER_MS, MOTIONS, ThesisMotion
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.report.drawing import drawn_axes, image_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_QUALITY = 82


@dataclass(frozen=True)
class MotionPictures:
    """Pictures of one motion."""

    motion: ThesisMotion
    curves: bytes
    """Bytes. SVG."""
    strips: Mapping[str, bytes]
    frames: tuple[int, ...]
    """That the strips show."""


def motion_pictures(
    places: Places, recordings: Sequence[Recording], outcomes: Sequence[Outcome]
) -> tuple[MotionPictures, ...]:
    """Curves and strips of every motion whose runs are there; files of both beside the page."""
    by_name = {recording.name: recording for recording in recordings}
    made = []
    for motion in MOTIONS:
        own = [o for o in outcomes if o.recording == motion.recording]
        recording = by_name.get(motion.recording)
        found = [] if recording is None else recording.segments
        segment = next((s for s in found if s.name == motion.segment), None)
        if not own or segment is None or recording is None:
            continue
        frames = shown_frames(motion, segment)
        curves = motion_curves(own, motion)
        write_file(places.folder / f"figure-{motion.curves}.svg", curves)
        strips = _strips(places, recording, own, motion, frames)
        made.append(MotionPictures(motion, curves, strips, frames))
    return tuple(made)


def shown_frames(motion: ThesisMotion, segment: Segment) -> tuple[int, ...]:
    """The thesis's own frame numbers, moved to where the motion is here."""
    first, last = motion.frames[0], motion.frames[-1]
    length = segment.end - 1 - segment.first
    shares = [(frame - first) / (last - first) for frame in motion.frames]
    return tuple(segment.first + round(share * length) for share in shares)


def _strips(
    places: Places,
    recording: Recording,
    outcomes: Sequence[Outcome],
    motion: ThesisMotion,
    frames: Sequence[int],
) -> dict[str, bytes]:
    """One strip per preset, of its first seed; the same view for all."""
    plain = [o for o in outcomes if o.planned == PlannedRun(o.planned.preset)]
    strips: dict[str, bytes] = {}
    view = None
    for outcome in sorted(plain, key=lambda o: o.planned.preset == "thesis"):
        run = read_npz(places.run(recording.name, outcome.planned))
        view = view or best_view(recording, run, frames)
        strip = picture_strip(Shown(recording, run, (), recording.reference), frames, view)
        done, data = cv2.imencode(".jpg", strip, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        if done:
            name = source_name(outcome.planned)
            strips[name] = data.tobytes()
            file = places.folder / f"figure-{motion.pictures}-{outcome.planned.preset}.jpg"
            write_file(file, strips[name])
    return strips


_PANELS = (
    ("torso_long", "torso, long axis", "torso"),
    ("torso_cross", "torso, cross axis", "torso"),
    ("left_upper_arm", "left upper arm", "left_upper_arm"),
    ("right_upper_arm", "right upper arm", "right_upper_arm"),
    ("left_forearm", "left forearm", "left_forearm"),
    ("right_forearm", "right forearm", "right_forearm"),
)
_CROSSED = {"cross-arms": (65, 115)}
"""Frames after the first one between which the arms are crossed."""

_THESIS_COLOUR, _ANEW_COLOUR = "#1d2329", "#7b3294"
_LOST = 45.0


def motion_curves(outcomes: Sequence[Outcome], motion: ThesisMotion) -> bytes:
    """Errors of every limb over the frames of a motion, all ways of tracking over each other.

    The preset ``thesis`` as the mean of its seeds with a band from the least to the largest
    error; begun anew dashed; others in the limb's colour.
    """
    figure, axes = drawn_axes(3, 2, 9.0, 6.6)
    own = [o for o in outcomes if o.recording == motion.recording]
    own = [o for o in own if o.planned.way in {o.planned.preset, f"{o.planned.preset}-anew"}]
    for ax, (measure, title, limb) in zip(axes, _PANELS, strict=True):
        for source in dict.fromkeys(source_name(o.planned) for o in own):
            frames, degrees = _curves(
                [o for o in own if source_name(o.planned) == source], motion, measure
            )
            _draw(ax, source, frames, degrees, LIMB_COLOURS[limb])
        _mark(ax, own, motion)
        ax.set_title(title, loc="left", fontsize=9.5)
        ax.set_ylim(0, 180)
        ax.set_yticks(range(0, 181, 45))
    for ax in axes[-2:]:
        ax.set_xlabel("frame")
    for ax in axes[::2]:
        ax.set_ylabel("error [deg]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=max(1, len(labels)))
    return image_of(figure, "svg")


def timing_curve(timings: Sequence[Timing]) -> bytes:
    """Time of the tracker's step over the number of points; the thesis's one known number too."""
    figure, axes = drawn_axes(1, 1, 6.4, 3.6)
    ax = axes[0]
    styles = zip(("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#8c8c8c"), "os^Dv", strict=True)
    for timed, (colour, sign) in zip(timings, styles, strict=False):
        sizes = [cost.size for cost in timed.costs]
        times = [cost.milliseconds for cost in timed.costs]
        ax.plot(sizes, times, color=colour, marker=sign, label=f"{timed.preset}, this machine")
    ax.plot(
        [64], [FILTER_MS], marker="*", markersize=11, color="#8a5a00", linestyle="none",
        label="the thesis, m = 64, machine of 2005",
    )  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("points (of the model for thesis, measured points for others)")
    ax.set_ylabel("time per frame [ms]")
    ax.legend()
    return image_of(figure, "svg")


def _curves(
    outcomes: Sequence[Outcome], motion: ThesisMotion, measure: str
) -> tuple[IntArray, FloatArray]:
    """Frames (F,) and errors (seeds, F) in degrees."""
    parts = [part for o in outcomes if (part := o.segment(motion.segment)) is not None]
    first = [_first_stretch(part) for part in parts]
    if not first:
        return np.empty(0, dtype=np.int64), np.empty((0, 0))
    return first[0].frame, np.array([_degrees(part, measure) for part in first])


def _first_stretch(errors: LimbErrors) -> LimbErrors:
    """Frames up to the first gap: a motion may come more than once."""
    gaps = np.flatnonzero(np.diff(errors.frame) > 1)
    end = int(errors.frame[gaps[0]]) + 1 if len(gaps) else int(errors.frame[-1]) + 1
    return errors.between(int(errors.frame[0]), end)


def _degrees(errors: LimbErrors, measure: str) -> FloatArray:
    if measure in {"torso_long", "torso_cross"}:
        result: FloatArray = np.degrees(getattr(errors, measure))
        return result
    return np.degrees(errors.of_limb(measure))


def _draw(ax: Axes, label: str, frames: IntArray, degrees: FloatArray, colour: str) -> None:
    if not len(degrees):
        return
    thesis = label.startswith("preset thesis")
    anew = label.endswith("re-initialised")
    own = (_ANEW_COLOUR if anew else _THESIS_COLOUR) if thesis else colour
    mean = degrees.mean(axis=0)
    if len(degrees) > 1:
        low, high = degrees.min(axis=0), degrees.max(axis=0)
        ax.fill_between(frames, low, high, color=own, alpha=0.12, linewidth=0)
    words = label if thesis else f"{label} (in the limb's colour)"
    ax.plot(
        frames, mean, color=own, label=words, linewidth=1.2 if thesis else 2.0,
        linestyle="--" if anew else "-", zorder=2 if thesis else 3,
    )  # fmt: skip


def _mark(ax: Axes, outcomes: Sequence[Outcome], motion: ThesisMotion) -> None:
    """The 45 degrees of a lost limb, and where arms are crossed."""
    ax.axhline(_LOST, color="#57606a", linewidth=0.7, linestyle=":")
    crossed = _CROSSED.get(motion.segment)
    starts = [s for o in outcomes for s in o.segments if s.name == motion.segment]
    if crossed is None or not starts or starts[0].end - starts[0].first <= crossed[1]:
        return
    first = starts[0].first
    ax.axvspan(first + crossed[0], first + crossed[1], color="#f0e6c8", zorder=0, linewidth=0)
