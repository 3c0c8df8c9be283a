"""What ``stereotrack track`` shall do, from the command line or a run, and where its frames go."""

import dataclasses
import shlex
from argparse import Namespace
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stereotrack_core.cli.detect import detected_in_views
from stereotrack_core.cli.output import progress, say, stoppable
from stereotrack_core.cli.sources import clicks_for_tracking, initial_pose, keypoints_from
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.tracked_run import TrackedRun, TrackPlan, track_recording
from stereotrack_core.interop.first_pose import with_heading
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.interop.run_journal import Wish, has_frames, part_of, read_unfinished
from stereotrack_core.interop.run_npz import check_run
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import frame_count
from stereotrack_core.recording.selection import frames_within, tracked_views, views_of
from stereotrack_core.tracking import repeating
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import SUFFIX, preset, read_preset
from stereotrack_core.tracking.run_spec import AUTO, FirstPose, RunSpec, is_found
from stereotrack_core.tracking.unfinished import UnfinishedRun

USUAL_PRESET = "accurate"
_SETTLED = ("preset", "changes", "frames", "views", "seed", "init", "heading", "like", "clicks")
"""Options that could ask for something else than an unfinished run was begun with."""


class UnfinishedOutput:
    """The file ``RUN.part`` that frames go to; the output itself waits for the complete run."""

    def __init__(self, recording: Path, output: Path) -> None:
        self.output, self.part = output, part_of(output)
        words = ("stereotrack", "track", str(recording), "-o", str(output), "--resume")
        self.command = shlex.join(words)

    def begun(self) -> tuple[UnfinishedRun, Wish]:
        """The run to go on with. Raises InputError where there is none, or it cannot be read."""
        if not has_frames(self.part):  # or was killed before its first frame
            what = "there is no unfinished run to resume"
            raise InputError(what, self.part, "Omit --resume to start a run.")
        return read_unfinished(self.part)

    def track(self, plan: TrackPlan) -> TrackedRun:
        """Track, with progress; Cancelled where Ctrl-C stops it before the first frame."""
        with progress("Tracking", plan.before + plan.wanted) as show, stoppable() as stopped:
            return track_recording(plan, part=self.part, on_step=show, cancelled=stopped)

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Say where the frames are when an error ends the work."""
        try:
            yield
        except BaseException:
            if has_frames(self.part):
                say(f"The frames tracked so far are in {self.part}. To resume: {self.command}")
            raise

    def write(self, job: TrackedRun) -> Path | None:
        """Write what came out; where it is, None if nothing was tracked and an older run stands."""
        done = f"{len(job.run.frame)} of {counted(job.wanted, 'frame')}"
        if job.stopped and self.output.exists():
            there = f"Stopped after {done}; they are in {self.part}. {self.output} was not changed"
            say(f"{there}. To resume: {self.command}")
            return self.part
        if job.nothing and self.output.exists():
            say(f"{self.output} was not changed.")
            self.part.unlink(missing_ok=True)
            return None
        write_run(self.output, job.run)
        if job.stopped:
            say(f"Stopped after {done}; they are in {self.output}. To resume: {self.command}")
        else:
            self.part.unlink(missing_ok=True)
        return self.output


def plan_of(args: Namespace, recording: Recording, output: UnfinishedOutput) -> TrackPlan:
    """The plan of the command line; InputError if it cannot be followed, or a run would be lost."""
    if args.resume:
        return _plan_resumed(args, recording, output)
    if has_frames(output.part):
        remedy = "Resume it with --resume. To start again, delete it or choose another output."
        raise InputError("there is an unfinished run here", output.part, remedy)
    return _plan(args, recording) if args.like is None else _plan_like(args, recording)


def _plan(args: Namespace, recording: Recording) -> TrackPlan:
    name = args.preset or USUAL_PRESET
    settings = preset(name, args.changes)
    keypoints = _keypoints(args, recording, settings)
    views = tracked_views(recording, views_of(recording, args.views), keypoints)
    frames = frames_within(args.frames, frame_count(recording, views))
    spec = RunSpec(
        settings,
        preset=_preset_name(name),
        frames=frames,
        views=views,
        seed=args.seed or 0,
        init=with_heading(initial_pose(args, frames.start, recording), args.heading),
        smooth=args.smooth,
        keypoints=keypoints,
        clicks=_clicks(args.clicks, recording, settings),
    )
    return TrackPlan(recording, spec, len(frames))


def _plan_like(args: Namespace, recording: Recording) -> TrackPlan:
    """As the run says, with whatever the command line says otherwise."""
    run = read_run(args.like)
    stored = repeating.stored_spec(run)
    for sentence in repeating.what_differs(run, recording):
        say(f"{args.like}: {sentence}")
    preset_name, settings = _settings(args, stored)
    asked = views_of(recording, args.views) or stored.spec.views
    frames = _frames_like(args, stored, frame_count(recording, asked))
    elsewhere = args.views is not None or not set(frames) <= set(stored.spec.frames_of(0))
    if elsewhere:
        stored = stored.without_keypoints()
    keypoints, otherwise = stored.keypoints_or_stored(
        _keypoints(args, recording, settings, stored.spec.keypoints)
    )
    if stored.retracked:
        say("Stretches of the run were tracked again around clicks. The whole is tracked now.")
    if otherwise:
        say(otherwise)
    if stored.holds_detected and args.keypoints is None and settings.tracking.detector == "auto":
        say(f"Keypoints of the pose detector are taken from {args.like}; nothing is detected.")
    views = tracked_views(recording, asked, keypoints)
    if args.init is None and not stored.states_first_pose:
        what = "the run does not state its initial pose"
        raise InputError(what, args.like, "Set the initial pose with --init.")
    spec = dataclasses.replace(
        stored.spec,
        settings=settings,
        preset=preset_name,
        frames=frames,
        views=views,
        seed=stored.spec.seed if args.seed is None else args.seed,
        init=_init_like(args, stored, frames.start, recording),
        smooth=stored.spec.smooth or args.smooth,
        keypoints=keypoints,
        clicks=_clicks(args.clicks, recording, settings, run.meta.get("clicks")),
    )
    tracked = dataclasses.replace(recording, subject=stored.subject)
    count = stored.count if args.frames is None else len(frames)
    return TrackPlan(tracked, spec, count)


def _plan_resumed(args: Namespace, recording: Recording, output: UnfinishedOutput) -> TrackPlan:
    """As the unfinished run was begun; nothing may be otherwise."""
    for name in _SETTLED:
        if getattr(args, name) not in (None, []):
            what = "an unfinished run is resumed with the settings that it was started with"
            remedy = "Omit this option, or choose another output to start again."
            raise InputError(what, "--set" if name == "changes" else f"--{name}", remedy)
    begun, wish = output.begun()
    run = begun.run()
    check_run(output.part, run)
    stored = repeating.stored_spec(run)
    keypoints, seen_else = stored.keypoints_or_stored(
        _keypoints(args, recording, stored.spec.settings, stored.spec.keypoints)
    )
    views = tracked_views(recording, stored.spec.views, keypoints)
    foreign = list(filter(None, (*repeating.other_files(run, recording), seen_else)))
    foreign += repeating.missing_detector(run.meta)  # the frames that are left have to be looked at
    if foreign or not stored.states_first_pose:
        raise InputError(
            "the unfinished run cannot be resumed here" + (f": {foreign[0]}" if foreign else ""),
            output.part,
            "Restore the conditions it was started with, or track to another output. Its "
            "frames can still be evaluated and exported.",
        )
    for sentence in repeating.other_versions(run.meta):
        say(f"{output.part}: {sentence}")
    say(f"Resuming after {len(begun.frames)} of {len(begun.asked)} frames.")
    spec = dataclasses.replace(
        stored.spec,
        frames=begun.asked,
        views=views,
        smooth=wish.smooth or args.smooth,
        keypoints=keypoints,
        clicks=_clicks(args.clicks, recording, stored.spec.settings, run.meta.get("clicks")),
    )
    tracked = dataclasses.replace(recording, subject=stored.subject)
    return TrackPlan(tracked, spec, wish.count or len(begun.asked), begun=begun)


def _init_like(
    args: Namespace, stored: repeating.StoredSpec, first: int, recording: Recording
) -> FirstPose:
    """The run's first pose, or what the command line says instead."""
    if args.init is not None:
        return with_heading(initial_pose(args, first, recording), args.heading)
    if args.heading is None:
        return stored.spec.init
    init = AUTO if is_found(stored.spec.init) else stored.spec.init
    return with_heading(init, args.heading)


