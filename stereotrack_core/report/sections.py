"""Sections of a report on a run, each a heading with what belongs below it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.doubts import CALLED, Doubts
from stereotrack_core.evaluation.episodes.episode import CAUSE_WORDS, FOUND_WORDS, limbs_words
from stereotrack_core.evaluation.joint_angles.ranges import StretchMotion
from stereotrack_core.evaluation.reference_quality import stated
from stereotrack_core.evaluation.summary import LOST_ANGLE, Summary, root_mean
from stereotrack_core.report.html import Html, heading, paragraph, picture
from stereotrack_core.report.reported import Accuracy, Reported, ShownEpisode
from stereotrack_core.report.tables import Row, number, table
from stereotrack_core.tracking.frame import Run

_DEGREES = 180.0 / math.pi
_MAIN = ("torso_long", "torso_cross", "upper_arms", "forearms")


def lead(reported: Reported) -> Html:
    """The most important in two or three sentences."""
    source = reported.source
    run = source.run
    tracked = int(run.tracked.sum())
    seconds = len(run.frame) / source.fps
    name = run.meta.get("recording") or "an unnamed recording"
    said = [
        f"Recording {name}, frames {run.frame[0]} to {run.frame[-1]} ({seconds:.0f} s at "
        f"{source.fps:g} per second), tracked with preset {run.meta.get('preset') or 'unknown'}: "
        f"{tracked} of {len(run.frame)} frames have a pose."
    ]
    accuracy = reported.accuracy
    if accuracy is not None:
        values = [
            f"{m.label} {stated(m.statistics.mean, m.unit, accuracy.quality, m.name)}"
            for m in accuracy.summary.measures
            if m.name in _MAIN
        ]
        said.append(f"Mean errors: {'; '.join(values)}.")
        said.append(f"{100.0 * accuracy.summary.lost:.1f} % of the arm segments are lost.")
    else:
        said.append("There is no reference, so errors are not known; the run's own signs follow.")
    count = len(reported.episodes)
    said.append(f"{count or 'No'} episode{'' if count == 1 else 's'} of failure found.")
    if run.meta.get("started_at_reference"):
        said.append("This run was begun at the reference's pose: it knows part of the truth.")
    return paragraph(" ".join(said), kind="lead")


def subject(reported: Reported) -> list[Html]:
    """The person's measured lengths."""
    lengths = reported.source.run.meta.get("subject")
    parts = [heading(2, "Subject", "subject")]
    if not lengths:
        return [*parts, paragraph("The recording states no subject; average lengths were used.")]
    name = lengths.get("name") or "no name given"
    known = {key.replace("_", " "): value for key, value in lengths.items() if key != "name"}
    values = ["average" if value is None else f"{1000.0 * value:.0f}" for value in known.values()]
    columns = ("", *(f">{key.removesuffix(' length')}" for key in known))
    return [*parts, paragraph(f"Name: {name}."), table(columns, [("length [mm]", *values)])]


def errors(reported: Reported) -> list[Html]:
    """Table of errors, with how good the reference is; and per segment."""
    parts = [heading(2, "Errors", "errors")]
    accuracy = reported.accuracy
    if accuracy is None:
        return [*parts, paragraph("No reference covers these frames, so errors are not known.")]
    good = bool(accuracy.quality)
    rows = []
    for measure in accuracy.summary.measures:
        figures = measure.statistics
        row = [f"{measure.label} [{measure.unit}]"]
        row += [number(value) for value in (figures.mean, figures.median, figures.p95)]
        row += [number(accuracy.quality.get(measure.name, float("nan")))] if good else []
        rows.append(Row(row))
    rows.append(Row(["arm segments lost [%]", number(100.0 * accuracy.summary.lost), "", ""]
                    + ([""] if good else [])))  # fmt: skip
    headings = ["", ">mean", ">median", ">95 %", *([">reference good to"] if good else [])]
    parts += [
        paragraph(
            f"Against {reported.source.reference_name}, over {accuracy.summary.frames} frames that "
            f"it knows; {accuracy.summary.not_tracked} of them are not tracked and count 90 "
            "degrees and 500 mm. Lost is an upper arm or forearm more than 45 degrees off."
        ),
        table(headings, rows),
    ]
    if accuracy.segments:
        parts += [heading(3, "By segment"), _segment_table(accuracy.segments)]
    return parts


def reference(reported: Reported) -> list[Html]:
    """How good the reference says that it is."""
    source = reported.source
    if source.reference is None:
        return []
    parts = [heading(2, "The reference and its uncertainty", "reference")]
    states = source.states
    if states is None:
        return [
            *parts,
            paragraph(
                f"{source.reference_name[:1].upper()}{source.reference_name[1:]} states no "
                "uncertainty of its own: errors smaller than what it is good to say nothing, and "
                "how large that is has to be known from elsewhere. A reference that is fitted to "
                "clicks states it."
            ),
        ]
    inside = np.isin(states.frame, source.run.frame)
    filled = 0 if states.filled is None else int(states.filled[inside].sum())
    parts.append(
        paragraph(
            f"{int(inside.sum())} frames, of which {filled} were not annotated but filled in "
            "between annotated ones."
        )
    )
    if states.limb_sigma_deg is not None:
        sigma = states.limb_sigma_deg[inside]
        rows = [
            (
                limb.replace("_", " "),
                number(root_mean(np.square(sigma[:, i]))),
                number(float(np.fmax.reduce(sigma[:, i], initial=np.nan))),
            )
            for i, limb in enumerate(LIMBS)
        ]
        parts.append(table(("limb", ">good to [deg]", ">worst frame [deg]"), rows))
    return parts


