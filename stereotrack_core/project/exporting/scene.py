"""A run with its images and clouds for the Rerun viewer."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from stereotrack_core.counting import counted
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.volume import settled
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.interop.motion.rerun import SeenFrame, rerun_library, write_rerun
from stereotrack_core.project.exporting.runs import Exported
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader, FrameSet
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import stored_spec

SCENE = "rrd"
"""Name of the format."""


def export_scene(
    path: Path,
    run: Run,
    recording: Recording,
    *,
    frames: Sequence[int] | None = None,
    views: Sequence[str] | None = None,
    clouds: bool = True,
    report: Callable[[float], None] = lambda _share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Exported:
    """Write a run with images and, where views give depth, with clouds.

    Raises InputError where the library is not installed or the file cannot be written, and
    Cancelled where it is stopped; nothing is written then.

    Parameters
    ----------
    frames : sequence of int, optional
        Some of the run's; all where not given.
    views : sequence of str, optional
        Whose images are written; all where not given.
    clouds : bool
        Whether clouds are worked out again, which takes most of the time.
    report, stopped : callable, optional
        Told the share that is done, and asked whether to stop.
    """
    rerun_library(path)
    names = views or tuple(view.name for view in recording.views)
    wanted = run.frame.tolist() if frames is None else list(frames)
    with (
        FrameReader(recording, views=names) as reader,
        _cloud_maker(run, recording, reader, names, wanted=clouds) as cloud_of,
    ):
        problems: dict[str, None] = {}
        seen = _seen(wanted, reader, cloud_of, problems)
        followed = _followed(seen, len(wanted), report, stopped)
        count = write_rerun(path, run, recording, followed, LIMB_COLOURS)
    return Exported({path: counted(count, "frame")}, tuple(problems))


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
    frames: Sequence[int],
    reader: FrameReader,
    cloud_of: Callable[[FrameSet], Cloud] | None,
    problems: dict[str, None],
) -> Iterator[SeenFrame]:
    """Images and cloud of frame after frame; a picture that cannot be read is left out."""
    for frame in frames:
        shown = reader.frame_set(frame)
        problems.update(dict.fromkeys(shown.problems.values()))
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