def _frames_like(args: Namespace, stored: repeating.StoredSpec, count: int) -> range:
    asked = args.frames
    frames = stored.spec.frames_of(count) if asked is None else frames_within(asked, count)
    if frames.stop > count:
        what = f"the run has the frames {frames.start}:{frames.stop}, the recording only 0:{count}"
        remedy = "Use the run's own recording, or restrict the range with --frames A:B."
        raise InputError(what, args.like, remedy)
    return frames


def _settings(args: Namespace, stored: repeating.StoredSpec) -> tuple[str, Settings]:
    """A preset replaces all of the run's parameters, ``--set`` single ones."""
    if args.preset is not None:
        return _preset_name(args.preset), preset(args.preset, args.changes)
    return stored.spec.preset, stored.spec.settings.replaced(**parsed_settings(args.changes))


def _preset_name(given: str) -> str:
    """Name that results state: of a file, that of the preset in it."""
    return read_preset(Path(given)).name if given.lower().endswith(SUFFIX) else given


def _clicks(
    path: Path | None,
    recording: Recording,
    settings: Settings,
    used: Mapping[str, Any] | None = None,
) -> Detections | None:
    """What ``--clicks`` names, or the clicks that a run `used`; None where there are none."""
    place = path or (Path(str(used["source"])) if used else None)
    if place is None:
        return None
    _check_used("clicks", settings)
    found = clicks_for_tracking(place, recording, frame_count(recording))
    if path is None and used and found.fingerprint() != used.get("fingerprint"):
        remedy = "Name the clicks to use with --clicks, and track to another output."
        raise InputError("these are not the clicks that the run used", place, remedy)
    return found


def _keypoints(
    args: Namespace, recording: Recording, settings: Settings, stored: Keypoints | None = None
) -> Keypoints | None:
    """What ``--keypoints`` names, of a project or a detector's file; else those of a stored run.

    Without any, mono views are looked at with the installed detector. Raises InputError where there
    are none, or the settings' tracker does not use them.
    """
    for option in ("layout", "person"):
        if args.keypoints is None and getattr(args, option) is not None:
            what = "there are no keypoints that it could say anything about"
            remedy = "Give the keypoints with --keypoints, or omit it."
            raise InputError(what, f"--{option}", remedy)
    if args.keypoints is None:
        if stored is not None or not detects_first(recording, settings):
            return stored
        return detected_in_views(recording, args.frames, views_of(recording, args.views))
    _check_used("keypoints", settings)
    return keypoints_from(args.keypoints, recording, args)


def _check_used(what: str, settings: Settings) -> None:
    """Refuse clicks or keypoints where the settings' tracker does not use them."""
    if not settings.follows_data:
        remedy = f"Choose --preset accurate or fast, or omit --{what}."
        raise InputError(f"this preset does not use {what}", f"--{what}", remedy)
