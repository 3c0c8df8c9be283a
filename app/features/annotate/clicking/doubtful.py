"""Doubtful predictions one after the other, each enlarged, and the crosshair that keys move."""

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF

from stereotrack_core.annotation.click import ClickKey, Prediction

from ....context import Context
from ....session.changes import PROJECT, Part
from ....widgets.camera.camera_view import CameraView
from .annotating import Annotating
from .facts import AnnotationFacts

_SIGMAS, _LEAST = 6.0, 30.0  # to each side in what fills a view; at least, in pixels


class DoubtfulWalk:
    """The doubtful prediction that is looked at, and what Enter does with it.

    `show` goes to a click's frame, view and landmark. Without a doubtful prediction, or where a
    person has chosen a landmark, Enter shows a crosshair in the view at hand and then places the
    landmark that is offered there.
    """

    def __init__(
        self,
        context: Context,
        annotating: Annotating,
        facts: AnnotationFacts,
        show: Callable[[int, str, str], object],
    ) -> None:
        self._context, self._views = context, context.docks.views
        self._annotating, self._facts, self._show = annotating, facts, show
        self._proposals = facts.proposals
        self.at: Prediction | None = None
        """The doubtful prediction that is looked at."""
        self._looking: CameraView | None = None
        watch = context.session.changes.watch
        watch(Part.CLICKS | Part.PROPOSALS, self._follow)
        watch(Part.FRAME | Part.WORKSPACE | PROJECT, self.end)

    def aimed(self) -> CameraView | None:
        """The view that shows the crosshair."""
        cameras = (tile.camera for tile in self._views.tiles.values())
        return next((one for one in cameras if one.crosshair is not None), None)

    def begin(self) -> None:
        """Look at the most useful doubtful prediction; end where there is none."""
        left = self._proposals.doubtful()
        if not left:
            self._finish()
        elif self.at is None or self.at.key != left[0].key:
            self._look_at(left[0], len(left) - 1)

    def confirm(self) -> None:
        """Place the landmark at the crosshair, or accept what is proposed there, and go on."""
        view = self.aimed()
        if view is None or view.crosshair is None or view.marks is None:
            if self._proposals.doubtful() and not self._annotating.choice.asked:
                self.begin()
            else:
                self._aim()
            return
        one, pixel = self.at, view.crosshair.toTuple()
        if one is not None and pixel == one.position:
            self._annotating.confirm(one)
        else:
            landmark = one.landmark if one is not None else view.marks.offer.landmark
            if landmark:
                self._annotating.place(view.marks.key(landmark), pixel)
        if one is None:
            self._aim()

    def end(self) -> None:
        """Hide the crosshair, and show each view as it was."""
        self.at = None
        for tile in self._views.tiles.values():
            tile.camera.set_crosshair(None)
        if self._looking in [tile.camera for tile in self._views.tiles.values()]:
            self._looking.look_back()
        self._looking = None

    # ---- following

    def _follow(self) -> None:
        one = self.at
        if one is None:
            return
        open_ones = {other.key: other for other in self._proposals.doubtful()}
        view, now = self.aimed(), open_ones.get(one.key, one)
        if now != one and view and view.crosshair and view.crosshair.toTuple() == one.position:
            view.set_crosshair(QPointF(*now.position))  # nobody has moved it
            self.at = now
        if one.key not in open_ones and (self._clicked(one.key) or self._proposals.settled()):
            self.begin()

    def _clicked(self, key: ClickKey) -> bool:
        return key in self._annotating.clicks()

    def _finish(self) -> None:
        if self.at is not None:
            self.end()
            free = [one for one in self._proposals.now() if not self._clicked(one.key)]
            rest = " Q accepts the rest." if free else ""
            words = f"Nothing doubtful is left. {self._facts.now().accuracy}{rest}"
            self._context.notifier.say(words)

    def _look_at(self, one: Prediction, more: int) -> None:
        self.end()
        self._show(*one.key)
        view = self._view_of(one.camera)
        if view is None:
            return
        side = max(_SIGMAS * (one.sigma or 0.0), _LEAST)
        x, y = one.position
        view.look_at(QRectF(x - side, y - side, 2.0 * side, 2.0 * side))
        view.set_crosshair(QPointF(x, y))
        self.at, self._looking = one, view
        recording, label = self._context.session.document.recording, one.landmark.replace("_", " ")
        names = {} if recording is None else recording.camera_names()
        words = f"{label.capitalize()} in {names.get(one.camera, one.camera)}"
        then = f" {more} more to check." if more else ""
        self._context.notifier.say(f"{words}: Enter accepts it, a click corrects it.{then}")

    def _aim(self) -> None:
        """Show the crosshair where the landmark that is offered in the view at hand may be."""
        self.end()
        tile = self._views.tiles.get(self._views.at_hand)
        marks = tile.camera.marks if tile is not None else None
        if tile is None or marks is None or not marks.offer.landmark:
            words = marks.offer.words if marks is not None else "this view shows no camera image"
            self._context.notifier.say(f"{words[:1].upper()}{words[1:]}.")
            return
        found = [m for m in marks.predictions if m.landmark == marks.offer.landmark]
        middle = tile.camera.pixel_at(QRectF(tile.camera.rect()).center())
        place = QPointF(found[0].x, found[0].y) if found else marks.on_curve(middle) or middle
        tile.camera.set_crosshair(place)

    def _view_of(self, camera: str) -> CameraView | None:
        cameras = (tile.camera for tile in self._views.tiles.values())
        shown = (one for one in cameras if one.picture is not None)
        return next((one for one in shown if one.picture and one.picture.camera == camera), None)
