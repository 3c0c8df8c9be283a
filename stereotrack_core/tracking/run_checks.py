"""What a whole run says: whether body, cameras and clouds fit, and why frames were not tracked.

The counts are those of the depth chain; nothing is measured again.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from stereotrack_core.depth.cloud import PointCounts
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.volume import settled
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import Run, TrackedFrame
from stereotrack_core.tracking.parameters import Settings

WARNINGS = "warnings"
"""Key of a run's meta."""

MOST_UNEXPLAINED = 0.3
"""Unexplained fraction of the cloud, median over the tracked frames, above which nothing fits:
sound recordings have 0.05 to 0.28, those with wrong calibrations 0.15 to 0.6 (docs/runs.md)."""

MOST_CONTRADICTED = 0.03
"""Share of the points that other views see through, median over the frames that were asked, above
which views do not fit each other: sound recordings have up to 0.015, those with wrong calibrations
mostly 0.04 to 0.7 (docs/runs.md)."""

CHECK = (
    "Check the calibration with `stereotrack info --deep`: views or cameras may be swapped, a "
    "rotation inverted, or a baseline or unit wrong."
)


def misfits(frames: Iterable[TrackedFrame], settings: Settings) -> tuple[str, ...]:
    """What looks wrong about a run, as clauses; :data:`CHECK` is what to do.

    Parameters
    ----------
    frames : iterable of TrackedFrame
        With or without their clouds.
    settings : Settings
        What is unexplained says nothing about trackers whose body has no legs, and about those
        whose model looks for the data.
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
    return tuple(found)


def with_warnings(run: Run, frames: Iterable[TrackedFrame], settings: Settings) -> Run:
    """The run, whose meta says what looks wrong about the frames that it was made of."""
    return replace(run, meta={**run.meta, WARNINGS: list(misfits(frames, settings))})


_FAR, _NEAR = 25.0, 0.2
"""Metres from the camera beyond which points are nobody's, but millimetres or another unit."""

_Seen: TypeAlias = Sequence[tuple[View, PointCounts]]
"""Views, and what was left of their measurements after each step."""

_STEPS = ("measured", "person", "taken", "inside", "kept")

_LOOK = "Inspect a cloud with `stereotrack cloud`."


@dataclass(frozen=True)
class Cause:
    """Why views gave too few points, or what they gave was not tracked."""

    views: tuple[str, ...]
    what: str
    """A clause."""
    remedy: str

    def sentence(self) -> str:
        """Everything in one line."""
        many = "s" if len(self.views) > 1 else ""
        where = f"View{many} {', '.join(self.views)}: " if self.views else ""
        return f"{where}{self.what}. {self.remedy}"


