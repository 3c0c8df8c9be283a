"""Episodes as strips of pictures and as a video."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from stereotrack_core.arrays import ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.episodes.episode import CAUSE_WORDS, Episode, limbs_words
from stereotrack_core.evaluation.episodes.film import write_film
from stereotrack_core.evaluation.episodes.find import Subject
from stereotrack_core.evaluation.episodes.strip import WHITE, Paper, evenly, picture_strip
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png

STRIP_FRAMES = 5
_AROUND = 0.3
"""Seconds before and after an episode that a video shows as well."""


def strip_name(episode: Episode) -> str:
    """Name of the file of an episode's strip: ``0144-0183-left-forearm-crossing-truth.png``."""
    limbs = limbs_words(episode.limbs).replace(", ", "+").replace(" ", "-")
    cause, found = episode.verdict.cause, episode.found
    return f"{episode.first:04d}-{episode.last:04d}-{limbs}-{cause}-{found}.png"


def strip_of(
    subject: Subject,
    recording: Recording,
    episode: Episode,
    *,
    view: str | None = None,
    count: int = STRIP_FRAMES,
    reader: FrameReader | None = None,
) -> ImageArray:
    """Evenly spread frames of an episode as a strip (H, W, 3) BGR; see :func:`picture_strip`."""
    frames = evenly(episode.first, episode.last, count)
    return picture_strip(
        recording, subject.run, frames, view,
        limbs=episode.limbs, reference=_shown_truth(subject, episode), reader=reader,
    )  # fmt: skip


def write_strips(
    folder: Path,
    subject: Subject,
    recording: Recording,
    episodes: Sequence[Episode],
    *,
    view: str | None = None,
    count: int = STRIP_FRAMES,
    report: Callable[[float, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> int:
    """Write a strip of each episode as PNG into a folder, which is made; returns their number.

    Raises
    ------
    InputError
        Where not all of them can be written there; then none is.
    Cancelled
        None is written.
    """
    with filling(folder) as workplace, FrameReader(recording, read_ahead=0) as reader:
        for i, episode in enumerate(episodes):
            if cancelled is not None and cancelled():
                raise Cancelled
            strip = strip_of(subject, recording, episode, view=view, count=count, reader=reader)
            write_png(workplace / strip_name(episode), strip)
            if report is not None:
                report((i + 1) / len(episodes), f"{i + 1} of {len(episodes)}")
    return len(episodes)


def before_peak_after(subject: Subject, episode: Episode) -> list[int]:
    """Frames just before an episode, at its peak and just after it, as far as the run has them."""
    around = max(1, round(_AROUND * subject.fps))
    frame = subject.run.frame
    before = frame[frame <= episode.first - around]
    after = frame[frame >= episode.last + around]
    first = int(before[-1]) if len(before) else episode.first
    last = int(after[0]) if len(after) else episode.last
    return sorted({first, episode.peak_frame, last})


def evidence_picture(
    subject: Subject,
    recording: Recording,
    episode: Episode,
    *,
    reader: FrameReader | None = None,
    paper: Paper = WHITE,
) -> ImageArray:
    """Before, peak and after beside each other (H, W, 3) BGR, in the view that shows it best."""
    return picture_strip(
        recording, subject.run, before_peak_after(subject, episode),
        limbs=episode.limbs, reference=_shown_truth(subject, episode), reader=reader, paper=paper,
    )  # fmt: skip


def film_of(
    path: Path,
    subject: Subject,
    recording: Recording,
    episodes: Sequence[Episode],
    report: Callable[[float, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Write a video of episodes, one after the other, with what is just before and after each."""
    around = round(_AROUND * subject.fps)
    known = {int(frame) for frame in subject.run.frame}
    limbs = {limb: None for episode in episodes for limb in episode.limbs}
    frames = sorted(
        {
            frame
            for e in episodes
            for frame in range(e.first - around, e.last + around + 1)
            if frame in known
        }
    )
    one = episodes[0] if len(episodes) == 1 else None
    title = CAUSE_WORDS[one.verdict.cause] if one is not None else ""
    reference = subject.reference if any(e.found == "truth" for e in episodes) else None
    write_film(
        path, recording, subject.run, frames,
        limbs=tuple(limbs), reference=reference, title=title, report=report, cancelled=cancelled,
    )  # fmt: skip


def _shown_truth(subject: Subject, episode: Episode) -> LandmarkTrajectory | None:
    return subject.reference if episode.found == "truth" else None
