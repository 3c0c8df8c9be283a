"""A stretch tracked with some settings, from a pose that is known or from a first pose."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Hashable
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.reader import has_colours
from stereotrack_core.tracking.estimate import Estimate, Tracker
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.lengths_fit import EstimatedLengths
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run import Pipeline
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore, never
from stereotrack_core.tracking.tuning.stages import shape_key
from stereotrack_core.tracking.tuning.work import Work, fits_shape


@dataclass(frozen=True, eq=False)
class Start:
    """What is known before the first frame of a stretch, from a run that has been there.

    Attributes
    ----------
    pose : Pose
        Of the frame before the stretch.
    P : (n, n) float64 or None
        Its covariance; used where the tracker has the same state.
    shape : BodyParameters or None
        The body's fitted shape, where it stands; None has it fitted again where the settings
        want that.
    first : Pose or None
        Pose with which the run began, for the fit of the shape.
    lengths : Proportions or None
        Of the body, where they were estimated from the sequence and stand; None has them
        estimated again where the settings want that.
    """

    pose: Pose
    P: FloatArray | None = None
    shape: BodyParameters | None = None
    first: Pose | None = None
    lengths: Proportions | None = None


@dataclass(frozen=True, eq=False)
class Attempt:
    """What shall be tracked.

    Attributes
    ----------
    settings : Settings
    stretch : range
        Successive frames.
    start : Start or None
        None: as a run over the stretch alone begins, by `init`.
    seed : int
    learned_from : range or None
        Frames from which the background is learned and the shape is fitted: those of the run
        that the attempt is compared with. The stretch where not given.
    init : str or Pose
        First pose where `start` is None; see :class:`Pipeline`.
    preset : str
        Name of the preset from which the settings were made.
    """

    settings: Settings
    stretch: range
    start: Start | None = None
    seed: int = 0
    learned_from: range | None = None
    init: FirstPose = "auto"
    preset: str = ""

    @property
    def known(self) -> range:
        """Frames from which the background is learned and the shape is fitted."""
        return self.stretch if self.learned_from is None else self.learned_from

    def key(self, *, colour: bool) -> CloudKey:
        """What its clouds depend on."""
        return CloudKey(self.settings.depth, self.known, colour)

    @property
    def fits_shape(self) -> bool:
        """Whether the body's shape has to be fitted."""
        stands = self.start is not None and self.start.shape is not None
        return fits_shape(self.settings) and not stands


