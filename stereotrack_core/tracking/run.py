"""From a recording to poses: read, make the cloud, follow; stages of successive frames overlap."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from datetime import UTC, datetime
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import BodyModel, body_of_subject, landmarks
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import FRAMES_APART, Cloud, contradicted_share
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.folder import fingerprint
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import tracked_views
from stereotrack_core.recording.sighted_keypoints import keypoints_in_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Origin, Run, TrackedFrame, run_of
from stereotrack_core.tracking.initialise.first_pose import (
    first_pose_from_images,
    first_pose_in,
    shape_in,
)
from stereotrack_core.tracking.initialise.keypoint_beginning import (
    FIRST_FRAMES,
    Beginning,
    beginning_of,
)
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.lengths_fit import (
    ESTIMATING_LENGTHS,
    LENGTH_FRAMES,
    EstimatedLengths,
    WellSeenFrames,
    lengths_by_height,
)
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.repair import repaired, with_repaired
from stereotrack_core.tracking.run_checks import with_warnings
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import CloudSource, chain_of, made_ahead, read_cloud
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.stored import subject_of_meta
from stereotrack_core.tracking.tracker import (
    PersonTracker,
    Tracker,
    cameras_of,
    initialiser_for,
    tracker_for,
)
from stereotrack_core.tracking.unfinished import Checkpoint, RunKeeper, UnfinishedRun, recall

FIT_FRAMES = 12
"""Frames that the shape is fitted to: more bring nothing (docs/accuracy.md)."""

_LOOK_AHEAD = 5
"""Frames in which somebody is looked for to fit the shape, for each frame that it needs."""


class Pipeline:
    """Everything between a recording and its tracked frames.

    Parameters
    ----------
    spec : RunSpec
        What to track; its frames and its smoothing are up to whoever goes through the frames.
    reader : FrameReader, optional
        Shared reader; it is then not closed by :meth:`close`.
    clouds : CloudSource, optional
        Clouds that this run shares with others, made with the same views and depth parameters;
        their chain and reader are then not closed by :meth:`close`.
    keeper : RunKeeper, optional
        Is given every frame before anybody else.
    begun : UnfinishedRun, optional
        To go on with, where everything else is as it was: to the last bit as if it had never been
        stopped.

    Attributes
    ----------
    before_step : callable
        Called before each step; may raise :class:`Cancelled`.

    Raises
    ------
    InputError
        Where a view is unknown or no view gives depth.
    """

    def __init__(
        self,
        recording: Recording,
        spec: RunSpec,
        *,
        reader: FrameReader | None = None,
        clouds: CloudSource | None = None,
        keeper: RunKeeper | None = None,
        begun: UnfinishedRun | None = None,
    ) -> None:
        self._keeper, self._begun = keeper, begun
        if begun is not None:
            recording = dataclasses.replace(recording, subject=subject_of_meta(begun.meta))
        self.recording = recording
        self.spec = spec
        self.views = tracked_views(recording, spec.views, spec.keypoints)
        self._keypoints = keypoints_in_views(recording, self.views, spec.keypoints)
        self._shared = clouds
        self._detections = spec.detections or Detections()
        self._owns_reader = clouds is None and reader is None
        if clouds is None:
            self.chain, self.reader = chain_of(recording, spec, self.views, reader)
        else:
            self.chain, self.reader = clouds.chain, clouds.reader
        self.settings = settings = dataclasses.replace(spec.settings, depth=self.chain.parameters)
        self._cameras = cameras_of(recording, self.views)
        self._track(body_of_subject(recording.subject, settings.body))
        self._init, self._given = spec.init, "pose"
        self._found: Pose | None = None
        self._release_blas = one_blas_thread.hold()
        self._asked: range | None = None
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        self._made_at = now if begun is None else str(begun.meta.get("made", now))
        self.started = False
        self._prepared = False
        self._made: dict[int, tuple[Cloud, float]] = {}
        self.on_preparing: Callable[[str, int, int], None] = lambda _stage, _done, _count: None
        self.before_step: Callable[[Cloud], None] = lambda _: None

    def frames(self, frames: range) -> Generator[TrackedFrame, None, None]:
        """Images -> cloud -> the tracker's step -> pose, frame by frame in their order.

        Goes on from the last pose when called again. While the tracker works on a cloud, the next
        ones are made.
        """
        self.prepare(frames)
        if self._begun is not None:
            frames = self._begun.rest_of(frames)
        with closing(made_ahead(self.cloud, frames)) as clouds:
            for cloud, read in clouds:
                self.before_step(cloud)
                yield self._keep(self._tracked(cloud, read))

    def cloud(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of any frame, with keypoints and clicks, and the seconds that reading took."""
        if frame in self._made:
            return self._made.pop(frame)
        if self._shared is not None:
            cloud, read = self._shared.take(frame)
        else:
            cloud, read = read_cloud(self.chain, self.reader, frame)
        clicks = self.spec.clicks.until(frame) if self.spec.clicks else ()
        return dataclasses.replace(cloud, keypoints=self._keypoints.at(frame), clicks=clicks), read

    def _tracked(self, cloud: Cloud, read: float) -> TrackedFrame:
        if len(self._detections):
            cloud = dataclasses.replace(cloud, detections=self._detections.until(cloud.frame))
        estimate = self._estimate(cloud)
        found = np.where(estimate.tracked, landmarks(self.body, estimate.pose), np.nan)
        seconds = {"read": read, **cloud.seconds, **estimate.seconds}
        place = cloud.frame - (self._asked or range(0)).start
        contradicted = np.nan if place % FRAMES_APART else contradicted_share(cloud)
        return TrackedFrame(cloud.frame, estimate, found, cloud, seconds, contradicted)

    def _estimate(self, cloud: Cloud) -> Estimate:
        enough = len(cloud.points) >= self.settings.tracking.least_points
        if not self.started and (enough if self.has_clouds else isinstance(self._init, Pose)):
            self.tracker.start(self.first_pose(cloud))
            self.started = True
        return self.tracker.step(cloud)

    def _keep(self, tracked: TrackedFrame) -> TrackedFrame:
        if self._keeper is not None:
            checkpoint = Checkpoint(tracked.frame, self.started, self.tracker.memory())
            self._keeper.keep(tracked.without_cloud(), checkpoint, self.origin)
        return tracked

    def prepare(self, frames: range) -> None:
        """Learn the background and fit the body's shape; once, before the first frame."""
        if self._prepared:
            return
        self._prepared, self._asked = True, frames
        self.learn(frames)
        checkpoint = None if self._begun is None else self._begun.checkpoint
        if checkpoint is None or not checkpoint.started:
            (self._get_ready if self.has_clouds else self._begin_with_keypoints)(frames)
        if checkpoint is not None:
            self._go_on_after(checkpoint, frames)

    def _get_ready(self, frames: range) -> None:
        """Find out all that has to be known of the person before the first frame."""
        if self.settings.body.proportions == "sequence":
            self.take_lengths(frames)
        if self._init == "auto":
            clouds = self._first_clouds(frames)
            self._found = self._look_for_pose(clouds) if clouds else None
        if self.settings.tracking.fit_shape and self.settings.follows_data:
            self.fit_shape(frames)

    def _begin_with_keypoints(self, frames: range) -> None:
        """Track the first frames in advance, and begin where they do."""
        found = self._beginning(frames)
        if found is not None and found.pose is not None and not isinstance(self._init, Pose):
            self.tracker.start(found.pose)
            self.started = True

    def _beginning(self, frames: range) -> Beginning | None:
        """Track a body as the first frames show it; all clouds that are made for it are kept."""
        for done, frame in enumerate(frames[:FIRST_FRAMES]):
            self.on_preparing("measuring the first frames", done, FIRST_FRAMES)
            self._made[frame] = self.cloud(frame)
        clouds = [cloud for cloud, _ in self._made.values()]
        found = beginning_of(self.tracker, clouds, self.before_step, self.on_preparing)
        self._track(self.body if found is None else self.body.with_shape(found.shape))
        return found

    def _go_on_after(self, checkpoint: Checkpoint, frames: range) -> None:
        """Be as after the frames that are done; a background that learns on sees them again."""
        if self._begun is not None and checkpoint.started:
            self._track(body_of_subject(self.recording.subject, self._begun.shape))
        recall(self.tracker, checkpoint.memory)
        self.started = checkpoint.started
        done = frames[: frames.index(checkpoint.frame) + 1]
        for place, frame in enumerate(done):
            if self._made.pop(frame, None) is None and self.chain.learns:
                self.cloud(frame)
            self.on_preparing("going on after the frames that are done", place, len(done))

    def go_on_from(
        self,
        pose: Pose,
        frames: range,
        *,
        P: FloatArray | None = None,
        shape: BodyShape | None = None,
    ) -> None:
        """Be about to do `frames` from where another run was, instead of preparing for them."""
        self._prepared, self._asked, self.started = True, frames, True
        self._init, self._given = pose, "the pose of another run"
        self._made.clear()
        body = self.body
        self._track(body if shape is None else body.with_shape(shape))
        self.tracker.start(pose, P=P)

    def learn(self, frames: range) -> None:
        """Learn the background."""
        if self._shared is None:
            told = partial(self.on_preparing, "learning the background")
            self.chain.learn_background(self.reader, frames, told)
        else:
            self._shared.learn(frames)

    def take_lengths(self, frames: range) -> EstimatedLengths:
        """Track the first part once with lengths after the height, and estimate them from it."""
        expected = lengths_by_height(self._first_clouds(frames), self.settings.depth.upright)
        p = self.settings.tracking
        follows = p if self.settings.follows_data else TrackingParameters()
        settings = dataclasses.replace(self.settings, tracking=follows)
        settings, seed = settings.replaced(proportions="individual"), self.spec.seed
        with Pipeline(
            dataclasses.replace(self.recording, subject=EstimatedLengths(expected).subject()),
            RunSpec(settings, views=self.views, seed=seed, init=self._init),
            reader=self.reader,
        ) as first:
            first.before_step = self.before_step
            seen = WellSeenFrames()
            first.on_preparing = self.on_preparing
            wanted = frames[:LENGTH_FRAMES]
            for done, tracked in enumerate(first.frames(wanted)):
                seen.add(tracked)
                self.on_preparing(ESTIMATING_LENGTHS, done, len(wanted))
        known = seen.lengths(expected, first.tracker.setup)
        self.go_on_with(known)
        return known

    def go_on_with(self, lengths: EstimatedLengths) -> None:
        """Track a body of these lengths."""
        known = lengths.subject(self.recording.subject)
        self.recording = dataclasses.replace(self.recording, subject=known)
        self._track(body_of_subject(known, self.settings.body))

    def fit_shape(self, frames: range) -> BodyShape:
        """Follow the first frames in which somebody is there, and fit the shape to them."""
        if not self.has_clouds:
            self._beginning(frames)
            return self.body.shape
        clouds = self._first_clouds(frames)
        told = self.before_step, self.on_preparing
        found = shape_in(self._initialiser(), clouds, self.first_pose, *told)
        if found is not None:
            self._track(self.body.with_shape(found))
        return self.body.shape

    def _first_clouds(self, frames: range) -> list[Cloud]:
        """The first clouds that show somebody; all that are made on the way are kept."""
        p = self.settings.tracking
        found: list[Cloud] = []
        for frame in frames[: _LOOK_AHEAD * FIT_FRAMES]:
            self.on_preparing("measuring the first frames", len(found), FIT_FRAMES)
            if frame not in self._made:
                self._made[frame] = self.cloud(frame)
            cloud, _ = self._made[frame]
            if len(cloud.points) >= p.least_points:
                found.append(cloud)
            if len(found) == FIT_FRAMES:
                break
        return found

    def _look_for_pose(self, clouds: Sequence[Cloud]) -> Pose | None:
        told = partial(self.on_preparing, "finding the initial pose")
        if self.settings.follows_data:
            return first_pose_in(self._initialiser(), clouds, told)
        frames, known = [cloud.frame for cloud in clouds], self._asked or range(0)
        seen = self._initialiser(), self.reader, self.views, frames, known
        return first_pose_from_images(*seen, told)

    def _initialiser(self) -> PersonTracker:
        return initialiser_for(
            self.body, self.settings, self._cameras, self.recording, self.spec.seed
        )

    def _track(self, body: BodyModel) -> None:
        """Make the tracker anew, for this body."""
        fps, seed = self.recording.fps, self.spec.seed
        given, clouds = (body, self.settings, self._cameras, fps, seed), self.has_clouds
        self.tracker: Tracker = tracker_for(*given, clouds=clouds)

    @property
    def has_clouds(self) -> bool:
        """Whether any view gives depth; else keypoints alone are followed."""
        return bool(self.chain.view_names)

    @property
    def body(self) -> BodyModel:
        """What is tracked."""
        return self.tracker.setup.body

    def origin(self) -> Origin:
        """Describe where the frames come from."""
        found = self.chain.parameters.values()
        spec = dataclasses.replace(
            self.spec,
            views=self.views,
            frames=self._asked,
            init=self._init,
            detections=self._detections,
            colour=self.reader.colour,
        )
        return Origin(
            recording=self.recording,
            fingerprint=fingerprint(self.recording),
            spec=spec,
            state_names=self.tracker.state_names,
            shape=self.body.shape,
            given=self._given,
            made=self._made_at,
            resumed_at=() if self._begun is None else self._begun.resumed_at,
            from_recording=dict(found.items() - self.spec.settings.depth.values().items()),
        )

    def smoothed_run(self, frames: Sequence[TrackedFrame]) -> Run:
        """Go over successive frames backwards and put them together to a run."""
        back = smoothed(frames, self.tracker.setup, fit_movement=not self.has_clouds)
        origin = dataclasses.replace(self.origin(), smoothed=True, bridged=back.bridged)
        return run_of(back.frames, origin)

    def close(self) -> None:
        """Close the reader, unless it is shared."""
        if self._shared is None:
            self.chain.close()
        self._release_blas()
        if self._owns_reader:
            self.reader.close()

    def __enter__(self) -> Pipeline:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def first_pose(self, cloud: Cloud) -> Pose:
        """Where the track begins in the first cloud that shows somebody."""
        if isinstance(self._init, Pose):
            return self._init
        found = self._found or self._look_for_pose([cloud]) if self._init == "auto" else None
        return found or t_pose_in_cloud(self.body, cloud.points, self.settings.depth.upright)


