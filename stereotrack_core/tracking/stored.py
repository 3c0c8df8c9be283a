"""What a run states about itself: of which kinds its values are; its body and its poses."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from stereotrack_core.body.angles import pose_of_state, state_of_pose
from stereotrack_core.body.model import BodyModel, body_of_subject
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.upright import UP_AXES, Z_UP, Upright
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.description import LENGTHS, Subject, subject_in
from stereotrack_core.recording.frame_times import stated_fps
from stereotrack_core.tracking.frame import (
    DETECTED_SCENES,
    LOOKED_AGAIN,
    FirstFrame,
    Run,
    joints_named,
)

_VALUES: Kind = {str: (bool, int, float, str)}

_POSE: Kind = {"position": [float], "rotations": [[[float]]]}

# What :class:`Origin` and its users state; other keys may hold anything.
_META_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        **dict.fromkeys(("program", "version", "preset", "init", "made", "way"), str),
        **dict.fromkeys(("recording", "recording_folder", "recording_folder_from_run"), str),
        **dict.fromkeys(("fingerprint", "calibration", "detector"), str),
        **dict.fromkeys(("smoothed", "colour", "incomplete"), bool),
        **dict.fromkeys(("fps", "wall_seconds"), float),
        "parameters": _VALUES,
        "body": _VALUES,
        **dict.fromkeys(("seed", "format"), int),
        "views": [str],
        DETECTED_SCENES: [str],
        "subject": {"name": str, **dict.fromkeys(LENGTHS, float), "offsets": {str: [float]}},
        "bridged": [int],
        "first_pose": _POSE,
        "began_from": _POSE,
        "began": int,
        "frames": [int, int],
        "keypoints": {"sources": [str], "fingerprint": str, "count": int},
        "detections": {"source": str, "fingerprint": str, "count": int},
        "clicks": {"source": str, "fingerprint": str, "count": int},
        "repaired": [int],
        LOOKED_AGAIN: [[int, int]],
        "heading": {"state": str, "probability": float, "frames": int, "against": int},
        "blind": [{"view": str, "first": int, "end": int, "reason": str}],
        "versions": {str: str},
        "resumed_at": [int],
        "from_recording": _VALUES,
        "started_at_reference": [int],
        "warnings": [str],
    }
)
# Keys that are stated although nothing is known.
_MAY_BE_NULL = frozenset(
    ("heading", "subject", "first_pose", "began", "began_from", "frames", "wall_seconds")
    + ("detections", "keypoints", "clicks")
)


def check_meta(meta: Any, where: str, remedy: str) -> None:
    """Refuse what cannot be the meta of a run; the InputError names the key."""
    check_kind(meta, _META_KINDS, where, remedy)
    for key in sorted(_META_KINDS.keys() - _MAY_BE_NULL):
        if key in meta and meta[key] is None:
            raise InputError("the value is missing", where=f"{where}, {key}", remedy=remedy)
    for key, read in (("subject", subject_of_meta), ("body", shape_of_meta)):
        try:
            read(meta)
        except InputError as problem:
            place = problem.where if key == "subject" else key
            raise InputError(problem.what, where=f"{where}, {place}", remedy=remedy) from None


def pose_of_run(run: Run, i: int) -> Pose | None:
    """Pose of a run's i-th frame, None where it is not tracked; InputError for other states."""
    if not run.tracked[i]:
        return None
    joints = joints_named(run.state_names)
    if joints is None:
        raise InputError(
            "the states do not fit the body model",
            where="state_names",
            remedy="Track the recording again with this version.",
        )
    return pose_of_state(run.x[i], joints)


def up_of_meta(meta: Mapping[str, Any]) -> Upright:
    """Which axis of a run's world points up; z where its meta does not say."""
    stated = meta.get("from_recording", {}).get("up_axis")
    axis = stated or meta.get("parameters", {}).get("up_axis", "auto")
    return Upright(axis) if axis in UP_AXES else Z_UP


def upright_run(run: Run) -> Run:
    """The run in a world whose z points up, as joint angles and many formats presume."""
    upright = up_of_meta(run.meta)
    if upright == Z_UP:
        return run
    x, P, joints = run.x, run.P, joints_named(run.state_names)
    if joints is not None:
        x = state_of_pose(pose_of_state(run.x, joints).turned(upright.rotation), joints)
        turn = np.eye(P.shape[-1])
        turn[:3, :3] = turn[3:6, 3:6] = upright.rotation
        P = turn @ P @ turn.T
    return replace(run, landmarks=upright.points(run.landmarks), x=x, P=P)


def fps_of_run(run: Run) -> float:
    """Frames per second that the run's meta states; InputError if it states none."""
    fps = stated_fps(run.meta)
    if fps is None:
        raise InputError(
            "the run does not state its frame rate",
            where="meta, fps",
            remedy="Give its recording, export as .csv (which needs no frame rate), or track "
            "again.",
        )
    return fps


def body_of_run(run: Run) -> BodyModel:
    """Body that a run was tracked with: its subject and its shape parameters."""
    return body_of_subject(subject_of_meta(run.meta), shape_of_meta(run.meta))


def subject_of_meta(meta: Mapping[str, Any]) -> Subject | None:
    """Whose body was tracked; InputError where its lengths are impossible."""
    stored = meta.get("subject")
    if not isinstance(stored, dict):
        return None
    return subject_in({key: value for key, value in stored.items() if value != ""}, "subject")


def shape_of_meta(meta: Mapping[str, Any]) -> BodyShape:
    """Shape of the body that was tracked."""
    return BodyShape().replaced(**meta.get("body", {}))


def began_of(meta: Mapping[str, Any]) -> FirstFrame | None:
    """Where a run began; None if nobody was there, and for runs of older versions."""
    stored = meta.get("began_from")
    if not isinstance(stored, dict):
        return None
    return FirstFrame(int(meta["began"]), pose_of_values(stored))


def pose_of_values(stored: Mapping[str, Any]) -> Pose:
    """Pose in a run's meta; InputError if it is none of this version's body."""
    try:
        rotations = np.array(stored.get("rotations"), dtype=np.float64)
    except ValueError:  # lists of different lengths
        rotations = np.empty(0)
    pose = Pose(np.array(stored.get("position"), dtype=np.float64), rotations)
    if pose.position.shape != (3,) or pose.rotations.shape != (len(PARTS), 3, 3):
        raise InputError(
            "the initial pose does not fit this version's body model",
            where="first_pose",
            remedy="Track the recording again with this version.",
        )
    return pose
