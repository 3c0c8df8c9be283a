"""Edits of all that is selected in the timeline: frames, and landmarks where some are chosen."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import DeleteClicks
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.marks import FrameFlag, SetFlags, SetKeyframes
from stereotrack_core.project.project import Project

from ...session.counting import frames_in_words
from .lanes import GAP

_LOOK_AGAIN = "review"


@dataclass(frozen=True)
class Selection:
    """What commands work on.

    Attributes
    ----------
    frames : range
        Not empty, without steps.
    landmarks : tuple of str
        Empty: all of them.
    """

    frames: range
    landmarks: tuple[str, ...] = ()

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


def selection_of(
    frames: range | None, here: int, lanes: Collection[str], landmarks: Collection[str]
) -> Selection:
    """The selection in the timeline; without selected frames the one that is shown.

    Parameters
    ----------
    frames : range or None
    here : int
        The frame that is shown.
    lanes : collection of str
        Lanes that are selected, of whichever kind.
    landmarks : collection of str
        The project's landmarks, in their order.
    """
    chosen = tuple(name for name in landmarks if name in lanes)
    return Selection(frames if frames else range(here, here + 1), chosen)


def selected_clicks(project: Project, selection: Selection) -> tuple[Click, ...]:
    """Clicks that are selected, by frame."""
    clicks = project.clicks.between(selection.frames.start, selection.frames.stop)
    return tuple(click for click in clicks if selection.has(click.landmark))


def clear_clicks(project: Project, selection: Selection) -> Edit:
    """Take all selected clicks away.

    Raises
    ------
    InputError
        Where there are none.
    """
    clicks = selected_clicks(project, selection)
    if not clicks:
        raise _nothing(f"there are no clicks in {selection.words()}")
    return DeleteClicks(tuple(click.key for click in clicks))


def mark_gap(selection: Selection) -> Edit:
    """Let nothing be interpolated over the selected frames (of the selected landmarks)."""
    return SetFlags(_flags(selection, GAP))


def unmark_gap(project: Project, selection: Selection) -> Edit:
    """Let the selected frames be interpolated again.

    Raises
    ------
    InputError
        Where nothing selected is marked as a gap of its own.
    """
    return SetFlags(_present(project, selection, GAP), off=True)


def flag_frames(selection: Selection) -> Edit:
    """Flag the selection to be looked at again."""
    return SetFlags(_flags(selection, _LOOK_AGAIN))


def unflag_frames(project: Project, selection: Selection) -> Edit:
    """Take all flags of the selection away, gaps left alone.

    Raises
    ------
    InputError
        Where nothing selected is flagged.
    """
    return SetFlags(_present(project, selection, ""), off=True)


def keyframes_every(selection: Selection, step: int) -> Edit:
    """Let every so-manieth selected frame be annotated, beginning with the first one.

    Raises
    ------
    InputError
        Where the step is not at least 1.
    """
    if step < 1:
        raise InputError(
            f"cannot set a keyframe every {step} frames", remedy="Enter a number of at least 1."
        )
    return SetKeyframes(tuple(selection.frames[::step]))


def keyframes_done(project: Project, selection: Selection, *, done: bool = True) -> Edit:
    """Say of the selected keyframes that they are done, or that they are not.

    A single frame becomes a keyframe by that.

    Raises
    ------
    InputError
        Where no keyframe is selected.
    """
    frames = _keyframes(project, selection) or (
        (selection.frames.start,) if len(selection.frames) == 1 else ()
    )
    if not frames:
        raise _nothing(f"there are no keyframes in {frames_in_words(selection.frames)}")
    return SetKeyframes(frames, "done" if done else "wanted")


def no_keyframes(project: Project, selection: Selection) -> Edit:
    """Let the selected frames be no keyframes any more.

    Raises
    ------
    InputError
        Where none of them is one.
    """
    frames = _keyframes(project, selection)
    if not frames:
        raise _nothing(f"there are no keyframes in {frames_in_words(selection.frames)}")
    return SetKeyframes(frames, "none")


def gaps_of(project: Project) -> tuple[range, ...]:
    """Stretches of frames that are wholly marked as gaps, ascending."""
    frames = sorted({f.frame for f in project.marks.flags() if f.kind == GAP and not f.landmark})
    gaps: list[range] = []
    for frame in frames:
        if gaps and gaps[-1].stop == frame:
            gaps[-1] = range(gaps[-1].start, frame + 1)
        else:
            gaps.append(range(frame, frame + 1))
    return tuple(gaps)


def landmark_gaps_of(project: Project) -> dict[str, frozenset[int]]:
    """Frames in which a single landmark is marked as a gap, by landmark."""
    found: dict[str, set[int]] = {}
    for flag in project.marks.flags():
        if flag.kind == GAP and flag.landmark:
            found.setdefault(flag.landmark, set()).add(flag.frame)
    return {landmark: frozenset(frames) for landmark, frames in found.items()}


def _flags(selection: Selection, kind: str) -> tuple[FrameFlag, ...]:
    landmarks = selection.landmarks or ("",)
    return tuple(FrameFlag(frame, name, kind) for frame in selection.frames for name in landmarks)


def _present(project: Project, selection: Selection, kind: str) -> tuple[FrameFlag, ...]:
    """Flags of a kind that are selected; an empty kind means all but gaps."""
    found = tuple(
        flag
        for flag in project.marks.flags()
        if flag.frame in selection.frames
        and (flag.kind == kind if kind else flag.kind != GAP)
        and (not selection.landmarks or flag.landmark in selection.landmarks)
    )
    if not found:
        what = "marked as a gap" if kind == GAP else "flagged"
        raise _nothing(f"nothing is {what} in {selection.words()}")
    return found


def _keyframes(project: Project, selection: Selection) -> tuple[int, ...]:
    return tuple(one.frame for one in project.marks.keyframes() if one.frame in selection.frames)


def _nothing(what: str) -> InputError:
    return InputError(what, remedy="Select other frames in the timeline.")
