"""Picture strips and curves of the motions that the thesis shows."""

from __future__ import annotations

from collections.abc import Sequence

import cv2

from stereotrack_core.atomic import write_file
from stereotrack_core.evaluation.episodes.best_view import best_view
from stereotrack_core.evaluation.episodes.strip import picture_strip
from stereotrack_core.experiments.reproduction.curves import motion_curves
from stereotrack_core.experiments.reproduction.outcomes import Outcome
from stereotrack_core.experiments.reproduction.page import MotionPictures
from stereotrack_core.experiments.reproduction.places import Places
from stereotrack_core.experiments.reproduction.plan import Way
from stereotrack_core.experiments.reproduction.tables import source_name
from stereotrack_core.experiments.reproduction.thesis import MOTIONS, ThesisMotion
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.description import Recording, Segment

_QUALITY = 82


def motion_pictures(
    places: Places, recordings: Sequence[Recording], outcomes: Sequence[Outcome]
) -> tuple[MotionPictures, ...]:
    """Curves and strips of every motion whose runs are there; files of both beside the page."""
    by_name = {recording.name: recording for recording in recordings}
    made = []
    for motion in MOTIONS:
        own = [o for o in outcomes if o.recording == motion.recording]
        recording = by_name.get(motion.recording)
        found = [] if recording is None else recording.segments
        segment = next((s for s in found if s.name == motion.segment), None)
        if not own or segment is None or recording is None:
            continue
        frames = shown_frames(motion, segment)
        curves = motion_curves(own, motion)
        write_file(places.folder / f"figure-{motion.curves}.svg", curves)
        strips = _strips(places, recording, own, motion, frames)
        made.append(MotionPictures(motion, curves, strips, frames))
    return tuple(made)


def shown_frames(motion: ThesisMotion, segment: Segment) -> tuple[int, ...]:
    """The thesis's own frame numbers, moved to where the motion is here."""
    first, last = motion.frames[0], motion.frames[-1]
    length = segment.end - 1 - segment.first
    shares = [(frame - first) / (last - first) for frame in motion.frames]
    return tuple(segment.first + round(share * length) for share in shares)


def _strips(
    places: Places,
    recording: Recording,
    outcomes: Sequence[Outcome],
    motion: ThesisMotion,
    frames: Sequence[int],
) -> dict[str, bytes]:
    """One strip per preset, of its first seed; the same view for all."""
    plain = [o for o in outcomes if o.entry.way == Way(o.entry.way.preset) and o.entry.seed == 0]
    strips: dict[str, bytes] = {}
    view = None
    for outcome in sorted(plain, key=lambda o: o.entry.way.preset == "thesis"):
        run = read_npz(places.run(recording.name, outcome.entry))
        view = view or best_view(recording, run, frames)
        strip = picture_strip(recording, run, frames, view, reference=recording.reference)
        done, data = cv2.imencode(".jpg", strip, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        if done:
            name = source_name(outcome.entry.way)
            strips[name] = data.tobytes()
            file = places.folder / f"figure-{motion.pictures}-{outcome.entry.way.preset}.jpg"
            write_file(file, strips[name])
    return strips
