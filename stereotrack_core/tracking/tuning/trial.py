"""A stretch tracked with other settings, from a pose that is known or from a first pose."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.lengths_fit import EstimatedLengths
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore, Holdings
from stereotrack_core.tracking.tuning.stages import Stage, stage_key


@dataclass(frozen=True, eq=False)
class Start:
    """What is known before the first frame of a stretch, from a run that has been there."""

    pose: Pose
    """Of the frame before the stretch."""
    P: FloatArray | None = None
    """Shape (n, n). Its covariance; used where the tracker has the same state."""
    shape: BodyShape | None = None
    """The body's fitted shape, where it stands; None has it fitted again where the settings want
    that, from the first pose of the specification."""
    lengths: Proportions | None = None
    """Of the body, where they were estimated from the sequence and stand; None has them
    estimated again where the settings want that."""


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
    def key(self) -> CloudKey:
        """What its clouds depend on."""
        return CloudKey(self.settings.depth, self.known)

    def work(self, kept: Holdings) -> str:
        """What it has to do beyond what is kept; see :meth:`Holdings.work`."""
        return kept.work(self.key, self.stretch, shape=self._fits_shape)

    @contextmanager
    def begun(
        self, store: CloudStore, cancelled: Callable[[], bool] | None = None
    ) -> Iterator[Pipeline]:
        """A pipeline that is about to track the stretch.

        It gives what a :class:`Pipeline` gives that begins with the same pose, covariance and
        shape. With a run's own settings it gives the run again, bit by bit, but for two things that
        are not kept with a run: what is learned of colours, and for its first frame the movement
        before, by which lost limbs are told.

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

        clouds = store.clouds(self.key, self.stretch, cancelled)
        with Pipeline(store.recording, self.spec, clouds=clouds) as pipeline:
            pipeline.before_step = pipeline.on_preparing = ask
            if self.start is None:
                pipeline.prepare(self.stretch)
            else:
                self._go_on(pipeline, self.start, store.shapes)
            yield pipeline

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
        pipeline.go_on_from(start.pose, self.stretch, P=start.P, shape=shape)


def _pose_key(pose: FirstPose) -> Hashable:
    """What tells first poses apart."""
    return pose if isinstance(pose, str) else (pose.position.tobytes(), pose.rotations.tobytes())
