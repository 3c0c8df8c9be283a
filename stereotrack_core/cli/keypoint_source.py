"""Keypoints that ``--keypoints`` names: those of a project, or of a detector's file."""

from __future__ import annotations

from pathlib import Path

from stereotrack_core.cli.output import say
from stereotrack_core.cli.sources import open_project
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.parameters import Settings


def stated_keypoints(
    path: Path | None, recording: Recording, settings: Settings
) -> Keypoints | None:
    """What is in a project or in a detector's file; None where none is named.

    Raises InputError where there are none, or the settings' tracker does not use them.
    """
    if path is None:
        return None
    if settings.tracking.matching == "model_to_data":
        raise InputError(
            "this preset does not use keypoints",
            where="--keypoints",
            remedy="Choose --preset accurate or fast, or omit --keypoints.",
        )
    if path.suffix.lower() != SUFFIX:
        found = read_keypoints(KeypointSource(path, recording))
        if found.left_out:
            say(f"{path}: left out: {found.summary()}")
        return found.keypoints
    with open_project(path) as project:
        keypoints = project.keypoints.all()
    if not len(keypoints):
        raise InputError(
            "the project has no keypoints",
            where=str(path),
            remedy="Import them with `stereotrack import predictions`.",
        )
    say(f"{path}: {counted(len(keypoints), 'keypoint')} of {len(keypoints.cameras)} cameras")
    return keypoints
