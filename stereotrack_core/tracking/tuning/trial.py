"""A stretch tracked with other settings, from a pose that is known or from a first pose."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.lengths_fit import EstimatedLengths
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.second_look import SecondLook, last_settled
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore, Holdings
from stereotrack_core.tracking.tuning.stages import Stage, stage_key


@dataclass(frozen=True, eq=False)
class Start:
    """What is known before a stretch from a run that has been there; see :func:`start_before`."""

    pose: Pose
    """From which tracking goes on."""
    P: FloatArray | None = None
    """Shape (n, n). Its covariance; used where the tracker has the same state."""
    shape: BodyShape | None = None
    """The body's fitted shape, where it stands; None has it fitted again where the settings want
    that, from the first pose of the specification."""
    lengths: Proportions | None = None
    """Of the body, where they were estimated from the sequence and stand; None has them
    estimated again where the settings want that."""
    frame: int | None = None
    """Frame of the pose; the one before the stretch if not given. Frames from there to the stretch
    are tracked with it and not shown."""
    end: int | None = None
    """Half-open end of the run, where a second look ends; the recording's if not given."""
    look: SecondLook | None = None
    """What the run's second look held up to `frame`."""
    unlike: tuple[str, ...] = ()
    """What besides parameters makes the trial differ from the run; sentences."""


_LONGEST_LEAD = 150
"""Frames that are tracked at most before a stretch: it takes as long as the stretch itself then."""

_LEAD = "Before the stretch the run was lost, or looked at again, for longer than a trial repeats."
_UNSTATED = "The run does not state the pose that it began with."


def start_before(
    frames: Mapping[int, TrackedFrame], first: int, began: tuple[int, Pose] | None = None
) -> Start | None:
    """Where a trial of the frames from `first` on starts, so that it goes the way of the run.

    It starts at the last frame whose pose alone decides how the run went on, which may be some
    frames before `first`.

    Parameters
    ----------
    frames : mapping of int to TrackedFrame
        Of the run.
    began : (int, Pose), optional
        First frame that showed somebody, and the pose from which the run began there.

    Returns
    -------
    Start or None
        None if the run was nowhere near.
    """
    end, place = max(frames, default=-1) + 1, last_settled(frames, first - 1)
    if place is not None and first - 1 - place <= _LONGEST_LEAD:
        at = frames[place]
        look = SecondLook.after(frames[k] for k in sorted(frames) if k <= place)
        return Start(at.estimate.pose, at.P, frame=place, end=end, look=look)
    if place is None and began is not None and 0 <= first - began[0] <= _LONGEST_LEAD:
        return Start(began[1], frame=began[0] - 1, end=end)
    unlike = (_UNSTATED if place is None and began is None else _LEAD,)
    before, here = frames.get(first - 1), frames.get(first)
    if before is not None and before.tracked:
        return Start(before.estimate.pose, before.P, end=end, unlike=unlike)
    if here is not None and here.tracked:
        return Start(here.estimate.pose, end=end, unlike=unlike)
    return None


@dataclass(frozen=True, eq=False)
class Trial:
    """What shall be tracked."""

    spec: RunSpec
    """With the stretch as its frames."""
    start: Start | None = None
    """None: as a run over the stretch alone begins."""
    learned_from: range | None = None
    """Frames from which the background is learned and the shape is fitted: those of the run that
    the trial is compared with. The stretch where not given."""

    @property
    def settings(self) -> Settings:
        """Of the tracker."""
        return self.spec.settings

    @property
    def stretch(self) -> range:
        """Successive frames."""
        return self.spec.frames_of(0)

    @property
    def known(self) -> range:
        """Frames from which the background is learned and the shape is fitted."""
        return self.stretch if self.learned_from is None else self.learned_from

    @property
    def reach(self) -> range:
        """The stretch and the frames that are tracked before it."""
        first = self.stretch.start
        if self.start is not None and self.start.frame is not None:
            first = self.start.frame + 1
        return range(first, self.stretch.stop)

    @property
    def key(self) -> CloudKey:
        """What its clouds depend on."""
        return CloudKey(self.settings.depth, self.known, self.settings.uses_detector)

    def work(self, kept: Holdings) -> str:
        """What it has to do beyond what is kept; see :meth:`Holdings.work`."""
        return kept.work(self.key, self.reach, shape=self._fits_shape)

    @contextmanager
    def begun(
        self, store: CloudStore, cancelled: Callable[[], bool] | None = None
    ) -> Iterator[Pipeline]:
        """A pipeline that is prepared for :meth:`frames`.

        Parameters
        ----------
        store : CloudStore
            Keeps the clouds and shapes; shared by successive trials.
        cancelled : callable, optional
            Asked before every step; where it says so, :class:`Cancelled` is raised.

        Raises
        ------
        Cancelled, InputError
            See :meth:`CloudStore.clouds`.
        """

        def ask(*_: object) -> None:
            if cancelled is not None and cancelled():
                raise Cancelled

        clouds = store.clouds(self.key, self.reach, cancelled)
        with Pipeline(store.recording, self.spec, clouds=clouds) as pipeline:
            pipeline.before_step = pipeline.on_preparing = ask
            pipeline.corrects = True
            if self.start is None:
                pipeline.prepare(self.stretch)
            else:
                self._go_on(pipeline, self.start, store.shapes)
            yield pipeline

    def frames(self, pipeline: Pipeline) -> Iterator[TrackedFrame]:
        """Frames of the stretch; those that a second look replaces come again.

        With the run's own settings the last of each is the run's, bit by bit, unless
        :attr:`Start.unlike` says why not. Tracking goes on after the stretch until no second look
        can change it, as the run did.
        """
        end = self.stretch.stop
        if self.start is not None:
            last = pipeline.reader.frame_count if self.start.end is None else self.start.end
            end = max(end, last)
        with closing(pipeline.frames(range(self.reach.start, end))) as frames:
            for tracked in frames:
                if tracked.frame in self.stretch:
                    yield tracked
                again = pipeline.second_look.first
                if tracked.frame >= self.stretch.stop - 1 and (
                    not pipeline.second_look.due and (again is None or again >= self.stretch.stop)
                ):
                    return

    @property
    def _fits_shape(self) -> bool:
        p, stands = self.settings.tracking, self.start is not None and self.start.shape is not None
        return p.fit_shape and p.matching == "data_to_model" and not stands

    def _go_on(self, pipeline: Pipeline, start: Start, shapes: dict[Hashable, BodyShape]) -> None:
        """Find out what is not known of the body, and begin where the run was."""
        if pipeline.estimates_lengths and pipeline.has_clouds:
            if start.lengths is not None:
                pipeline.go_on_with(EstimatedLengths(start.lengths))
            else:
                pipeline.estimate_lengths(self.known)
        shape = start.shape
        if self._fits_shape:
            lengths, first = pipeline.body.skeleton.proportions, _pose_key(self.spec.init)
            key = stage_key(self.settings, Stage.SHAPE), lengths, self.known, self.spec.seed, first
            if key not in shapes:
                shapes[key] = pipeline.fit_shape(self.known)
            shape = shapes[key]
        pipeline.go_on_from(start.pose, self.stretch, P=start.P, shape=shape, look=start.look)


def _pose_key(pose: FirstPose) -> Hashable:
    """What tells first poses apart."""
    return pose if isinstance(pose, str) else (pose.position.tobytes(), pose.rotations.tobytes())