@dataclass
class Untracked:
    """Collects the frames that were not tracked, and tells their causes."""

    recording: Recording
    settings: Settings
    _reasons: Counter[str] = field(default_factory=Counter)
    _counts: dict[str, list[PointCounts]] = field(default_factory=dict)
    _problems: dict[str, Counter[str]] = field(default_factory=dict)

    def note(self, frame: TrackedFrame) -> None:
        """Take in a frame, with or without its cloud."""
        if frame.tracked:
            return
        cloud = frame.cloud
        self._reasons[frame.reason] += 1
        for view, counts in cloud.counts.items():
            self._counts.setdefault(view, []).append(counts)
        for view, problem in cloud.problems.items():
            self._problems.setdefault(view, Counter())[problem] += 1

    def take(self, frames: Iterable[TrackedFrame]) -> Untracked:
        """Take in all of them."""
        for frame in frames:
            self.note(frame)
        return self

    @property
    def counts(self) -> dict[str, PointCounts]:
        """What was left after each step, by view: medians over the untracked frames."""
        return {view: _median(told) for view, told in self._counts.items()}

    def causes(self) -> tuple[Cause, ...]:
        """What took the points, the views with the same cause together; none: all were tracked."""
        if not self._reasons:
            return ()
        found: dict[str, list[tuple[View, PointCounts]]] = {}
        for view, counts in self.counts.items():
            step = self._step_that_took(counts, len(self._counts))
            found.setdefault(step, []).append((self.recording.view(view), counts))
        absent = [self._absent(view) for view in self._problems if view not in self._counts]
        return (*(self._cause(step, seen) for step, seen in found.items()), *absent)

    def _step_that_took(self, counts: PointCounts, views: int) -> str:
        """The first step that left too little for a pose; empty where enough was left."""
        least = self.settings.tracking.least_points / views
        pixels = least * self.settings.depth.pixel_step**2
        for step in _STEPS:
            if getattr(counts, step) < (pixels if step in ("measured", "person") else least):
                return step
        return ""

    def _absent(self, view: str) -> Cause:
        problem, _ = self._problems[view].most_common(1)[0]
        return Cause((view,), problem.rstrip("."), "See `stereotrack info --deep`.")

    def _cause(self, step: str, seen: _Seen) -> Cause:
        total = {name: sum(getattr(counts, name) for _, counts in seen) for name in _STEPS}
        explained = {
            "measured": self._hardly_measured,
            "person": self._not_foreground,
            "taken": self._not_foreground,
            "inside": self._outside,
            "kept": self._outliers,
        }.get(step, self._enough)
        return Cause(tuple(view.name for view, _ in seen), *explained(seen, total))

    def _enough(self, _: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        reason, _count = self._reasons.most_common(1)[0]
        return (
            f"there are {total['kept']} points, but {reason}",
            f"{_LOOK} Check the calibration with `stereotrack info --deep`, that lengths are in "
            "metres, and that the whole upper body is visible.",
        )

    def _hardly_measured(self, seen: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        names = [view.name for view, _ in seen]
        problems = [self._problems[n].most_common(1)[0][0] for n in names if n in self._problems]
        said = f": {problems[0].split(': ')[-1].rstrip('.')}" if problems else ""
        if any("working volume" in problem for problem in problems):
            return "the cameras do not see the working volume", _UNIT_OR_VOLUME
        if all(view.kind == "depth" for view, _ in seen):
            return (
                f"the depth images have {total['measured']} values where the volume is{said}",
                "Check that the depth images are not empty, and that the person is within the "
                "camera's range and in the volume: volume_centre_x, volume_centre_y, "
                "volume_bottom.",
            )
        p = self.settings.depth
        return (
            f"{total['measured']} pixels could be matched where the working volume is{said}",
            "Check whether left and right are swapped or dark, and whether the person's "
            f"disparities are in the search range: disparity_minimum={p.disparity_minimum}, "
            f"disparity_count={p.disparity_count}.",
        )

    def _not_foreground(self, seen: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        measured, person = total["measured"], total["person"]
        if all(view.mask is not None for view, _ in seen):
            return (
                f"the mask leaves {person} of {measured} depth values",
                "Check that it is the mask of these images: the person must be brighter than 127.",
            )
        told = f"{person} of {measured} measured pixels are in front of the background"
        if all(_has_empty_scene(view, self.settings.depth) for view, _ in seen):
            return (
                f"{told}, which comes from background images",
                "If a person is there: check whether someone is in the background images, and "
                "whether the cameras have been moved since. Or set background_empty_scene=false "
                "to learn the background from the recording.",
            )
        return (
            f"{told}, which was learned from the recording itself; a person who stands still "
            "becomes part of it",
            "If a person is there: provide background images (`background` in recording.toml) or "
            "a mask, or set background_mode=none.",
        )

    def _outside(self, seen: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        what = f"{total['inside']} of {total['taken']} points are inside the working volume"
        middles = [(view, counts.middle) for view, counts in seen if counts.middle is not None]
        if not middles:
            return what, _UNIT_OR_VOLUME
        view, middle = middles[0]
        camera = self.recording.reference_camera(view).position_world
        away = float(np.linalg.norm(np.array(middle) - camera))
        if not _NEAR < away < _FAR:
            return f"{what}: they are {away:.3g} m from the camera", _UNIT
        used = tuple(self._counts)
        with FrameReader(self.recording, views=used, colour=False) as reader:
            depth = settled(self.recording, self.settings.depth, reader, used)
        volume = Volume.of(depth)
        spans = (
            f"{low:.1f} to {high:.1f}" for low, high in zip(volume.low, volume.high, strict=True)
        )
        x, y, z = middle
        return (
            f"{what}: their median position is ({x:.2f}, {y:.2f}, {z:.2f}) m, the volume is "
            f"{' by '.join(spans)} m",
            "Set volume_centre_x, volume_centre_y and volume_bottom to where the person is. "
            "Otherwise the calibration may be wrong: z must point up, and lengths must be in "
            "metres.",
        )

    def _outliers(self, _: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        p = self.settings.depth
        return (
            f"{total['kept']} of {total['inside']} points have {p.outlier_neighbours} neighbours "
            f"within {p.outlier_distance:g} mm",
            "Small images and distant people give sparse points: set pixel_step=1, a larger "
            "outlier_distance or fewer outlier_neighbours. Otherwise check that lengths are in "
            "metres.",
        )


_UNIT = (
    "Check that lengths are in metres: `units` in the calibration, and `unit` of depth views, "
    "metres per count."
)
_UNIT_OR_VOLUME = (
    f"{_UNIT} Or set volume_centre_x, volume_centre_y and volume_bottom to where the person is."
)


def _has_empty_scene(view: View, p: DepthParameters) -> bool:
    given = view.left is not None and None not in (view.left.background, view.image.background)
    return given and p.background_empty_scene


def _median(told: Sequence[PointCounts]) -> PointCounts:
    numbers = [[getattr(counts, step) for step in _STEPS] for counts in told]
    medians = PointCounts(*np.median(numbers, axis=0).astype(int).tolist())
    middles = [counts.middle for counts in told if counts.middle is not None]
    if not middles:
        return medians
    x, y, z = np.median(middles, axis=0).tolist()
    return replace(medians, middle=(x, y, z))


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


def gaps_of(reasons: Sequence[tuple[int, str]]) -> tuple[Gap, ...]:
    """Join successive frames whose reasons differ in their numbers at most.

    The numbers of a stretch are told from the smallest to the largest.
    """
    gaps: list[tuple[Gap, list[str]]] = []
    for frame, reason in reasons:
        if gaps and gaps[-1][0].end == frame and _kind(gaps[-1][0].reason) == _kind(reason):
            gap, told = gaps[-1]
            gaps[-1] = (replace(gap, end=frame + 1), [*told, reason])
        else:
            gaps.append((Gap(frame, frame + 1, reason), [reason]))
    return tuple(replace(gap, reason=_joined(told)) for gap, told in gaps)


def _kind(reason: str) -> str:
    return _NUMBER.sub("#", reason)


def _joined(reasons: Sequence[str]) -> str:
    """One sentence for sentences that differ in their numbers only."""
    numbers = zip(*(_NUMBER.findall(reason) for reason in reasons), strict=True)
    spans = []
    for told in numbers:
        low, high = min(told, key=float), max(told, key=float)
        spans.append(low if low == high else f"{low} to {high}")
    spoken = iter(spans)
    return _NUMBER.sub(lambda _: next(spoken), reasons[0])


@dataclass
class ViewProblems:
    """Collects frame by frame what the views lack."""

    _told: dict[str, list[tuple[int, str]]] = field(default_factory=dict)

    def note(self, frame: int, problems: Mapping[str, str]) -> None:
        """Keep the sentences of one frame, by view."""
        for view, sentence in problems.items():
            reason = sentence.removeprefix(f"View {view} provides no depth: ")
            reason = reason.removeprefix(f"View {view}, frame {frame}: ").rstrip(".")
            self._told.setdefault(view, []).append((frame, reason))

    def stretches(self) -> tuple[Blindness, ...]:
        """All stretches, in the order of the views that lacked something first."""
        return tuple(
            Blindness(view, gap.first, gap.end, gap.reason)
            for view, told in self._told.items()
            for gap in gaps_of(told)
        )
