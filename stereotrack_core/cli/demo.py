"""``stereotrack demo``: copy the demo recording, track it, print its errors."""

from argparse import Namespace
from functools import partial

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, put_json, put_table, say
from stereotrack_core.cli.track import say_signs
from stereotrack_core.cli.track_plan import UnfinishedOutput
from stereotrack_core.cli.workbench import show_window
from stereotrack_core.demo import copied_demo
from stereotrack_core.evaluation.accuracy import Accuracy, accuracy_facts, accuracy_of, error_facts
from stereotrack_core.evaluation.summary import truth_of
from stereotrack_core.experiments.tracked_run import TrackPlan
from stereotrack_core.locks import writing
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import frame_count
from stereotrack_core.report.reported import error_table, segment_table
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.window import DemoTracking, Opening

_SHOWN_FRAME = 60  # frame shown after the demo has been tracked


@options.command(
    options.path(
        "folder DIR",
        "folder for the recording and the run (default: the program's data folder)",
        nargs="?",
    ),
    options.flag("--headless", "print the errors and do not open the workbench"),
    options.path(
        "--screenshot PNG",
        "save a screenshot of the workbench showing the demo and exit; works without a display",
    ),
    *options.SETTINGS,
)
def run(args: Namespace) -> int:
    """Track a copy of the demo recording, print the errors of each limb, and open the
    workbench on it. With --headless the workbench is not opened.
    """
    settings = preset(args.preset, args.changes)
    if args.headless:
        return _without_window(args, settings)
    tracking = DemoTracking(args.folder, args.preset, settings, partial(_put_errors, args.preset))
    opening = Opening(frame=_SHOWN_FRAME, demo=tracking, picture=args.screenshot)
    return show_window(args.window, opening)


def _without_window(args: Namespace, settings: Settings) -> int:
    """Copy the recording, track it, write the run, print the tables; a picture where asked for."""
    places = copied_demo(args.folder)
    recording = open_recording(places.recording)
    frames = range(frame_count(recording))
    say(f"Tracking {len(frames)} frames with preset {args.preset}.")
    output = UnfinishedOutput(places.recording, places.run)
    with writing(places.run), output.telling():
        output.part.unlink(missing_ok=True)  # all of the demo is made again
        job = output.track(TrackPlan(recording, RunSpec(settings, args.preset, frames)))
        if not len(job.run.frame):
            say("Stopped before the first frame.")
            return FAILED
        output.write(job)
    facts = job.to_dict()
    if args.json:
        accuracy = _accuracy(recording, job.run.trajectory())
        told = {"run": places.run, "recording_folder": places.recording, **accuracy_facts(accuracy)}
        put_json({**facts, **told, "segments": [error_facts(one) for one in accuracy.segments]})
    else:
        _put_errors(args.preset, recording, job.run.trajectory(), facts["frames_per_second"])
    say(f"Recording saved to {places.recording}, run saved to {places.run}.")
    say_signs(job)
    if job.stopped or job.nothing:
        return FAILED
    if args.screenshot is None:
        return OK
    opening = Opening(
        places.recording, _SHOWN_FRAME, workspace="track", run=places.run, picture=args.screenshot
    )
    return show_window(args.window, opening)


def _accuracy(recording: Recording, found: LandmarkTrajectory) -> Accuracy:
    """Errors of a run as far as it goes, whole and by segment."""
    stretch = range(int(found.frame[-1]) + 1)
    return accuracy_of(found, truth_of(recording), None, recording.segments, stretch)


def _put_errors(
    preset_name: str, recording: Recording, found: LandmarkTrajectory, fps: float | None
) -> None:
    accuracy = _accuracy(recording, found)
    title = f"Demo recording, preset {preset_name}, {len(found.frame)} frames"
    put_table(error_table(accuracy, title, fps))
    put_table(segment_table(accuracy.segments))
