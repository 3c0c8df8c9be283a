"""Flags on frames, frames that shall be annotated, and cameras that are left out."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stereotrack_core.project.connection import Access
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.schema import CAMERA_USE, FRAME_FLAG, KEYFRAME, Row

GAP, REVIEW = "gap", "review"  # flags: nothing is interpolated there; to be looked at again


@dataclass(frozen=True)
class FrameFlag:
    """A flag on a frame, for one landmark or, without its name, for the whole frame."""

    frame: int
    landmark: str = ""  # empty: the whole frame
    kind: str = REVIEW  # :data:`GAP`, :data:`REVIEW`, or any other word


@dataclass(frozen=True)
class Keyframe:
    """A frame that shall be annotated, or has been."""

    frame: int
    done: bool = False


class Marks:
    """Read flags and keyframes."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def flags(self) -> tuple[FrameFlag, ...]:
        """Flags of all frames, by frame."""
        rows = self._access.rows(
            "SELECT frame, landmark, kind FROM frame_flag"
            " WHERE deleted = 0 ORDER BY frame, landmark"
        )
        return tuple(FrameFlag(*row) for row in rows)

    def keyframes(self) -> tuple[Keyframe, ...]:
        """Keyframes, ascending."""
        rows = self._access.rows(
            "SELECT frame, done FROM keyframe WHERE deleted = 0 ORDER BY frame"
        )
        return tuple(Keyframe(frame, bool(done)) for frame, done in rows)

    def unused_cameras(self) -> frozenset[str]:
        """Cameras that are left out of triangulation, fit and export."""
        rows = self._access.rows("SELECT camera FROM camera_use WHERE used = 0 AND deleted = 0")
        return frozenset(camera for (camera,) in rows)


def use_camera(camera: str, *, used: bool) -> Edit:
    """Leave a camera out of triangulation, fit and export, or use it again; clicks stay."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        before = state.row(CAMERA_USE, (camera,))
        if (before is None or bool(before[0])) != used:
            yield Change(CAMERA_USE, (camera,), before, (int(used), stamp.who, stamp.at, 0))

    return Edit("use camera", f"{'use' if used else 'leave out'} camera {camera}", changes)


def flag_frames(flags: Sequence[FrameFlag], *, off: bool = False) -> Edit:
    """Flag frames or landmarks of them; or, with `off`, take these flags away."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        for flag in flags:
            key: Row = (flag.frame, flag.landmark, flag.kind)
            before = state.row(FRAME_FLAG, key)
            if off == (before is not None and not before[-1]):
                note = "" if before is None else before[0]  # of files by others; nobody shows it
                yield Change(FRAME_FLAG, key, before, (note, stamp.who, stamp.at, int(off)))

    first = flags[0]
    what = f"{first.landmark.replace('_', ' ')}, " if first.landmark else ""
    more = f" and {len(flags) - 1} more" if len(flags) > 1 else ""
    verb = "unflag" if off else "flag"
    return Edit("flag", f"{verb} {what}frame {first.frame}{more}, as {first.kind}", changes)


def mark_keyframes(frames: Sequence[int], state: str = "wanted") -> Edit:
    """Say of frames that they shall be annotated (``wanted``), are ``done``, or ``none``."""
    done, deleted = int(state == "done"), int(state == "none")

    def changes(project: State, stamp: Stamp) -> Iterable[Change]:
        for frame in frames:
            before = project.row(KEYFRAME, (frame,))
            if before is None and deleted:
                continue
            if before is not None and (before[0], before[-1]) == (done, deleted):
                continue
            yield Change(KEYFRAME, (frame,), before, (done, stamp.who, stamp.at, deleted))

    what = f"frame {frames[0]}" if len(frames) == 1 else f"{len(frames)} frames"
    said = {"wanted": "to annotate", "done": "done", "none": "not a keyframe"}[state]
    return Edit("keyframes", f"mark {what}: {said}", changes)