class AttemptPipeline(Pipeline):
    """A pipeline that begins within a recording and ends at once when it is told to.

    It gives what a :class:`Pipeline` gives that begins with the same pose, covariance and shape.
    With a run's own settings it gives the run again, bit by bit, but for two things that are not
    kept with a run: what is learned of colours, and for its first frame the movement before, by
    which lost limbs are told.

    Parameters
    ----------
    attempt : Attempt
    store : CloudStore
        Keeps the clouds; shared by successive attempts.
    cancelled : callable, optional
        Asked many times within each frame; where it says so, whatever is under way raises
        :class:`Cancelled`.

    Raises
    ------
    Cancelled, InputError
        See :meth:`CloudStore.clouds`.
    """

    def __init__(
        self,
        attempt: Attempt,
        store: CloudStore,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        self._attempt = attempt
        self._cancelled = cancelled or never
        self._shapes = store.shapes
        start = attempt.start
        first = attempt.init if start is None or start.first is None else start.first
        clouds = store.clouds(
            attempt.key(colour=colours(attempt, store)), attempt.stretch, cancelled
        )
        super().__init__(
            store.recording,
            RunSpec(
                attempt.settings,
                preset=attempt.preset,
                views=store.views,
                seed=attempt.seed,
                init=first,
            ),
            clouds=clouds,
        )
        self.body = stoppable(self.body, self._cancelled)
        self.on_first_pass = self._ask

    @property
    def plain_body(self) -> BodyModel:
        """The body that is tracked, for those who draw it."""
        return BodyModel(self.body.skeleton, self.body.cones)

    def tracked(self) -> Generator[TrackedFrame, None, None]:
        """Each frame of the stretch as soon as it is tracked.

        Raises
        ------
        Cancelled
            In the middle of a frame, where the attempt is no longer wanted.
        """
        yield from self.frames(self._attempt.stretch)

    def prepare(self, frames: range) -> None:
        """Begin where the attempt begins; see :class:`Pipeline`."""
        start = self._attempt.start
        if start is None:
            super().prepare(frames)
            return
        if self._prepared:
            return
        self._prepared, self._asked = True, frames
        if self.settings.body.proportions == "sequence":
            self._estimate_lengths(start.lengths)
        if self._attempt.fits_shape:
            self._fit_or_remember()
        elif start.shape is not None:
            self.shape = start.shape
            plain = body_model(self.body.skeleton.proportions, start.shape)
            self.body = stoppable(plain, self._cancelled)
        self.tracker = self._tracker()
        self.tracker.start(start.pose, P=start.P)
        self._started = True

    def _fit_or_remember(self) -> None:
        """Fit the shape, unless an attempt before has fitted it to the same clouds."""
        attempt, shapes = self._attempt, self._shapes
        lengths = self.body.skeleton.proportions
        key = (
            shape_key(attempt.settings),
            lengths,
            attempt.known,
            attempt.seed,
            pose_key(self._init),
        )
        if key in shapes:
            self.shape = shapes[key]
            self.body = body_model(lengths, self.shape)
            return
        self._fit_shape(attempt.known)
        self._made.clear()
        shapes[key] = self.shape

    def _estimate_lengths(self, known: Proportions | None) -> None:
        """Go on with lengths that are known already, or estimate them."""
        if known is not None:
            self.go_on_with(EstimatedLengths(known))
            return
        self.take_lengths(self._attempt.known)
        self._made.clear()

    def _ask(self, _: TrackedFrame) -> None:
        if self._cancelled():
            raise Cancelled

    def origin(self) -> Origin:
        """Where the frames come from, with the pose that the stretch began with."""
        start = self._attempt.start
        if start is None:
            return super().origin()
        origin = super().origin()
        spec = dataclasses.replace(origin.spec, init=start.pose)
        return dataclasses.replace(origin, spec=spec, given="the pose of another run")

    def _tracker(self) -> Tracker:
        self.body = stoppable(self.body, self._cancelled)
        return super()._tracker()

    def _estimate(self, cloud: Cloud) -> Estimate:
        if self._cancelled():
            raise Cancelled
        return super()._estimate(cloud)


def attempted(
    attempt: Attempt, store: CloudStore, cancelled: Callable[[], bool] | None = None
) -> Generator[TrackedFrame, None, None]:
    """Frames of an attempt, one by one.

    Raises
    ------
    Cancelled
        In the middle of a frame, where `cancelled` says so.
    """
    pipeline = AttemptPipeline(attempt, store, cancelled)
    with pipeline:
        yield from pipeline.tracked()


def colours(attempt: Attempt, store: CloudStore) -> bool:
    """Whether the points of an attempt have colours."""
    wanted = attempt.settings.tracking.wants_colour
    names = store.views or [view.name for view in store.recording.views if view.kind != "mono"]
    return wanted and store.reader.colour and has_colours(store.recording, names)


def work_of(attempt: Attempt, store: CloudStore) -> Work:
    """What an attempt has to do beyond what is kept."""
    key = attempt.key(colour=colours(attempt, store))
    return store.work(key, attempt.stretch, shape=attempt.fits_shape)


@dataclass(frozen=True, eq=False)
class _StoppableBody(BodyModel):
    """A body that asks, whenever its parts are placed, whether that is still wanted.

    All ways of tracking place the parts in each of their iterations.
    """

    cancelled: Callable[[], bool]

    def frames(self, pose: Pose) -> PartFrames:
        """See :class:`BodyModel`."""
        if self.cancelled():
            raise Cancelled
        return super().frames(pose)


def stoppable(body: BodyModel, cancelled: Callable[[], bool]) -> BodyModel:
    """The same body, for a tracker that may be stopped within a frame."""
    return _StoppableBody(body.skeleton, body.cones, cancelled)


def pose_key(pose: FirstPose) -> Hashable:
    """What tells first poses apart."""
    if isinstance(pose, str):
        return pose
    return pose.position.tobytes(), pose.rotations.tobytes()
