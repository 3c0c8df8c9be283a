"""The whole chain: a frame set becomes a cloud (3.1)."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TypeAlias

import numpy as np

from stereotrack_core.compiled import load_before_threads
from stereotrack_core.depth.background import BackgroundModel, LearnedFrame, ViewBackground
from stereotrack_core.depth.cloud import Cloud, DepthGeometry, ViewDepth, colours_of
from stereotrack_core.depth.mono_silhouettes import MonoSilhouettes
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import inliers
from stereotrack_core.depth.rectify import Rectification, depth_rectification, stereo_rectification
from stereotrack_core.depth.sources import DepthSource, StereoSource
from stereotrack_core.depth.view_chain import Stopwatch, ViewChain, ViewResult
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader, FrameSet, ViewImages
from stereotrack_core.recording.selection import usable_views

# Where a view's disparities come from; see :func:`source_of`.
SourceMaker: TypeAlias = Callable[[Recording, View, DepthParameters], StereoSource | DepthSource]
OnPart: TypeAlias = Callable[[int, int], None]  # told how many parts of how many are done

_ROW_FRAMES = 2  # frames, spread over the recording, on which the rows of pairs are compared
_BACKGROUND_FRAMES = 40  # spread over the recording, to learn the background from


@dataclass(frozen=True, eq=False)
class MeasuredViews:
    """Measurements of all views at one instant, before fusion; views without images are absent."""

    frame: int
    results: Mapping[str, ViewResult]
    problems: Mapping[str, str]
    seconds: Mapping[str, float]
    outlines: Mapping[str, ViewDepth] = field(default_factory=dict)  # of mono views


class DepthChain:
    """Rectify, match, subtract the background, fuse the views and drop outliers.

    Views are processed in parallel. The cloud depends on the images alone, except in background
    mode ``average`` without images of the empty scene: there the model goes on learning, and frames
    have to come in order. Not to be used by two threads at once. Raises InputError for unknown
    views, views without depth, and stereo cameras that cannot be rectified.

    Parameters
    ----------
    views : sequence of str, optional
        Names of the views to use; all stereo and depth views where it is not given, and none,
        whose clouds are empty, where it is an empty tuple.
    mono : sequence of str
        Names of mono views whose silhouettes are wanted, where they have a picture of the empty
        scene.
    colour : bool
        Whether points get colours, where the pictures have any (:mod:`colours`).
    sources : callable, optional
        Makes the views' sources, for those who keep what they give.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> chain = DepthChain(recording, preset("accurate").depth)
    >>> with FrameReader(recording) as reader:
    ...     chain.learn_background(reader, range(reader.frame_count))
    ...     cloud = chain.process(reader.frame_set(0))
    >>> cloud.points.shape
    (5210, 3)
    """

    def __init__(
        self,
        recording: Recording,
        parameters: DepthParameters,
        *,
        views: Sequence[str] | None = None,
        mono: Sequence[str] = (),
        colour: bool = False,
        sources: SourceMaker | None = None,
    ) -> None:
        self.parameters = parameters
        self._recording = recording
        make = sources or source_of
        self._chains = tuple(
            ViewChain(view.name, make(recording, view, parameters), parameters, colour=colour)
            for view in map(recording.view, () if views == () else usable_views(recording, views))
        )
        self.silhouettes = MonoSilhouettes(recording, parameters, mono)
        workers = max(1, min(len(self._chains), os.cpu_count() or 1))
        load_before_threads()
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="depth")

    @property
    def view_names(self) -> tuple[str, ...]:
        """Names of the views in use, in the recording's order."""
        return tuple(chain.name for chain in self._chains)

    @property
    def geometry(self) -> Mapping[str, DepthGeometry]:
        """Geometry of each view's depth image."""
        return {chain.name: chain.source.geometry for chain in self._chains}

    @property
    def background(self) -> Mapping[str, BackgroundModel]:
        """Background models of the views that have one."""
        return {c.name: c.background.model for c in self._chains if c.background.model is not None}

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()

    def learn_background(
        self, reader: FrameReader, frames: range, on_image: OnPart = lambda _done, _count: None
    ) -> None:
        """Learn what every view shows when nobody is there.

        From images of the empty scene, else from frames spread evenly over `frames`; masked depth
        views need none. `on_image` is called in several threads and may raise :class:`Cancelled`.
        """
        self.silhouettes.learn(reader, frames)
        waiting = []
        for chain in self._chains:
            view = self._recording.view(chain.name)
            if view.kind == "stereo" and self.parameters.background_empty_scene:
                left_and_image = reader.background(chain.name)
                if left_and_image is not None:
                    left, image = left_and_image
                    if chain.learn_empty_scene(ViewImages(image=image, left=left)):
                        continue
            if view.mask is None and self.parameters.background_mode != "none":
                waiting.append(chain)
        if self.parameters.align_rows:
            self._align_rows(reader, frames)
        if waiting:
            self._learn_from_frames(waiting, reader, frames, on_image)

    def take_background(self, other: DepthChain, reader: FrameReader, frames: range) -> None:
        """Take over the background of a chain of the same views, parameters and frames."""
        if self.silhouettes and other.silhouettes:
            self.silhouettes = other.silhouettes
        else:
            self.silhouettes.learn(reader, frames)
        for own, learned in zip(self._chains, other._chains, strict=True):
            own.take_over(learned)

    @property
    def learns(self) -> bool:
        """Whether clouds depend on those before them, as the background is still being learned."""
        return any(chain.background.learns for chain in self._chains)

    def _align_rows(self, reader: FrameReader, frames: range) -> None:
        """Lay left images into the rows of the right ones, as some frames show them."""
        chains = [chain for chain in self._chains if isinstance(chain.source, StereoSource)]
        sampled = frames[:: max(1, (len(frames) - 1) // (_ROW_FRAMES - 1))] if chains else ()
        seen = [reader.frame_set(k).views for k in sampled[:_ROW_FRAMES]]
        images = [[views[c.name] for views in seen if c.name in views] for c in chains]
        for _ in self._pool.map(ViewChain.align_rows, chains, images):
            pass  # the loop raises what a thread raised

    def _learn_from_frames(
        self, chains: Sequence[ViewChain], reader: FrameReader, frames: range, on_image: OnPart
    ) -> None:
        most = min(_BACKGROUND_FRAMES, len(frames))
        sampled = [frames[i] for i in np.unique(np.linspace(0, len(frames) - 1, most).astype(int))]
        done, total = count(), len(sampled) * len(chains)
        seen: dict[str, list[LearnedFrame]] = {chain.name: [] for chain in chains}

        def learn(chain: ViewChain, images: ViewImages) -> LearnedFrame | None:
            on_image(next(done), total)
            return chain.learn_frame(images)

        for k in sampled:
            views = reader.frame_set(k).views
            present = [chain for chain in chains if chain.name in views]
            found = self._pool.map(learn, present, [views[chain.name] for chain in present])
            for chain, frame in zip(present, found, strict=True):
                seen[chain.name] += [] if frame is None else [frame]
        backgrounds = [chain.background for chain in chains]
        for _ in self._pool.map(ViewBackground.take_frames, backgrounds, seen.values()):
            pass  # the loop raises what a thread raised
        if len(chains) == len(self._chains) and all(one.motionless for one in backgrounds):
            for one in backgrounds:
                one.forget_still()

    def process(self, frame_set: FrameSet) -> Cloud:
        """The cloud of one frame set; views that give nothing are named in `problems`."""
        return self.fused(self.measured(frame_set))

    def measured(self, frame_set: FrameSet) -> MeasuredViews:
        """What every view measures, not yet fused."""
        watch = Stopwatch()
        problems = {n: t for n, t in frame_set.problems.items() if n in self.view_names}
        present = [chain for chain in self._chains if chain.name in frame_set.views]
        for chain in self._chains:
            if chain not in present and chain.name not in problems:
                problems[chain.name] = f"View {chain.name} provides no depth: it has no images."
        images = [frame_set.views[chain.name] for chain in present]
        measured = self._pool.map(ViewChain.process, present, images)
        results = {chain.name: r for chain, r in zip(present, measured, strict=True)}
        outlines, without = self.silhouettes.of(frame_set)
        problems |= without
        problems |= {name: result.problem for name, result in results.items() if result.problem}
        watch.lap("views")
        seconds: dict[str, float] = {}
        for result in results.values():
            for stage, value in result.seconds.items():
                seconds[stage] = seconds.get(stage, 0.0) + value
        return MeasuredViews(
            frame_set.index, results, problems, {**seconds, **watch.seconds}, outlines
        )

    def fused(self, seen: MeasuredViews) -> Cloud:
        """Put the views' points together, and drop outliers (3.1)."""
        watch, p, results = Stopwatch(), self.parameters, seen.results
        names = self.view_names
        empty = np.zeros((0, 3)), np.zeros(0, dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
        parts = [
            (result.points, np.full(len(result.points), names.index(name)), result.pixels)
            for name, result in results.items()
        ]
        points, view, pixels = (np.concatenate(part) for part in zip(empty, *parts, strict=True))
        kept = inliers(
            points, p.outlier_neighbours, p.outlier_distance / 1000.0, repeat=p.outlier_repeat
        )
        watch.lap("outliers")
        depths = {n: r.depth for n, r in results.items() if r.depth is not None}
        left = np.bincount(view[kept], minlength=len(names)).tolist()
        return Cloud(
            frame=seen.frame,
            points=points[kept],
            view=view[kept],
            pixels=pixels[kept],
            view_names=names,
            depths={**depths, **seen.outlines},
            problems=seen.problems,
            seconds={**seen.seconds, **watch.seconds},
            colours=colours_of(names, depths, view[kept], pixels[kept]),
            counts={n: replace(r.counts, kept=left[names.index(n)]) for n, r in results.items()},
        )


def source_of(
    recording: Recording, view: View, parameters: DepthParameters
) -> StereoSource | DepthSource:
    """Where a view's disparities come from: its stereo pair, or its depth images."""
    rectification = rectification_of(recording, view, parameters)
    if view.left is None:
        return DepthSource(rectification)
    return StereoSource(rectification, parameters)


def rectification_of(
    recording: Recording, view: View, parameters: DepthParameters
) -> Rectification:
    """How a view's images become those that depth is measured in."""
    camera = recording.reference_camera(view)
    if view.left is None:
        return depth_rectification(camera)
    left, least_focal = recording.cameras[view.left.camera], parameters.least_focal
    return stereo_rectification(left, camera, least_focal=least_focal, where=f"view {view.name}")
