"""Facts about the clicks of a frame become rows of the landmarks and body panels."""

from collections.abc import Sequence
from math import isfinite, sqrt

import numpy as np

from stereotrack_core.annotation.click import UNCERTAIN, USUAL_SIGMA, Click, Visibility
from stereotrack_core.annotation.doubts import what_disagrees, what_to_do
from stereotrack_core.annotation.fit.results import outlier_words
from stereotrack_core.annotation.frame_clicks import ShownFit
from stereotrack_core.annotation.landmark_set import Landmark
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import UNKNOWN_DEG

from ....widgets.style.colours import LIMB_COLOURS, limb_words
from ....widgets.tables.landmarks_panel import CELL_WORDS, CellState
from ....widgets.tables.table import Cell, CellRow
from .marks import FEWEST, FrameMarks, predictions_in

_KEYS = 9
_OUTLIER = "The fit treats a click of this landmark as an outlier.", "warning"  # tip and colour
_MOST_WORDS = 2
_UNSURE_DEG = 10.0
_MISFIT = 8.0
"""Usual sigmas that the clicks are off in the median from which the fit is called wrong."""


def landmark_rows(facts: FrameMarks, cameras: Sequence[str]) -> tuple[CellRow, ...]:
    """Every landmark of the set, with its state in these cameras."""
    there = {(click.camera, click.landmark): click for click in facts.clicks}
    seen = {(one, p.landmark) for one in cameras for p in predictions_in(facts, one)}

    def cell(camera: str, landmark: Landmark) -> Cell:
        place = camera, landmark.name
        state = _state(there.get(place), predicted=place in seen)
        said = f"{landmark.label} in {facts.views.get(camera, camera)}: {CELL_WORDS[state]}"
        return Cell(tip=said, said=said, value=(landmark.colour, state))

    def row(place: int, landmark: Landmark) -> CellRow:
        shown = _OUTLIER if _is_outlier(facts, landmark.name) else ("", "")
        return (
            Cell(str(place) if place <= _KEYS else "", value=landmark.colour),
            Cell(landmark.label),
            *(cell(camera, landmark) for camera in cameras),
            Cell(_residual(facts, landmark.name), *shown),
            Cell(f"{_distance(facts, landmark.name)} ", *shown),
        )

    return tuple(row(*each) for each in enumerate(facts.landmark_set.landmarks, start=1))


def limb_rows(facts: FrameMarks) -> tuple[CellRow, ...]:
    """How well the clicks fix every limb's direction; nothing without a fit."""
    if facts.fit is None:
        return ()
    names, rows = facts.landmark_set.names, list[CellRow]()
    astray = {facts.landmark_set[name].limb for name in names if _is_outlier(facts, name)}
    for limb, sigma in zip(LIMBS, facts.fit.fit.limb_sigma_deg.tolist(), strict=True):
        value = f"± {sigma:.1f}°" if sigma <= UNKNOWN_DEG else "unknown"
        words = "possible outlier" if limb in astray else _precision(sigma)
        doubtful: bool | None = limb in astray or sigma > _UNSURE_DEG
        if facts.fit_is_old:
            words, doubtful = "before the last click", None
        rows.append(_body_cells(limb, limb_words(limb), value, words, doubtful))
    return tuple(rows)


def camera_rows(facts: FrameMarks) -> tuple[CellRow, ...]:
    """How far the clicks of each view lie from the points that the views agree on, any frame."""
    doubtful = () if facts.doubtful is None else facts.doubtful.doubtful
    rows = list[CellRow]()
    for one in facts.residuals:
        if isfinite(one.median_px):
            bad = one.camera in doubtful
            words = "disagrees with the others" if bad else f"residual of {one.count} clicks"
            name = facts.views.get(one.camera, one.camera)
            rows.append(_body_cells("", name, f"{one.median_px:.1f} px", words, bad))
    return tuple(rows)


def length_rows(facts: FrameMarks) -> tuple[CellRow, ...]:
    """Clicked lengths beside the subject's."""
    rows = list[CellRow]()
    for one in () if facts.hints is None else facts.hints.lengths:
        clicked, own, sigma = (1000.0 * x for x in (one.clicked, one.subject, one.sigma))
        words = f"{clicked - own:+z.0f} ± {sigma:.0f}, subject {own:.0f}"
        rows.append(_body_cells("", one.name, f"{clicked:.0f} mm", words, one.doubtful))
    return tuple(rows)


