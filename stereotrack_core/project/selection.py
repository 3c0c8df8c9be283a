"""Edits of all that is selected: frames, and landmarks where some are chosen."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.arrays import stretches_of
from stereotrack_core.counting import frames_in_words
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import delete_clicks
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.marks import GAP, REVIEW, FrameFlag, flag_frames, mark_keyframes
from stereotrack_core.project.project import Project


@dataclass(frozen=True)
class Selection:
    """Frames and landmarks that commands work on."""

    frames: range  # not empty, without steps
    landmarks: tuple[str, ...] = ()  # empty: all of them

    def words(self) -> str:
        """``frames 120 – 180, left elbow``."""
        words = frames_in_words(self.frames)
        if len(self.landmarks) > 2:
            return f"{words}, {len(self.landmarks)} landmarks"
        names = " and ".join(name.replace("_", " ") for name in self.landmarks)
        return f"{words}, {names}" if names else words

    def has(self, landmark: str) -> bool:
        """Whether a landmark is selected."""
        return not self.landmarks or landmark in self.landmarks


def clear_clicks(project: Project, selection: Selection) -> Edit:
    """Delete all selected clicks; InputError where there are none."""
    clicks = project.clicks.between(selection.frames.start, selection.frames.stop)
    keys = tuple(click.key for click in clicks if selection.has(click.landmark))
    if not keys:
        raise _nothing(f"there are no clicks in {selection.words()}")
    return delete_clicks(keys)


def set_flags(_project: Project, selection: Selection, kind: str = REVIEW) -> Edit:
    """Flag the selection: to be looked at again, or as a gap over which nothing is interpolated."""
    names = selection.landmarks or ("",)
    return flag_frames(tuple(FrameFlag(k, name, kind) for k in selection.frames for name in names))


def clear_flags(project: Project, selection: Selection, kind: str = "") -> Edit:
    """Clear flags of a kind, or all but gaps, in a selection. Raises InputError without any."""
    found = tuple(
        flag
        for flag in project.marks.flags()
        if flag.frame in selection.frames
        and (flag.kind == kind if kind else flag.kind != GAP)
        and selection.has(flag.landmark)
    )
    if not found:
        what = "marked as a gap" if kind == GAP else "flagged"
        raise _nothing(f"nothing is {what} in {selection.words()}")
    return flag_frames(found, off=True)


def set_keyframes(project: Project, selection: Selection, state: str) -> Edit:
    """Let keyframes be ``done``, ``wanted`` or ``none``; InputError if none is selected."""
    frames = tuple(k.frame for k in project.marks.keyframes() if k.frame in selection.frames)
    if state != "none" and len(selection.frames) == 1:
        frames = (selection.frames.start,)
    if not frames:
        raise _nothing(f"there are no keyframes in {frames_in_words(selection.frames)}")
    return mark_keyframes(frames, state)


def gaps_of(project: Project) -> tuple[range, ...]:
    """Stretches of frames that are wholly marked as gaps, ascending."""
    frames = [one.frame for one in project.marks.flags() if one.kind == GAP and not one.landmark]
    marked = np.zeros(max(frames, default=-1) + 1, dtype=np.bool_)
    marked[frames] = True
    return tuple(stretches_of(marked))


def landmark_gaps_of(project: Project) -> dict[str, frozenset[int]]:
    """Frames in which a single landmark is marked as a gap, by landmark."""
    gaps = [flag for flag in project.marks.flags() if flag.kind == GAP and flag.landmark]
    names = {flag.landmark for flag in gaps}
    return {name: frozenset(f.frame for f in gaps if f.landmark == name) for name in names}


def outside_gaps(project: Project, predictions: Iterable[Prediction]) -> list[Prediction]:
    """The predictions whose frame, or whose landmark in the frame, is not marked as a gap."""
    gaps = {(flag.frame, flag.landmark) for flag in project.marks.flags() if flag.kind == GAP}
    return [p for p in predictions if gaps.isdisjoint(((p.frame, ""), (p.frame, p.landmark)))]


def _nothing(what: str) -> InputError:
    return InputError(what, remedy="Select other frames in the timeline.")
