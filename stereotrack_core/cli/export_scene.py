"""``stereotrack export --format rrd``: a run with its images and clouds for the Rerun viewer."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager

from stereotrack_core.cli.arguments import check_output
from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.sources import recording_of_run, say_if_unfinished
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.volume import settled
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.interop.motion.rerun import SeenFrame, rerun_library, write_rerun
from stereotrack_core.interop.run_file import holds_run, read_run
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader, FrameSet
from stereotrack_core.recording.selection import asked_frames, usable_views, views_of
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import stored_spec


def export_rerun(args: Namespace) -> int:
    """Write a run with images and clouds; the number of frames."""
    rerun_library(args.output)
    if not holds_run(args.source):
        raise InputError(
            "a Rerun recording is made of a complete run",
            where=str(args.source),
            remedy="Use an .npz file written by `stereotrack track`.",
        )
    run = read_run(args.source)
    say_if_unfinished(args.source, run)
    recording = recording_of_run(args.recording, run, "there are no images to write")
    if recording is None:
        raise InputError(
            "the run's recording was not found",
            where=str(args.source),
            remedy="Give its folder with --recording.",
        )
    check_output(args.output, recording)
    asked = asked_frames(args.frames)
    frames = [frame for frame in run.frame.tolist() if frame in asked]
    if not frames:
        raise InputError(
            "the run has none of these frames",
            where="--frames",
            remedy=f"It has the frames {run.frame.min()}:{run.frame.max() + 1}.",
        )
    views = views_of(recording, args.views) or tuple(view.name for view in recording.views)
    with (
        watched("Exporting", "Nothing was written.") as (report, stopped),
        FrameReader(recording, views=views) as reader,
        _cloud_maker(run, recording, reader, views, wanted=not args.no_clouds) as cloud_of,
    ):
        seen = _seen(frames, reader, cloud_of)
        followed = _followed(seen, len(frames), lambda share: report(share, ""), stopped)
        return write_rerun(args.output, run, recording, followed, LIMB_COLOURS)


@contextmanager
def _cloud_maker(
    run: Run, recording: Recording, reader: FrameReader, views: Sequence[str], *, wanted: bool
) -> Iterator[Callable[[FrameSet], Cloud] | None]:
    """Give what makes the cloud of a frame by the run's own parameters; None where nothing does."""
    deep = [name for name in views if recording.view(name).kind != "mono"]
    if not (wanted and deep):
        yield None
        return
    used = usable_views(recording, deep)
    depth = settled(recording, stored_spec(run).spec.settings.depth, reader, used)
    chain = DepthChain(recording, depth, views=used)
    with closing(chain):
        chain.learn_background(reader, range(reader.frame_count))
        yield chain.process


def _seen(
    frames: Sequence[int], reader: FrameReader, cloud_of: Callable[[FrameSet], Cloud] | None
) -> Iterator[SeenFrame]:
    """Images and cloud of frame after frame; a picture that cannot be read is left out."""
    for frame in frames:
        shown = reader.frame_set(frame)
        for problem in shown.problems.values():
            say(problem)
        images = {name: images.image for name, images in shown.views.items()}
        yield SeenFrame(frame, images, None if cloud_of is None else cloud_of(shown))


def _followed(
    seen: Iterator[SeenFrame],
    count: int,
    report: Callable[[float], None],
    stopped: Callable[[], bool],
) -> Iterator[SeenFrame]:
    """The same, with the share that is done; Cancelled where the person stops it."""
    for done, one in enumerate(seen):
        if stopped():
            raise Cancelled
        report(done / count)
        yield one