def track(
    recording: Recording,
    spec: RunSpec,
    *,
    on_frame: Callable[[TrackedFrame], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    on_preparing: Callable[[str, int, int], None] | None = None,
    keeper: RunKeeper | None = None,
    begun: UnfinishedRun | None = None,
) -> Run:
    """Track a recording; a run that is cancelled keeps the frames it has.

    Parameters
    ----------
    on_frame : callable, optional
        Called after every frame.
    cancelled : callable, optional
        Asked after every frame whether to stop.
    on_preparing : callable, optional
        Told, in any thread, which stage before the first frame is under way and how many of its
        parts of how many are done; may raise :class:`Cancelled`.
    keeper, begun
        See :class:`Pipeline`.

    Raises
    ------
    Cancelled
        Where `on_preparing` raises it.

    Examples
    --------
    >>> spec = RunSpec(preset("accurate"), frames=range(40))
    >>> run = track(open_recording(Path("recording")), spec)
    >>> run.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (40, 9, 3)
    """
    found: list[TrackedFrame] = [] if begun is None else list(begun.done)
    with Pipeline(recording, spec, keeper=keeper, begun=begun) as pipeline:
        pipeline.on_preparing = on_preparing or pipeline.on_preparing
        wanted = spec.frames_of(pipeline.reader.frame_count)
        pipeline.prepare(wanted)
        complete = begun is not None and cancelled is not None and cancelled()
        for tracked in () if complete else pipeline.frames(wanted):
            found.append(tracked.without_cloud())
            if on_frame is not None:
                on_frame(tracked)
            if cancelled is not None and cancelled():
                break
        found, mended = repaired(pipeline, found, cancelled)
        run = pipeline.smoothed_run(found) if spec.smooth else run_of(found, pipeline.origin())
        return with_warnings(with_repaired(run, mended), found, spec.settings)
