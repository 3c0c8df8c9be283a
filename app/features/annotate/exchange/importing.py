"""Labels and references of files, on their way into a project."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording


@dataclass(frozen=True)
class LabelFile:
    """A file of another tool, and what it does not say itself.

    Attributes
    ----------
    path : Path
    camera : str or None
        Camera or view that its labels are of; None: as the file says.
    names : mapping
        From their landmarks to ours, where the names do not tell.
    """

    path: Path
    camera: str | None = None
    names: Mapping[str, str] = field(default_factory=dict)


def names_in(text: str) -> dict[str, str]:
    """Names as a person types them: ``left_wrist=left_hand, nose=head``.

    Raises
    ------
    InputError
        Where a part of it is no pair of names.
    """
    names = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        theirs, sign, ours = (one.strip() for one in part.partition("="))
        if not (sign and theirs and ours):
            raise InputError(
                f"{part!r} cannot be read",
                remedy="Write pairs as their_name=our_name, for example left_wrist=left_hand.",
            )
        names[theirs] = ours
    return names


def labels_of(
    file: LabelFile, project: Project, recording: Recording, frames: int | None
) -> tuple[tuple[Click, ...], tuple[InputError, ...]]:
    """The clicks of a file, and everything that is left out of it.

    Raises
    ------
    InputError
        Where it cannot be read at all.
    """
    landmarks = project.landmark_set().names
    unknown = [name for name in file.names.values() if name not in landmarks]
    if unknown:
        raise InputError(
            f"there is no landmark {unknown[0]!r} in the project",
            remedy=f"The landmarks are {', '.join(landmarks)}.",
        )
    source = LabelSource(file.path, recording, landmarks, file.camera, file.names or None)
    found = read_labels(source, frames)
    left_out = tuple(
        InputError(
            f"all labels of {name!r}: no landmark of this project corresponds to it",
            where=file.path.name,
            remedy=f"To import them, give {name}=... under the names.",
        )
        for name in found.left_out
    )
    return found.clicks, (*left_out, *found.problems)
