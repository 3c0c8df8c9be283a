"""Take predictions for clicks, because a person says so."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.project.click_rows import click_in, place_in_words, values_of
from stereotrack_core.project.edit import Edit, Stamp, State
from stereotrack_core.project.rows import Change
from stereotrack_core.project.schema import CLICK


@dataclass(frozen=True)
class AcceptPredictions(Edit):
    """Let predictions be clicks, noted as accepted; where a person has clicked, that click stays.

    Attributes
    ----------
    predictions : tuple of Prediction
        Of several for one landmark in one image the last one counts.
    even_deleted : bool
        Also where somebody has taken a click away; for a single prediction that was looked at.
    """

    kind: ClassVar[str] = "accept predictions"
    predictions: tuple[Prediction, ...]
    even_deleted: bool = False

    def words(self) -> str:
        """``accept left elbow in N_right, frame 213``."""
        return f"accept {place_in_words([one.key for one in self.predictions])}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of landmarks that nobody has clicked."""
        for prediction in self.predictions:
            before = state.row(CLICK, prediction.key)
            if before is not None:
                there = click_in(prediction.key, before)
                if not (there.deleted and self.even_deleted):
                    continue
            click = Click(*prediction.key, prediction.position, origin="accepted")
            yield Change(CLICK, prediction.key, before, values_of(click, stamp))
