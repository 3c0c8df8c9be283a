"""Facts about the clicks of a frame become what is drawn over the pictures."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from stereotrack_core.annotation.accepting import ACCEPTED_SIGMA, is_certain, pixel_scale
from stereotrack_core.annotation.click import (
    ACCEPTED,
    UNCERTAIN,
    Click,
    ClickKey,
    Prediction,
    Visibility,
)
from stereotrack_core.annotation.doubts import own_outliers
from stereotrack_core.annotation.fit.results import PROBABLE
from stereotrack_core.annotation.frame_clicks import ClickHints, ShownFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.propose import PROPOSED
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import UNKNOWN_DEG
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import CameraResidual, Disagreement

from ....widgets.camera import click_marks
from ....widgets.camera.overlays import limb_paths, part_shapes

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
    chosen: str
    at_hand: ClickKey | None = None
    held: ClickKey | None = None  # the click that keys act on; that arrow keys move
    predictions: tuple[Prediction, ...] = ()
    hints: ClickHints | None = None
    fit: ShownFit | None = None
    views: Mapping[str, str] = field(default_factory=dict)
    """Names that people know the cameras by, by camera."""
    offers: Mapping[str, str | None] = field(default_factory=dict)
    """The landmark that the next click in an image that is shown places; None: it places none."""
    doubtful: Disagreement | None = None  # A camera that contradicts the others over all clicks
    residuals: tuple[CameraResidual, ...] = ()
    """How far the clicks of each camera lie from the points that the cameras agree on."""
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
        return self.fit is not None and self.fit.question.clicks != self.clicks

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
        accepted=click.origin == ACCEPTED, outlier=click.key in facts.outliers,
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
            certain=is_certain(one, {camera.name: camera}, facts.accepted_sigma),
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
    return tuple(
        click_marks.LimbMark(limb, path, _opacity(sigma[limb])) for limb, path in limb_paths(shapes)
    )


def _certainty(sigma: float | None, limit: float) -> float:
    """Opacity of a prediction with this standard deviation, of which `limit` is accepted."""
    if sigma is None:
        return _FAINTEST_PREDICTION
    return float(np.interp(sigma / limit, (0.5, 1.0, 3.0), (1.0, 0.75, _FAINTEST_PREDICTION)))


def _opacity(sigma_deg: float) -> float:
    return float(np.interp(sigma_deg, (_SURE_DEG, UNKNOWN_DEG), (1.0, _FAINTEST)))
