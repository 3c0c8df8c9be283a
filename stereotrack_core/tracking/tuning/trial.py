"""A stretch tracked with other settings, from a pose that is known or from a first pose."""

from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace

from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import FirstFrame, Replaced, TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.prepare import (
    Start,
    continued,
    estimates_lengths,
    prepare,
    unprepared,
    with_estimated_lengths,
    with_fitted_shape,
    with_lengths,
)
from stereotrack_core.tracking.run import Advance, advances
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.second_look import SecondLook, last_settled
from stereotrack_core.tracking.tracking import Tracking
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore
from stereotrack_core.tracking.tuning.stages import Stage, stage_key


@dataclass(frozen=True, eq=False)
class TrialStart(Start):
    """Where a run was before a stretch; without a shape it is fitted again if wanted."""

    lengths: Proportions | None = None  # estimated in the run; None: again if wanted
    frame: int | None = None  # of the pose; those up to the stretch are tracked and not shown
    end: int | None = None  # of the run, half-open, where a second look ends
    unlike: tuple[str, ...] = ()  # differences from the run besides parameters


_LONGEST_LEAD = 150  # frames tracked before a stretch: as long as the stretch itself
_LEAD = "Before the stretch the run was lost, or looked at again, for longer than a trial repeats."
_UNSTATED = "The run does not state the pose that it began with."


def start_before(
    frames: Mapping[int, TrackedFrame], first: int, began: FirstFrame | None = None
) -> TrialStart | None:
    """Where a trial from `first` on starts to go the way of the run that `began` there, or None."""
    end, place = max(frames, default=-1) + 1, last_settled(frames, first - 1)
    if place is not None and first - 1 - place <= _LONGEST_LEAD:
        at = frames[place]
        look = SecondLook.after(frames[k] for k in sorted(frames) if k <= place)
        return TrialStart(at.estimate.pose, at.P, look=look, frame=place, end=end)
    if place is None and began is not None and 0 <= first - began.frame <= _LONGEST_LEAD:
        return TrialStart(began.pose, frame=began.frame - 1, end=end)
    unlike = (_UNSTATED if place is None and began is None else _LEAD,)
    before, here = frames.get(first - 1), frames.get(first)
    if before is not None and before.tracked:
        return TrialStart(before.estimate.pose, before.P, end=end, unlike=unlike)
    if here is not None and here.tracked:
        return TrialStart(here.estimate.pose, end=end, unlike=unlike)
    return None


@dataclass(frozen=True, eq=False)
class Trial:
    """What shall be tracked."""

    spec: RunSpec  # with the stretch as its frames
    start: TrialStart | None = None  # None: as a run over the stretch alone begins
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
        settings, views = self.settings, tuple(self.spec.views or ())
        return CloudKey(settings.depth, self.known, settings.uses_detector, views)

    @contextmanager
    def begun(
        self, store: CloudStore, cancelled: Callable[[], bool] = lambda: False
    ) -> Iterator[tuple[Tracking, Hooks]]:
        """A run that is prepared, and the hooks that stop it. Raises Cancelled, InputError."""
        hooks = Hooks.asking(cancelled)
        kept = store.clouds(self.key, self.reach, cancelled)
        with Clouds(store.recording, self.spec, kept) as clouds:
            if self.start is None:
                yield prepare(clouds, hooks), hooks
            else:
                yield self._continued(clouds, self.start, store.shapes, hooks), hooks

    def advances(self, run: Tracking, hooks: Hooks) -> Iterator[Advance]:
        """Frames of the stretch, and those that a second look replaces.

        With the run's own settings they are the run's, bit by bit, unless :attr:`TrialStart.unlike`
        says why not. It goes on until no second look can change them.
        """
        end = self.stretch.stop
        if self.start is not None:
            last = run.clouds.reader.frame_count if self.start.end is None else self.start.end
            end = max(end, last)
        with closing(advances(run, range(self.reach.start, end), hooks)) as found:
            newest = -1
            for advance in found:
                gained = advance.gained
                shown = tuple(one for one in gained.frames if one.frame in self.stretch)
                if shown or not gained.frames:
                    first = shown[0].frame if shown else gained.first
                    yield Advance(advance.run, Replaced(first, shown))
                newest = gained.frames[-1].frame if gained.frames else gained.first - 1
                again = advance.run.look.first
                if newest >= self.stretch.stop - 1 and (
                    not advance.run.look.due and (again is None or again >= self.stretch.stop)
                ):
                    return

    def _continued(
        self, clouds: Clouds, start: TrialStart, shapes: dict[Hashable, BodyShape], hooks: Hooks
    ) -> Tracking:
        """Find out what is not known of the body, and begin where the run was."""
        run, shape, settings = unprepared(clouds), start.shape, self.settings
        if estimates_lengths(run) and clouds.have_depth:
            if start.lengths is not None:
                run = with_lengths(run, start.lengths)
            else:
                run = with_estimated_lengths(run, self.known, hooks)
        if shape is None and settings.tracking.fit_shape and settings.follows_data:
            init, lengths = self.spec.init, run.body.skeleton.proportions
            first = init if isinstance(init, str) else str(init.values())
            key = stage_key(settings, Stage.SHAPE), lengths, self.known, self.spec.seed, first
            if key not in shapes:
                shapes[key] = with_fitted_shape(run, self.known, hooks).body.shape
            shape = shapes[key]
        return continued(run, replace(start, shape=shape))
