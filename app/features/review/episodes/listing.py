"""Which episodes are listed, and as what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.evaluation.episodes.episode import (
    CAUSE_WORDS,
    FOUND_WORDS,
    Episode,
    limbs_words,
)

from ....widgets.tables.episodes_panel import EpisodeRow
from ....widgets.timeline.lanes import Lane, Span

FOUND_SHORT = {"truth": "error", "signs": "signs"}
LANE_NAMES = {"truth": "episodes", "signs": "failures (without reference)"}
LANE_COLOURS = {"truth": "#CC79A7", "signs": "#b8860b"}


@dataclass(frozen=True)
class Filter:
    """What is listed; an empty word lists all."""

    limb: str = ""
    """Name in ``LIMBS``."""
    cause: str = ""
    """Key of ``CAUSE_WORDS``."""
    found: str = ""
    """Key of ``FOUND_WORDS``."""

    def takes(self, episode: Episode) -> bool:
        """Whether an episode is listed."""
        return (
            (not self.limb or self.limb in episode.limbs)
            and (not self.cause or self.cause == episode.verdict.cause)
            and (not self.found or self.found == episode.found)
        )


def row_of(episode: Episode, fps: float) -> EpisodeRow:
    """An episode as the list shows it."""
    seconds = len(episode.frames) / fps
    verdict = episode.verdict
    return EpisodeRow(
        first=episode.first,
        last=episode.last,
        limb=episode.peak_limb,
        limbs=limbs_words(episode.limbs),
        peak=episode.peak_words,
        peak_value=episode.peak,
        cause=CAUSE_WORDS[verdict.cause],
        confidence=verdict.confidence,
        found=FOUND_SHORT[episode.found],
        heading=(
            f"Frames {episode.first} to {episode.last} ({seconds:.1f} s), detected "
            f"{FOUND_WORDS[episode.found]}: {limbs_words(episode.limbs)}, worst in frame "
            f"{episode.peak_frame} with "
            f"{episode.peak_words}{'' if episode.measure == 'error' else ' failure probability'}."
        ),
        evidence=tuple(
            (CAUSE_WORDS[e.cause], e.strength, e.words, e.cause == verdict.cause)
            for e in verdict.evidence
        ),
    )


def lanes_of_episodes(episodes: Sequence[Episode]) -> tuple[Lane, ...]:
    """A lane of bars for those found with truth and for those found without."""
    lanes = []
    for found, name in LANE_NAMES.items():
        spans: list[Span] = []
        for e in sorted((e for e in episodes if e.found == found), key=lambda e: e.first):
            label = f"{limbs_words(e.limbs)}: {CAUSE_WORDS[e.verdict.cause]}"
            if spans and e.first <= spans[-1].last:
                # labels of bars that overlap would stand on each other
                old = spans.pop()
                spans.append(Span(old.first, max(old.last, e.last), f"{old.label}; {label}"))
            else:
                spans.append(Span(e.first, e.last, label))
        if spans:
            lanes.append(Lane(name, LANE_COLOURS[found], "bars", spans))
    return tuple(lanes)
