"""Facts about the clicks of a frame become marks over the pictures and rows of the panels."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import isfinite, sqrt

import numpy as np

from stereotrack_core.annotation.click import (
    UNCERTAIN,
    USUAL_SIGMA,
    Click,
    ClickKey,
    Prediction,
    Visibility,
)
from stereotrack_core.annotation.doubts import own_outliers, what_disagrees, what_to_do
from stereotrack_core.annotation.fit.results import PROBABLE, outlier_words
from stereotrack_core.annotation.frame_clicks import ClickHints, ShownFit
from stereotrack_core.annotation.landmark_set import Landmark, LandmarkSet
from stereotrack_core.annotation.predict import pixel_scale
from stereotrack_core.annotation.propose import ACCEPTED_SIGMA, PROPOSED, is_certain
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import UNKNOWN_DEG
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import Disagreement

from ....widgets.camera import click_marks
from ....widgets.camera.overlays import limb_paths, part_shapes
from ....widgets.style.colours import LIMB_COLOURS, limb_words
from ....widgets.tables.landmarks_panel import CELL_STATES, CellState
from ....widgets.tables.table import Cell, CellRow

TRIANGULATED = "other views"  # source of predictions from the clicks of the same frame
FEWEST = 3  # clicks from which on a body is fitted; fewer would only show the usual pose
_SURE_DEG, _FAINTEST = 5.0, 0.15  # standard deviation up to which a limb is opaque; opacity
_FAINTEST_PREDICTION = 0.35
_KEYS = 9
_NUMBERS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


@dataclass(frozen=True, eq=False)
class FrameMarks:
    """Everything that marks are made of."""

    frame: int
    clicks: tuple[Click, ...]
    landmark_set: LandmarkSet
    chosen: str = ""
    at_hand: ClickKey | None = None
    held: ClickKey | None = None  # the click that keys act on; that Alt+arrows move
    predictions: tuple[Prediction, ...] = ()
    asked: frozenset[ClickKey] = frozenset()
    accuracy: str = ""
    """Proposals that shall be looked at; how accurate the frame is, in words."""
    detecting: str = ""  # what the pose detector does, or would bring
    hints: ClickHints | None = None
    fit: ShownFit | None = None
    views: Mapping[str, str] = field(default_factory=dict)
    """Names that people know the cameras by, by camera."""
    offers: Mapping[str, str | None] = field(default_factory=dict)
    """The landmark that the next click in an image that is shown places; None: it places none."""
    unused: frozenset[str] = frozenset()  # cameras that are left out, whose clicks do not count
    doubtful: Disagreement | None = None  # A camera that contradicts the others over all clicks
    calibrated: bool = True  # the cameras are known, so that a body can be fitted to clicks
    accepted_sigma: float = ACCEPTED_SIGMA
    """Largest standard deviation of predictions that are accepted, pixels at 480 lines."""

    def label(self, landmark: str) -> str:
        known = landmark in self.landmark_set.names
        return self.landmark_set[landmark].label if known else landmark.replace("_", " ")

    def colour(self, landmark: str) -> str:
        known = landmark in self.landmark_set.names
        return self.landmark_set[landmark].colour if known else "#ffffff"

    @property
    def fit_is_old(self) -> bool:
        used = tuple(click for click in self.clicks if click.camera not in self.unused)
        return self.fit is not None and self.fit.question.clicks != used

    @cached_property
    def flagged(self) -> frozenset[ClickKey]:
        """Clicks that the fit of this frame takes for outliers."""
        found = self.fit.outliers if self.fit is not None else {}
        return frozenset(key for key, chance in found.items() if chance > PROBABLE)

    @cached_property
    def outliers(self) -> frozenset[ClickKey]:
        cameras = self.fit.question.cameras if self.fit is not None else {}
        return frozenset(own_outliers(self.flagged, self.doubtful, self.clicks, cameras))


def marks_of(facts: FrameMarks, cameras: Iterable[Camera]) -> dict[str, click_marks.ClickMarks]:
    """Marks for every camera whose image is shown, by its name."""
    return {camera.name: _marks(facts, camera) for camera in cameras}


def predictions_in(facts: FrameMarks, camera: str) -> tuple[Prediction, ...]:
    """The best prediction of every landmark in a camera's image, clicked or not.

    In this order: a proposal, clicks in two other views, the most certain one of the project.
    """
    here = [one for one in facts.predictions if one.camera == camera]
    proposed = {one.landmark: one for one in here if one.source == PROPOSED}
    kept = [one for one in here if one.source != PROPOSED]
    kept.sort(key=lambda one: np.inf if one.sigma is None else one.sigma, reverse=True)
    found = {one.landmark: one for one in kept}
    points = facts.hints.points if facts.hints is not None else {}
    for name, point in points.items():
        if camera in point.pixel:
            x, y = (float(value) for value in point.pixel[camera])
            sigma = point.spread_px.get(camera)
            found[name] = Prediction(facts.frame, camera, name, TRIANGULATED, (x, y), sigma)
    found |= proposed
    known = facts.landmark_set.names
    return tuple(found[name] for name in known if name in found)


def _marks(facts: FrameMarks, camera: Camera) -> click_marks.ClickMarks:
    own = [click for click in facts.clicks if click.camera == camera.name]
    clicks = [mark for click in own if (mark := _click_mark(facts, click)) is not None]
    said = {click.key for click in own}
    return click_marks.ClickMarks(
        frame=facts.frame,
        camera=camera.name,
        clicks=tuple(clicks),
        predictions=_prediction_marks(facts, camera, {mark.landmark for mark in clicks}),
        curves=_curve_marks(facts, camera.name),
        residuals=_residual_marks(facts, own, camera),
        model=() if facts.fit is None else _model(facts.fit, camera),
        model_is_old=facts.fit_is_old,
        outside=tuple(
            facts.label(click.landmark) for click in own if click.visibility == Visibility.OUTSIDE
        ),
        proposed_outside=tuple(
            facts.label(one.landmark)
            for one in predictions_in(facts, camera.name)
            if one.visibility == Visibility.OUTSIDE and one.key not in said
        ),
        offer=_offer(facts, camera.name, own),
    )


def _offer(facts: FrameMarks, camera: str, own: Iterable[Click]) -> click_marks.Offer:
    there = {click.landmark: click for click in own}
    landmark = facts.offers.get(camera)
    if landmark is None:
        return click_marks.Offer(words=_nothing_to_place(facts, set(there)))
    label, click = facts.label(landmark), there.get(landmark)
    moves = click is not None and click.position is not None
    words = f"move {label} here" if moves else label
    words += " (this camera is left out)" if camera in facts.unused else ""
    return click_marks.Offer(landmark, words, facts.colour(landmark), moves)


def _nothing_to_place(facts: FrameMarks, clicked: set[str]) -> str:
    names = facts.landmark_set.names
    if not clicked.issuperset(names):  # the chosen landmark waits for the other views
        there = {click.key for click in facts.clicks}
        left = [
            one for one in facts.offers if ClickKey(facts.frame, one, facts.chosen) not in there
        ]
        views = ", ".join(facts.views.get(camera, camera) for camera in left)
        return f"{facts.label(facts.chosen)} is already clicked here: continue in {views}"
    count = len(names)
    number = _NUMBERS[count] if count < len(_NUMBERS) else str(count)
    return f"all {number} are clicked here: drag to move, 1-{min(count, _KEYS)} to select one"


def _click_mark(facts: FrameMarks, click: Click) -> click_marks.ClickMark | None:
    if click.position is None:
        return None
    x, y = click.position
    return click_marks.ClickMark(
        landmark=click.landmark, label=facts.label(click.landmark),
        colour=facts.colour(click.landmark), x=x, y=y,
        guessed=click.visibility == Visibility.GUESSED, doubted=click.flag == UNCERTAIN,
        accepted=click.accepted, outlier=click.key in facts.outliers,
        chosen=click.landmark == facts.chosen, at_hand=click.key == facts.at_hand,
        held=click.key == facts.held,
    )  # fmt: skip


def _prediction_marks(
    facts: FrameMarks, camera: Camera, clicked: set[str]
) -> tuple[click_marks.PredictionMark, ...]:
    """Predictions where nobody has clicked; of the chosen landmark everywhere, with its error."""
    points = facts.hints.points if facts.hints is not None else {}
    found, limit = list[click_marks.PredictionMark](), facts.accepted_sigma * pixel_scale(camera)
    for one in predictions_in(facts, camera.name):
        name, chosen = one.landmark, one.landmark == facts.chosen
        if (name in clicked and not chosen) or one.visibility == Visibility.OUTSIDE:
            continue
        errors = points[name].error_px if name in points else {}
        mark = click_marks.PredictionMark(
            name, facts.label(name), facts.colour(name), *one.position,
            error_px=errors.get(camera.name, float("nan")),
            spread_px=float("nan") if one.sigma is None else one.sigma,
            chosen=chosen, proposed=one.source == PROPOSED,
            guessed=one.visibility == Visibility.GUESSED, opacity=_certainty(one.sigma, limit),
            certain=one.key not in facts.asked
            and is_certain(one, {camera.name: camera}, facts.accepted_sigma),
        )  # fmt: skip
        found.append(mark)
    return tuple(found)


def _curve_marks(facts: FrameMarks, camera: str) -> tuple[click_marks.CurveMark, ...]:
    """Curves of the chosen landmark; those of the one before it are out of date."""
    if facts.hints is None or facts.hints.question.landmark != facts.chosen:
        return ()
    found = []
    for curve in facts.hints.curves.get(camera, ()):
        view = facts.views.get(curve.from_camera, curve.from_camera)
        found.append(click_marks.CurveMark(facts.colour(curve.landmark), view, curve.pixels))
    return tuple(found)


def _residual_marks(
    facts: FrameMarks, clicks: Iterable[Click], camera: Camera
) -> tuple[click_marks.ResidualMark, ...]:
    """Lines from the clicks to the model, which may be of the fit before the last click."""
    if facts.fit is None:
        return ()
    found = []
    for click in clicks:
        place = facts.fit.places.get(click.landmark)
        if place is None or click.position is None:
            continue
        end = camera.project(place)
        if np.isfinite(end).all():
            colour = facts.colour(click.landmark)
            found.append(
                click_marks.ResidualMark(colour, click.position, (float(end[0]), float(end[1])))
            )
    return tuple(found)


@lru_cache(maxsize=16)  # a fit is drawn again with each click that follows it
def _model(fit: ShownFit, camera: Camera) -> tuple[click_marks.LimbMark, ...]:
    shapes = part_shapes(fit.meshes, camera.project, camera.position_world, wire=False)
    sigma = dict(zip(LIMBS, fit.fit.limb_sigma_deg.tolist(), strict=True))
    known = (_SURE_DEG, UNKNOWN_DEG), (1.0, _FAINTEST)
    return tuple(
        click_marks.LimbMark(limb, path, float(np.interp(sigma[limb], *known)))
        for limb, path in limb_paths(shapes)
    )


def _certainty(sigma: float | None, limit: float) -> float:
    """Opacity of a prediction with this standard deviation, of which `limit` is accepted."""
    if sigma is None:
        return _FAINTEST_PREDICTION
    return float(np.interp(sigma / limit, (0.5, 1.0, 3.0), (1.0, 0.75, _FAINTEST_PREDICTION)))


_OUTLIER = "The fit treats a click of this landmark as an outlier.", "warning"  # tip and colour
_OTHER_LENGTHS = (
    "Clicked lengths differ from the subject's: Annotate, Subject … measures them from the clicks."
)
_MOST_WORDS = 3
_UNSURE_DEG = 10.0
_MISFIT = 8.0
"""Usual sigmas that the clicks are off in the median from which the fit is called wrong."""


def landmark_rows(facts: FrameMarks, cameras: Sequence[str]) -> tuple[CellRow, ...]:
    """Every landmark of the set, with its state in these cameras."""
    there = {(click.camera, click.landmark): click for click in facts.clicks}
    seen = {(one, p.landmark) for one in cameras for p in predictions_in(facts, one)}
    away = _distances(facts.hints, facts.fit)

    def cell(camera: str, landmark: Landmark) -> Cell:
        place = camera, landmark.name
        state = _state(there.get(place), predicted=place in seen)
        sign, words = CELL_STATES[state]
        said = f"{landmark.label} in {facts.views.get(camera, camera)}: {words}"
        colour = "disabled" if state == "missing" else landmark.colour
        return Cell(sign, said, colour, said=said)

    def row(place: int, landmark: Landmark) -> CellRow:
        shown = _OUTLIER if _is_outlier(facts, landmark.name) else ("", "")
        return (
            Cell(str(place) if place <= _KEYS else "", swatch=landmark.colour),
            Cell(landmark.label),
            *(cell(camera, landmark) for camera in cameras),
            Cell(_residual(facts, landmark.name), *shown),
            Cell(f"{away[landmark.name]:.0f} " if landmark.name in away else "", *shown),
        )

    return tuple(row(*each) for each in enumerate(facts.landmark_set.landmarks, start=1))


def limb_rows(facts: FrameMarks) -> tuple[CellRow, ...]:
    """Rows with the uncertainty of every limb's direction by the clicks; none without a fit."""
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


