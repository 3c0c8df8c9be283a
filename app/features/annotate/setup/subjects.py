"""A project's subjects: their lengths entered, measured from clicks, saved and reused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from stereotrack_core.annotation.click_points import (
    MeasuredLength,
    click_pixels,
    measured_lengths,
    subject_of,
)
from stereotrack_core.body.proportions import AVERAGE, proportions_of
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.entries import Choose, DeleteEntry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import SUBJECT
from stereotrack_core.project.setups import load_subject, save_subject
from stereotrack_core.recording.description import LENGTHS, Subject, read_subject

LENGTH_WORDS: Mapping[str, tuple[str, str]] = {
    "shoulder_width": ("Shoulder width", "between the joint centres of both shoulders"),
    "hip_width": ("Hip width", "between the joint centres of both hips"),
    "torso_length": ("Torso", "from the middle of the hips to the middle of the shoulders"),
    "upper_arm_length": ("Upper arm", "from shoulder to elbow"),
    "forearm_length": ("Forearm", "from elbow to wrist"),
    "hand_length": ("Hand", "from the wrist to the tip of the middle finger"),
    "shoulder_to_head": ("Head", "from the middle of the shoulders to the head's landmark"),
}
"""What each length is called, and what it lies between."""

_LEAST, _MOST = 0.5, 1.8
"""Against an average person of the same size; what lies outside is probably a slip."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Lengths measured from clicks.

    Attributes
    ----------
    subject : Subject
        The lengths that are known, without a name.
    lengths : mapping from str to MeasuredLength
        As they were measured; elbow to hand instead of forearm and hand.
    """

    subject: Subject
    lengths: Mapping[str, MeasuredLength]

    def words(self, key: str) -> str:
        """``331 ± 2 mm, 240 samples``; empty where it is not known."""
        length = getattr(self.subject, key)
        if length is None:
            return ""
        shared = key in ("forearm_length", "hand_length")
        own = self.lengths["elbow_to_hand" if shared else key]
        return f"{1000 * length:.0f} ± {1000 * own.sigma:.0f} mm, {own.count} samples"


class Subjects:
    """The subjects of a project; every change is an edit.

    Parameters
    ----------
    project : Project
    cameras : mapping from camera name to Camera
    recorded : Subject or None
        Of the recording's folder.
    """

    def __init__(
        self, project: Project, cameras: Mapping[str, Camera], recorded: Subject | None
    ) -> None:
        self._project, self._cameras, self.recorded = project, cameras, recorded

    @property
    def read_only(self) -> bool:
        """Whether nothing can be saved."""
        return self._project.read_only

    def names(self) -> tuple[str, ...]:
        """Subjects of the project."""
        return self._project.subjects.names()

    def used(self) -> str | None:
        """The subject that the project uses; None: the recording's."""
        return self._project.chosen(self._project.subjects)

    def get(self, name: str) -> Subject:
        """A subject of the project."""
        return load_subject(self._project.subjects, name)

    def measure(self) -> Measured:
        """Measure the lengths from all clicks.

        Raises
        ------
        InputError
            Where too little is clicked.
        """
        names = self._project.landmark_set().names
        pixels = click_pixels(self._project.clicks.all(), self._cameras, names)
        lengths = measured_lengths(pixels)
        if not lengths:
            raise InputError(
                "too few clicks to measure a length",
                where=self._project.path.name,
                remedy="Click both ends of a limb in at least two views of three frames.",
            )
        return Measured(subject_of("", lengths), lengths)

    def save_and_use(self, subject: Subject, *, origin: str = "entered") -> None:
        """Keep a subject under its name, and use it from now on.

        Raises
        ------
        InputError
            Where it has no name, or cannot be saved.
        """
        if not subject.name.strip():
            raise InputError("the subject has no name", remedy="Give it one.")
        self._project.apply(save_subject(subject, origin=origin))
        if self.used() != subject.name:
            self._project.apply(Choose(SUBJECT.name, subject.name))

    def use(self, name: str | None) -> None:
        """Use another subject; None: the recording's."""
        if self.used() != name:
            self._project.apply(Choose(SUBJECT.name, name))

    def delete(self, name: str) -> None:
        """Take a subject away; that can be undone."""
        if self.used() == name:
            self.use(None)
        self._project.apply(DeleteEntry(SUBJECT.name, name))


def average_of(subject: Subject) -> dict[str, float]:
    """Lengths in metres that an average person of this one's size has."""
    whole = asdict(proportions_of(subject))
    known = [key for key in LENGTHS if getattr(subject, key) is not None]
    average = asdict(AVERAGE)
    if not known:
        return {key: average[key] for key in LENGTHS}
    scale = sum(whole[key] for key in known) / sum(average[key] for key in known)
    return {key: scale * average[key] for key in LENGTHS}


def doubts_about(subject: Subject) -> tuple[str, ...]:
    """Lengths that nobody of this size has, in words."""
    average = average_of(subject)
    said = []
    for key in LENGTHS:
        length = getattr(subject, key)
        if length is not None and not _LEAST < length / average[key] < _MOST:
            said.append(
                f"{LENGTH_WORDS[key][0]}: {1000 * length:.0f} mm; a person of this size has about "
                f"{1000 * average[key]:.0f} mm. Measure it again."
            )
    return tuple(said)


def read_subject_file(path: Path) -> Subject:
    """The subject of a file; one without a name gets the file's.

    Raises
    ------
    InputError
        At the first thing that is wrong.
    """
    subject = read_subject(path)
    values = asdict(subject)
    return Subject(**{**values, "name": subject.name or path.stem})
