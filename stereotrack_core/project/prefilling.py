"""Keep predictions for what nobody has clicked, and let a person take a selection of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.annotation.prefill import unclicked
from stereotrack_core.project.click_edits import AcceptPredictions
from stereotrack_core.project.project import Project


@dataclass(frozen=True)
class Selection:
    """Which predictions are meant; empty collections and None mean all.

    Attributes
    ----------
    source : str
    frames : range or None
    cameras, landmarks : collection of str
    largest_sigma : float or None
        Pixels per axis; predictions that are less certain, or do not say it, are left out.
    """

    source: str
    frames: range | None = None
    cameras: Collection[str] = ()
    landmarks: Collection[str] = ()
    largest_sigma: float | None = None

    def holds(self, one: Prediction) -> bool:
        """Whether a prediction is meant."""
        sure = self.largest_sigma is None or (
            one.sigma is not None and one.sigma <= self.largest_sigma
        )
        return (
            sure
            and one.source == self.source
            and (self.frames is None or one.frame in self.frames)
            and (not self.cameras or one.camera in self.cameras)
            and (not self.landmarks or one.landmark in self.landmarks)
        )


def keep_predictions(
    project: Project,
    source: str,
    predictions: Iterable[Prediction],
    *,
    frames: range | None = None,
) -> int:
    """Let these be the predictions of a source, in these frames or altogether.

    Where a person has said anything (a click, that it is outside, that a click was wrong), none is
    kept. This is no edit: nothing of a person's changes, so there is nothing to undo.

    Returns
    -------
    int
        Number of those that were kept.

    Raises
    ------
    InputError
        Where the project cannot be written to.
    ValueError
        Where one of them is of another source.
    """
    kept = [
        one
        for one in unclicked(predictions, project.clicks.keys())
        if frames is None or one.frame in frames
    ]
    project.predictions.replace(source, kept, frames=frames)
    return len(kept)


def accept_selected(project: Project, selection: Selection) -> AcceptPredictions | None:
    """The edit that makes the selected predictions clicks; None where there are none to take.

    Places that a person has said anything about are left out.
    """
    said = project.clicks.keys()
    chosen = tuple(
        one
        for one in unclicked(project.predictions.of_source(selection.source), said)
        if selection.holds(one)
    )
    return AcceptPredictions(chosen) if chosen else None