def _body_cells(limb: str, label: str, value: str, words: str, doubtful: bool | None) -> CellRow:
    """A row of the body panel; `doubtful` is None for outdated values."""
    colour = "muted" if doubtful is None else "warning" if doubtful else "text"
    name = Cell(label, swatch=LIMB_COLOURS.get(limb))
    return name, Cell(value, colour=colour), Cell(words, words, "muted")


def fit_words(facts: FrameMarks) -> tuple[str, ...]:
    """What the fit says, the most important first; or what it waits for."""
    found = facts.doubtful
    if facts.fit is not None:
        said = (*_misfit(facts.fit), *_frame_words(facts, facts.fit))
        if found is not None:  # the rest follows from the camera that contradicts the others
            said = (f"{what_disagrees(found, facts.views)}. {what_to_do(found)}", *said)
        more = len(said) - _MOST_WORDS
        return (*said[:_MOST_WORDS], f"and {more} more") if more > 0 else said
    positions = sum(click.position is not None for click in facts.clicks)
    if positions >= FEWEST:
        return ("Fitting the body to the clicks …",)
    if positions:
        return ("Click at least three landmarks to fit the body.",)
    return ("Click landmarks to fit the body. Keys 1 to 9 select a landmark.",)


def _frame_words(facts: FrameMarks, fit: ShownFit) -> tuple[str, ...]:
    """Remarks of the fit, without those that a contradicting camera causes."""
    blamed = set()
    for key in facts.flagged - facts.outliers:
        view, away = facts.views.get(key.camera, key.camera), np.linalg.norm(fit.residuals[key])
        blamed.add(outlier_words(key.landmark, view, float(away)))
    return tuple(words for words in fit.fit.words if words not in blamed)


def _misfit(fit: ShownFit) -> tuple[str, ...]:
    away = [float(np.linalg.norm(residual)) for residual in fit.residuals.values()]
    median = float(np.median(away)) if away else 0.0
    if not median > _MISFIT * USUAL_SIGMA:
        return ()
    return (f"The body does not fit these clicks: median distance {median:.0f} px.",)


def _precision(sigma: float) -> str:
    """What a standard deviation is called; it holds if the clicks are right."""
    limits = {
        3.0: "precise", 6.0: "fairly precise", _UNSURE_DEG: "imprecise",
        UNKNOWN_DEG: "very imprecise",
    }  # fmt: skip
    found = (words for limit, words in limits.items() if sigma <= limit)
    return next(found, "the clicks do not show it")


def _state(click: Click | None, *, predicted: bool) -> CellState:
    if click is None:
        return "predicted" if predicted else "missing"
    if click.visibility == Visibility.OUTSIDE:
        return "outside"
    if click.flag == UNCERTAIN:
        return "doubted"
    return "guessed" if click.visibility == Visibility.GUESSED else "clicked"


def _residual(facts: FrameMarks, landmark: str) -> str:
    """Root mean square distance of the clicks from the model, or from each other without one."""
    if facts.fit is not None:
        own = [r for key, r in facts.fit.residuals.items() if key.landmark == landmark]
        squares = [float(r @ r) for r in own if np.isfinite(r).all()]
        return f"{sqrt(sum(squares) / len(squares)):.1f}" if squares else ""
    points = facts.hints.points if facts.hints is not None else {}
    rms = points[landmark].rms_px if landmark in points else float("nan")
    return f"{rms:.1f}" if isfinite(rms) else ""


def _distance(facts: FrameMarks, landmark: str) -> str:
    points = facts.hints.points if facts.hints is not None else {}
    if facts.fit is None or landmark not in points or landmark not in facts.fit.places:
        return ""
    away = float(np.linalg.norm(points[landmark].world - facts.fit.places[landmark]))
    return f"{1000.0 * away:.0f}"


def _is_outlier(facts: FrameMarks, landmark: str) -> bool:
    return any(key.landmark == landmark for key in facts.outliers)
