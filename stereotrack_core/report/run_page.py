"""The report on a run as a page."""

from __future__ import annotations

from stereotrack_core.report import origin, sections
from stereotrack_core.report.curves import limb_curves
from stereotrack_core.report.drawing import Kind, mime
from stereotrack_core.report.html import Html, document, heading, picture
from stereotrack_core.report.reported import Reported


def run_page(reported: Reported, kind: Kind = "svg", *, for_print: bool = False) -> str:
    """The whole report as HTML.

    Parameters
    ----------
    reported : Reported
    kind : "svg" or "png"
        Of the curves.
    for_print : bool
        With a plain style that simple renderers understand.
    """
    title = f"Report on {reported.source.name}"
    parts: list[Html] = [
        heading(1, title),
        sections.lead(reported),
        *origin.recording(reported),
        *sections.subject(reported),
        *origin.calibration(reported),
        *sections.errors(reported),
        *_curves(reported, kind),
        *sections.episodes(reported),
        *sections.honesty(reported),
        *sections.motion(reported),
        *sections.reference(reported),
        *origin.parameters(reported),
        *origin.made(reported),
    ]
    return document(title, *parts, for_print=for_print)


def _curves(reported: Reported, kind: Kind) -> list[Html]:
    accuracy, run = reported.accuracy, reported.source.run
    errors = None if accuracy is None else accuracy.errors
    episodes = [shown.episode for shown in reported.episodes]
    drawn = limb_curves(run, errors, episodes, reported.segments, kind)
    caption = (
        "Error of each limb's direction in its colour; grey: what the run states as its standard "
        "deviation; dotted: 45 degrees; shaded: episodes."
        if errors is not None
        else "What the run states as the standard deviation of each limb's direction; dashed: the "
        "probability that the limb is lost; shaded: episodes."
    )
    return [
        heading(2, "Curves", "curves", "new-page"),
        picture(drawn, mime(kind), "Curves of every limb over the frames", caption),
    ]