def honesty(reported: Reported) -> list[Html]:
    """What the run says itself about lost limbs, and whether that is right."""
    run, accuracy = reported.source.run, reported.accuracy
    parts = [heading(2, "What the run says about itself", "honesty")]
    known = np.isfinite(run.limb_lost)
    if not known.any():
        return [*parts, paragraph("This run does not say which limbs it takes for lost.")]
    rows = []
    for i, limb in enumerate(LIMBS):
        if known[:, i].any():
            share = 100.0 * float((run.limb_lost[known[:, i], i] > CALLED).mean())
            sigma = root_mean(np.square(run.limb_sigma_deg[run.tracked, i]))
            rows.append((limb.replace("_", " "), number(share), number(sigma)))
    parts.append(table(("limb", ">called lost [% of frames]", ">stated error [deg]"), rows))
    if accuracy is not None and accuracy.doubts is not None:
        parts.append(paragraph(_doubts_in_words(accuracy.doubts)))
        parts.append(paragraph(_within_two(run, accuracy)))
    return parts


def episodes(reported: Reported) -> list[Html]:
    """Stretches in which limbs fail, with pictures of the longest."""
    parts = [heading(2, "Episodes of failure", "episodes")]
    if not reported.episodes:
        return [*parts, paragraph("None: no limb fails for as long as counts as an episode.")]
    fps = reported.source.fps
    rows = []
    for shown in reported.episodes:
        episode = shown.episode
        sure = episode.verdict.confidence
        rows.append(
            (
                f"{episode.first}–{episode.last}",
                f"{episode.first / fps:.1f}–{(episode.last + 1) / fps:.1f} s",
                limbs_words(episode.limbs),
                episode.peak_words,
                CAUSE_WORDS[episode.verdict.cause] + (f" ({100.0 * sure:.0f} %)" if sure else ""),
            )
        )
    found = FOUND_WORDS[reported.episodes[0].episode.found]
    parts += [
        paragraph(f"Found {found}; causes are probable ones, with how sure they are."),
        table(("frames", "time", "limbs", ">peak", "probable cause"), rows),
    ]
    return [*parts, *(_strip(shown) for shown in reported.episodes if shown.strip is not None)]


def motion(reported: Reported) -> list[Html]:
    """Range of motion of the joints, and left against right."""
    whole = reported.motions[0]
    rows = [
        (
            one.angle.words,
            *(
                number(_DEGREES * value)
                for value in (
                    one.minimum, one.maximum, one.range, one.range_sigma, one.mean,
                    one.peak_velocity,
                )
            ),
        )
        for one in whole.ranges
        if one.frames
    ]  # fmt: skip
    parts = [heading(2, "Range of motion", "motion")]
    if not rows:
        return [*parts, paragraph("No stretch of frames is long enough to tell.")]
    headings = ("angle", ">from", ">to", ">range", ">±", ">mean", ">peak speed [deg/s]")
    return [
        *parts,
        paragraph(f"Joint angles after the ISB recommendations, in degrees. {reported.smoothing}"),
        table(headings, rows),
        heading(3, "Left against right"),
        _sides(reported.motions),
    ]


def _segment_table(segments: Sequence[Summary]) -> Html:
    headings = (
        *("segment", ">frames", ">torso [mm]", ">long axis", ">cross axis", ">upper arms"),
        *(">forearms", ">lost [%]"),
    )
    rows = [
        (
            one.name,
            str(one.frames),
            *(number(measure.statistics.mean) for measure in one.measures[:5]),
            number(100.0 * one.lost),
        )
        for one in segments
    ]
    return table(headings, rows)


def _doubts_in_words(doubts: Doubts) -> str:
    called = f"The run calls {doubts.called} of {doubts.judged} arm segments lost"
    right = f"; {doubts.both} of these are" if doubts.called else ""
    return f"{called}{right}. {doubts.lost} are lost, of which it says so for {doubts.both}."


def _within_two(run: Run, accuracy: Accuracy) -> str:
    """Share of errors within twice the stated error, limbs that are lost left out."""
    found = accuracy.errors
    _, own, other = np.intersect1d(run.frame, found.frame, return_indices=True)
    shares = []
    for i, limb in enumerate(LIMBS):
        degrees, sigma = np.degrees(found.of_limb(limb))[other], run.limb_sigma_deg[own, i]
        known = np.isfinite(degrees) & np.isfinite(sigma) & (degrees <= np.degrees(LOST_ANGLE))
        if known.any():
            share = 100.0 * float((degrees[known] <= 2.0 * sigma[known]).mean())
            shares.append(f"{limb.replace('_', ' ')} {share:.0f} %")
    told = ", ".join(shares) or "the run states none where the reference knows"
    return f"Errors within twice what the run states, lost limbs left out: {told}."


def _strip(shown: ShownEpisode) -> Html:
    episode = shown.episode
    words = limbs_words(episode.limbs)
    caption = f"Frames {episode.first} to {episode.last}, {words}: {episode.verdict.words}."
    return picture(shown.strip or b"", "jpeg", f"Episode of {words}", caption)


def _sides(motions: Sequence[StretchMotion]) -> Html:
    rows = [
        (
            "all frames" if stretch.name == "all" else stretch.name,
            side.left.angle.label,
            *(
                number(_DEGREES * value)
                for value in (
                    side.left.range, side.right.range, side.difference, side.difference_sigma
                )
            ),
        )
        for stretch in motions
        for side in stretch.sides
        if side.left.frames and side.right.frames
    ]  # fmt: skip
    return table(("stretch", "range of", ">left", ">right", ">left − right", ">±"), rows)
