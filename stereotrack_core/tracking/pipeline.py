"""From a recording to poses: read, make the cloud, follow; stages of successive frames overlap."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager, closing
from datetime import UTC, datetime
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import BodyModel, body_of_subject, landmarks
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import measured
from stereotrack_core.depth.cloud import FRAMES_APART, Cloud, contradicted_share
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections, own_detections
from stereotrack_core.recording.folder import fingerprint
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import tracked_views
from stereotrack_core.recording.sighted_keypoints import keypoints_in_views
from stereotrack_core.tracking.detecting import seen_keypoints
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Origin, Run, TrackedFrame, run_of, seen_by_frame
from stereotrack_core.tracking.initialise.first_pose import (
    facing,
    first_clouds,
    first_pose_from_images,
    first_pose_in,
    search_chain,
    shape_in,
)
from stereotrack_core.tracking.initialise.heading_watch import HeadingWatch
from stereotrack_core.tracking.initialise.keypoint_beginning import (
    FIRST_FRAMES,
    Beginning,
    beginning_of,
)
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.lengths_fit import (
    EstimatedLengths,
    lengths_of_standing,
    tracked_lengths,
)
from stereotrack_core.tracking.run_spec import RunSpec, given_heading, is_found
from stereotrack_core.tracking.second_look import LOOKING_AGAIN, SecondLook
from stereotrack_core.tracking.shared_clouds import CloudSource, chain_of, made_ahead, read_cloud
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.stored import began_of, subject_of_meta
from stereotrack_core.tracking.tracker import (
    PersonTracker,
    Tracker,
    cameras_of,
    initialiser_for,
    tracker_for,
)
from stereotrack_core.tracking.unfinished import Checkpoint, RunKeeper, UnfinishedRun, recall


class Pipeline(AbstractContextManager["Pipeline"]):
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
    corrects : bool
        Whether :meth:`frames` may give frames again, from an earlier one on: see there.
    heading : HeadingWatch or None
        What is known of the way that the person faces; None where it is given, or not looked for.
    second_look : SecondLook
        Looks again at frames with doubtful arms.

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
        self.recording, self.spec = recording, spec
        self.views = tracked_views(recording, spec.views, spec.keypoints)
        self._keypoints = keypoints_in_views(recording, self.views, spec.keypoints)
        self._shared = clouds
        self._detections = own_detections(recording) or Detections()
        self._owns_reader = clouds is None and reader is None
        if clouds is None:
            self.chain, self.reader = chain_of(recording, spec, self.views, reader)
        else:
            self.chain, self.reader = clouds.chain, clouds.reader
        self.settings = settings = dataclasses.replace(spec.settings, depth=self.chain.parameters)
        self._cameras = cameras_of(recording, self.views)
        looks = spec.detector and spec.keypoints is None
        seen = spec.seen if begun is None else seen_by_frame(begun.frames)
        given = recording, self.views, self.reader, settings, seen
        self.detector = seen_keypoints(*given) if looks else None
        self._track(body_of_subject(recording.subject, settings.body))
        self._init, self._given = spec.init, "pose"
        watched = is_found(spec.init) and given_heading(spec.init) is None and settings.follows_data
        self.heading = HeadingWatch(recording.fps) if watched and self.has_clouds else None
        self.corrects = False
        self._found: Pose | None = None
        self._began = None if begun is None else began_of(begun.meta)
        self._release_blas = one_blas_thread.hold()
        self._asked: range | None = None
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        self._made_at = now if begun is None else str(begun.meta.get("made", now))
        self.started = self._prepared = False
        self._made: dict[int, tuple[Cloud, float]] = {}
        several = len(self.chain.view_names) > 1 and not self.chain.learns
        self.second_look = SecondLook(settings.tracking.second_look if several else 0)
        self.on_preparing: Callable[[str, int, int], None] = lambda _stage, _done, _count: None
        self.before_step: Callable[[Cloud], None] = lambda _: None

    def frames(self, frames: range) -> Generator[TrackedFrame, None, None]:
        """Images -> cloud -> the tracker's step -> pose, frame by frame in their order.

        Goes on from the last pose when called again. While the tracker works on a cloud, the next
        ones are made. If :attr:`corrects`, frames may come again: all from the first with somebody,
        once, where they show that the person has faced the other way; those since a stretch in
        which arms were doubtful, where a second look finds a better way through it. Each takes the
        place of all after it (:func:`in_place`).
        """
        self.prepare(frames)
        rest = frames if self._begun is None else self._begun.rest_of(frames)
        while True:
            if self.begins_again:
                rest = range(self._begin_again(), frames.stop)
            elif self.second_look.due or (not rest and self.second_look.pending):
                yield from self._looked_again()
            if not rest:
                return
            with closing(made_ahead(self.cloud, rest)) as clouds:
                for cloud, read in clouds:
                    self.before_step(cloud)
                    yield self._keep(self._tracked(cloud, read))
                    rest = rest[1:]
                    if self.begins_again or self.second_look.due:
                        break

    def _looked_again(self) -> Generator[TrackedFrame, None, None]:
        """Frames since a stretch in which arms were doubtful, if they are better otherwise."""
        frames, told = self.second_look.frames, partial(self.on_preparing, LOOKING_AGAIN)
        for tracked in self.second_look.look(
            self.tracker, lambda frames: closing(made_ahead(self.cloud, frames)), told
        ):
            yield self._keep(tracked, frames[-1])

    @property
    def begins_again(self) -> bool:
        """Whether the frames so far show that they come again, with the body turned."""
        return self.corrects and self.heading is not None and self.heading.faced_away

    def cloud(self, frame: int) -> tuple[Cloud, float]:
        """Cloud of any frame, with keypoints and clicks, and the seconds that reading took."""
        if frame in self._made:
            return self._made.pop(frame)
        shared, own = self._shared, partial(read_cloud, self.chain, self.reader)
        cloud, read = (own if shared is None else shared.take)(frame)
        clicks = self.spec.clicks.until(frame) if self.spec.clicks else ()
        seen = self._keypoints.at(frame)
        if self.detector is not None:
            seen = self.detector.of(cloud, (self._asked or range(frame, frame + 1)).start)
        return dataclasses.replace(cloud, keypoints=seen, clicks=clicks), read

    def _tracked(self, cloud: Cloud, read: float) -> TrackedFrame:
        if len(self._detections):
            cloud = dataclasses.replace(cloud, detections=self._detections.until(cloud.frame))
        estimate = self._estimate(cloud)
        pose = estimate.pose if estimate.tracked else None
        if self.heading is not None and isinstance(self.tracker, PersonTracker):
            last = self._asked is not None and cloud.frame == self._asked[-1]
            self.heading.take(self.tracker.finder, pose, cloud, last=last)
        found = np.where(estimate.tracked, landmarks(self.body, estimate.pose), np.nan)
        seconds = {"read": read, **cloud.seconds, **estimate.seconds}
        place = cloud.frame - (self._asked or range(0)).start
        contradicted = np.nan if place % FRAMES_APART else contradicted_share(cloud)
        seen = None if self.detector is None else self.detector.seen(cloud.frame)
        tracked = TrackedFrame(cloud.frame, estimate, found, cloud, seconds, contradicted, seen)
        if self.corrects:
            self.second_look.take(tracked, self.tracker)
        return tracked

    def _estimate(self, cloud: Cloud) -> Estimate:
        enough = len(cloud.points) >= self.settings.tracking.least_points
        if not self.started and (enough if self.has_clouds else isinstance(self._init, Pose)):
            self.tracker.start(first := self.first_pose(cloud))
            self.started, self._began = True, (cloud.frame, first)
            if self.heading is not None:
                self.heading.first = cloud.frame, first
        return self.tracker.step(cloud)

    def _begin_again(self) -> int:
        """Be about to track from the first pose on, turned round; its frame."""
        assert self.heading is not None  # noqa: S101 - else nothing is corrected
        first, self._found = self.heading.correct()
        self.started, self._begun = False, None
        self._made.clear()
        self.second_look = SecondLook(self.second_look.tries)
        if self.chain.learns:
            self.learn(self._asked or range(0))
        self._track(body_of_subject(self.recording.subject, self.settings.body))
        if self.settings.tracking.fit_shape:
            self.fit_shape(self._asked or range(0))
        self._made = {frame: made for frame, made in self._made.items() if frame >= first}
        return first

    def _keep(self, tracked: TrackedFrame, seen: int | None = None) -> TrackedFrame:
        """Keep a frame; `seen`: the last one that the tracker has seen, where it is a later one."""
        if self._keeper is not None:
            heading = {} if self.heading is None else self.heading.memory()
            memory = {**self.tracker.memory(), **self.second_look.memory(), **heading}
            checkpoint = Checkpoint(tracked.frame if seen is None else seen, self.started, memory)
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
        if checkpoint is not None and self._begun is not None:
            self._go_on_after(checkpoint, self._begun, frames)

    def _get_ready(self, frames: range) -> None:
        """Find out all that has to be known of the person before the first frame."""
        self.estimate_lengths(frames)
        if is_found(self._init):
            clouds = self.first_clouds(frames)
            self._found = self._look_for_pose(clouds) if clouds else None
        if self.settings.tracking.fit_shape and self.settings.follows_data:
            self.fit_shape(frames)

    def _begin_with_keypoints(self, frames: range) -> None:
        """Track the first frames in advance, and begin where they do."""
        found = self._beginning(frames)
        if found is not None and found.pose is not None and not isinstance(self._init, Pose):
            self.tracker.start(found.pose)
            self.started, self._began = True, (frames.start, found.pose)

    def _beginning(self, frames: range) -> Beginning | None:
        """Track a body as the first frames show it; all clouds that are made for it are kept."""
        clouds = []
        for done, frame in enumerate(frames[:FIRST_FRAMES]):
            self.on_preparing("measuring the first frames", done, FIRST_FRAMES)
            clouds.append(self._kept(frame))
        found = beginning_of(self.tracker, clouds, self.before_step, self.on_preparing)
        self._track(self.body if found is None else self.body.with_shape(found.shape))
        return found

    def _go_on_after(self, checkpoint: Checkpoint, begun: UnfinishedRun, frames: range) -> None:
        """Restore the state after the frames that are done; a learning background sees them."""
        if checkpoint.started:
            self._track(body_of_subject(self.recording.subject, begun.shape))
        recall(self.tracker, checkpoint.memory)
        self.second_look.recall(checkpoint.memory, begun.done)
        if self.heading is not None:
            self.heading.recall(checkpoint.memory)
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
        look: SecondLook | None = None,
    ) -> None:
        """Continue from another run's pose (with P (n, n)); skips learning and initialisation.

        `look`: what the other run's second look held, up to the frame of the pose.
        """
        self._prepared, self._asked, self.started = True, frames, True
        self._init, self._given, self.heading = pose, "the pose of another run", None
        self._made.clear()
        self._track(self.body if shape is None else self.body.with_shape(shape))
        self.tracker.start(pose, P=P)
        if look is not None and P is not None and P.shape == self.tracker.P.shape:
            self.second_look = dataclasses.replace(look, tries=self.second_look.tries)

    def learn(self, frames: range) -> None:
        """Learn the background."""
        if self._shared is None:
            told = partial(self.on_preparing, "learning the background")
            self.chain.learn_background(self.reader, frames, told)
        else:
            self._shared.learn(frames)

    @property
    def estimates_lengths(self) -> bool:
        """Whether lengths come from the first frames: as wanted, or as the subject has none."""
        known = measured(self.recording.subject)
        return self.settings.body.proportions in ("sequence", "" if known else "individual")

    def estimate_lengths(self, frames: range) -> None:
        """Find out lengths from the first frames, where they come from there."""
        if self.settings.body.proportions == "sequence":
            self.go_on_with(tracked_lengths(self, frames))
        elif self.estimates_lengths:
            found = lengths_of_standing(self.first_clouds(frames), self.settings.depth.upright)
            if found is not None:
                self.go_on_with(EstimatedLengths(found, name=f"average, {found.height:.2f} m tall"))

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
        clouds, told = self.first_clouds(frames), (self.before_step, self.on_preparing)
        found = shape_in(self._initialiser(), clouds, self.first_pose, *told)
        if found is not None:
            self._track(self.body.with_shape(found))
        return self.body.shape

    def first_clouds(self, frames: range) -> list[Cloud]:
        """The first clouds that show somebody; all that are made on the way are kept."""
        told = partial(self.on_preparing, "measuring the first frames")
        return first_clouds(self._kept, frames, self.settings.tracking.least_points, told)

    def _kept(self, frame: int) -> Cloud:
        """Cloud of a frame, which is kept until the frame is tracked."""
        if frame not in self._made:
            self._made[frame] = self.cloud(frame)
        return self._made[frame][0]

    def _look_for_pose(self, clouds: Sequence[Cloud]) -> Pose | None:
        told = partial(self.on_preparing, "finding the initial pose")
        initialiser, frames = self._initialiser(), [cloud.frame for cloud in clouds]
        if self.settings.follows_data:
            found = first_pose_in(initialiser, clouds, told)
        else:
            seen = search_chain(self.reader, self.settings.depth, self.views), self.reader, frames
            found = first_pose_from_images(initialiser, *seen, self._asked or range(0), told)
        heading, upright = given_heading(self._init), self.settings.depth.upright
        return None if found is None else facing(found, heading, upright)

    def _initialiser(self) -> PersonTracker:
        made_for = self.body, self.settings, self._cameras, self.recording
        return initialiser_for(*made_for, self.spec.seed)

    def _track(self, body: BodyModel) -> None:
        """Make the tracker anew, for this body."""
        body = body if self.detector is None else self.detector.body(body)
        given = body, self.settings, self._cameras, self.recording.fps, self.spec.seed
        self.tracker: Tracker = tracker_for(*given, clouds=self.has_clouds)

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
        spec = dataclasses.replace(self.spec, views=self.views, frames=self._asked)
        spec = dataclasses.replace(spec, init=self._init, colour=self.reader.colour)
        return Origin(
            recording=self.recording,
            fingerprint=fingerprint(self.recording),
            spec=spec,
            detections=self._detections,
            state_names=self.tracker.state_names,
            shape=self.body.shape,
            given=self._given,
            began=self._began,
            made=self._made_at,
            resumed_at=() if self._begun is None else self._begun.resumed_at,
            heading=None if self.heading is None else self.heading.to_dict(),
            detector="" if self.detector is None else self.detector.name,
            detected_scenes=self.chain.silhouettes.made,
            looked_again=tuple(self.second_look.changed),
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

    def __exit__(self, *_: object) -> None:
        self.close()

    def first_pose(self, cloud: Cloud) -> Pose:
        """Where the track begins in the first cloud that shows somebody."""
        if isinstance(self._init, Pose):
            return self._init
        found = self._found or self._look_for_pose([cloud]) if is_found(self._init) else None
        return found or t_pose_in_cloud(self.body, cloud.points, self.settings.depth.upright)
