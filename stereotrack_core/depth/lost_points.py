"""Which step took a cloud's points on the way from the images, by the depth chain's counts."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from stereotrack_core.depth.cloud import Cloud, PointCounts
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.volume import settled
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader

LEAST_POINTS = 150  # points of a cloud without which no pose can be told
_FAR, _NEAR = 25.0, 0.2  # metres from the camera beyond which the unit is wrong
_Seen: TypeAlias = Sequence[tuple[View, PointCounts]]  # views, and their counts after each step
_STEPS = ("measured", "person", "taken", "inside", "kept")
_LOOK = "Inspect a cloud with `stereotrack cloud`."


@dataclass(frozen=True)
class Cause:
    """Why views gave too few points, or what they gave was not tracked."""

    views: tuple[str, ...]
    what: str  # a clause
    remedy: str

    def sentence(self) -> str:
        """Everything in one line."""
        many = "s" if len(self.views) > 1 else ""
        where = f"View{many} {', '.join(self.views)}: " if self.views else ""
        return f"{where}{self.what}. {self.remedy}"


@dataclass
class LostPoints:
    """Collects clouds with too few points, and tells what took them."""

    recording: Recording
    parameters: DepthParameters
    least_points: int = LEAST_POINTS
    _counts: dict[str, list[PointCounts]] = field(default_factory=dict)
    _problems: dict[str, Counter[str]] = field(default_factory=dict)
    _reason: str = ""

    def note(self, cloud: Cloud) -> None:
        """Take in a cloud, of which the counts are enough."""
        for view, counts in cloud.counts.items():
            self._counts.setdefault(view, []).append(counts)
        for view, problem in cloud.problems.items():
            self._problems.setdefault(view, Counter())[problem] += 1

    @property
    def counts(self) -> dict[str, PointCounts]:
        """What was left after each step, by view: medians over the clouds."""
        return {view: _median(told) for view, told in self._counts.items()}

    def causes(self, untracked_because: str) -> tuple[Cause, ...]:
        """What took the points; `untracked_because`, a clause, if nothing did."""
        self._reason = untracked_because
        found: dict[str, list[tuple[View, PointCounts]]] = {}
        for view, counts in self.counts.items():
            step = self._step_that_took(counts, len(self._counts))
            found.setdefault(step, []).append((self.recording.view(view), counts))
        absent = [
            Cause((view,), told.most_common(1)[0][0].rstrip("."), "See `stereotrack info --deep`.")
            for view, told in self._problems.items()
            if view not in self._counts
        ]
        return (*(self._cause(step, seen) for step, seen in found.items()), *absent)

    def _step_that_took(self, counts: PointCounts, views: int) -> str:
        """The first step that left too little for a pose; empty where enough was left."""
        least = self.least_points / views
        pixels = least * self.parameters.pixel_step**2
        for step in _STEPS:
            if getattr(counts, step) < (pixels if step in ("measured", "person") else least):
                return step
        return ""

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
        return (
            f"there are {total['kept']} points, but {self._reason}",
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
        p = self.parameters
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
        streams = [stream for view, _ in seen for stream in (view.left, view.image)]
        stated = all(stream is not None and stream.background for stream in streams)
        if stated and self.parameters.background_empty_scene:
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
            depth = settled(self.recording, self.parameters, reader, used)
        volume = Volume.of(depth)
        spans = (
            f"{low:.1f} to {high:.1f}" for low, high in zip(volume.low, volume.high, strict=True)
        )
        x, y, z = middle
        return (
            f"{what}: their median position is ({x:.2f}, {y:.2f}, {z:.2f}) m, the volume is "
            f"{' by '.join(spans)} m",
            "Set volume_centre_x, volume_centre_y and volume_bottom to where the person is. "
            f"Otherwise the calibration may be wrong: up is taken to be {depth.upright.axis} "
            "(up_axis), and lengths must be in metres.",
        )

    def _outliers(self, _: _Seen, total: Mapping[str, int]) -> tuple[str, str]:
        p = self.parameters
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


def _median(told: Sequence[PointCounts]) -> PointCounts:
    numbers = [[getattr(counts, step) for step in _STEPS] for counts in told]
    medians = PointCounts(*np.median(numbers, axis=0).astype(int).tolist())
    middles = [counts.middle for counts in told if counts.middle is not None]
    if not middles:
        return medians
    x, y, z = np.median(middles, axis=0).tolist()
    return replace(medians, middle=(x, y, z))
