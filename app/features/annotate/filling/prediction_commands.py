"""Commands that fill the selection in with predictions, and that take them as clicks."""

from __future__ import annotations

from functools import partial

from ....services.actions import Command
from .predicting import PredictionWork, Source

_FILL: tuple[tuple[Source, str, str], ...] = (
    ("fit", "Fill in from the fit", "Propose, over the selected frames, where the body fitted to "
     "the clicks lies in every view; nothing is clicked by that."),
    ("run", "Fill in from the active run", "Propose, over the selected frames, what the tracker's "
     "active run found; nothing is clicked by that."),
    ("neighbours", "Fill in from neighbours", "Propose, over the selected frames, places straight "
     "between two clicks in the same view; nothing is clicked by that."),
)  # fmt: skip

_ACCEPT: tuple[tuple[Source, str, str, str], ...] = (
    ("following", "annotate-accept", "Accept what was followed", "following has found"),
    ("fit", "annotate-accept-fit", "Accept what the fit says", "was filled in from the fit"),
    ("run", "annotate-accept-run", "Accept what the active run says",
     "was filled in from the tracker's active run"),
    ("neighbours", "annotate-accept-neighbours", "Accept what neighbours say",
     "was filled in from neighbouring clicks"),
)  # fmt: skip


def prediction_commands(work: PredictionWork, menu: str) -> list[Command]:
    """All of them, in the order of their menu."""

    def named(words: str) -> str:
        """``Fill in from run “2: accurate”``, where there is one."""
        name = "" if work.run is None else f"run “{work.run.name}”"
        return words.replace("the active run", name) if name else words

    fill = [
        Command(
            f"annotate-fill-{source}", menu, text, tip, partial(work.fill, source),
            icon="prediction", why_not=partial(work.why_not, source), says=partial(named, text),
        )
        for source, text, tip in _FILL
    ]  # fmt: skip
    accept = [
        Command(
            name, menu, text, f"Make clicks of what {what} in the selection, as one edit; no click "
            "of yours changes.", partial(work.accept, source), icon="accept",
            why_not=partial(work.why_no_accept, source), says=partial(named, text),
            section=source == "following",
        )
        for source, name, text, what in _ACCEPT
    ]  # fmt: skip
    follow = Command(
        "annotate-follow", menu, "Follow the patch", "Follow the image around clicks over the "
        "selected frames; what is found is proposed, not clicked.", work.follow,
        icon="prediction", why_not=partial(work.why_not, "following"),
    )  # fmt: skip
    return [follow, *fill, *accept]