def doubtful_views(facts: FrameMarks) -> tuple[tuple[str, ...], str]:
    """Cameras that contradict the others, as people call them, and by how much in words."""
    found = facts.doubtful
    if found is None:
        return (), ""
    names = tuple(facts.views.get(name, name) for name in found.doubtful)
    return names, what_disagrees(found, facts.views)


def fit_words(facts: FrameMarks) -> tuple[str, ...]:
    """Warnings and results of the fit, the most important first; or what it waits for."""
    found = facts.doubtful
    if facts.fit is not None:
        said = (*_misfit(facts.fit), *_frame_words(facts, facts.fit))
        lengths = () if facts.hints is None else facts.hints.lengths
        said = (_OTHER_LENGTHS, *said) if any(one.doubtful for one in lengths) else said
        if facts.accuracy:
            said = (facts.accuracy, *said)
        if found is not None:  # the rest follows from the camera that contradicts the others
            said = (f"{what_disagrees(found, facts.views)}. {what_to_do(found)}", *said)
        more = len(said) - _MOST_WORDS
        return (*said[:_MOST_WORDS], f"and {more} more") if more > 0 else said
    if facts.accuracy:
        return (facts.accuracy,)
    detecting = (facts.detecting,) if facts.detecting else ()
    if not facts.calibrated:
        return ("No calibration: clicks are kept, and no body is fitted to them.", *detecting)
    positions = sum(click.position is not None for click in facts.clicks)
    if positions >= FEWEST:
        return ("Fitting the body to the clicks …",)
    if positions:
        return ("Click at least three landmarks to fit the body.", *detecting)
    return ("Click landmarks to fit the body. Keys 1 to 9 select a landmark.", *detecting)


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
    """Word for a standard deviation, which holds if the clicks are right."""
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


def _distances(hints: ClickHints | None, fit: ShownFit | None) -> dict[str, float]:
    """Millimetres from the triangulated clicks of each landmark to the fitted body."""
    points, places = ({} if hints is None else hints.points), ({} if fit is None else fit.places)
    both = points.keys() & places.keys()
    return {k: 1000.0 * float(np.linalg.norm(points[k].world - places[k])) for k in both}


def body_off_mm(hints: ClickHints | None, fit: ShownFit | None) -> float:
    """Root mean square of these distances; 0 if none is known."""
    return float(np.sqrt(np.mean(np.square([*_distances(hints, fit).values()] or [0.0]))))


def _is_outlier(facts: FrameMarks, landmark: str) -> bool:
    return any(key.landmark == landmark for key in facts.outliers)
