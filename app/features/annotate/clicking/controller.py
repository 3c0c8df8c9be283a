"""Clicking in the window: from what a person does in the views to edits, and back to marks."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.doubts import Swap
from stereotrack_core.annotation.frame_clicks import ClickHints
from stereotrack_core.project.prefilling import accepted_sigma, set_accepted_sigma
from stereotrack_core.recording.description import Stream

from ....context import Context
from ....services.failures import Notifier
from ....session.changes import PROJECT, Part
from ....session.messages import Message, stored_text
from ....session.session import unless
from ....session.view_state import FittedBody, PictureKind, camera_of
from ....widgets.camera.overlays import LEADING
from ....widgets.forms.form_dialog import ask_for_number
from ....widgets.forms.numbers import NumberField
from ....widgets.tables.landmarks_panel import LandmarksPanel
from ....widgets.tables.panels import BodyPanel
from . import marks
from .annotating import Annotating
from .choosing import ADVANCES, Advance
from .detecting import FrameDetections
from .doubtful import DoubtfulWalk
from .facts import AnnotationFacts
from .proposing import ProposalPresenter

_Key: TypeAlias = tuple[object, ...]


class SwapOffers:
    """Messages that offer to exchange two landmarks, each until a person declines it."""

    def __init__(self, exchange: Callable[[Swap], None], notifier: Notifier) -> None:
        self._exchange, self._notifier = exchange, notifier
        notifier.dismissed.connect(self._decline)
        self._shown: dict[_Key, Message] = {}
        self._declined: set[_Key] = set()

    def show(self, hints: ClickHints | None, views: Mapping[str, str]) -> None:
        swaps = hints.swaps if hints is not None else ()
        found: dict[_Key, Swap] = {(s.frame, s.first, s.second, s.cameras): s for s in swaps}
        for key in [one for one in self._shown if one not in found]:
            self._notifier.take_back(self._shown.pop(key))
        for key, swap in found.items():
            if key not in self._shown.keys() | self._declined:
                self._shown[key] = self._message(swap, views)
                self._notifier.show(self._shown[key])

    def _decline(self, message: Message) -> None:
        self._declined |= {key for key, shown in self._shown.items() if shown == message}
        for key in self._declined & self._shown.keys():
            del self._shown[key]

    def _message(self, swap: Swap, views: Mapping[str, str]) -> Message:
        names = [name.replace("_", " ") for name in (swap.first, swap.second)]
        where = " and ".join(views.get(camera, camera) for camera in swap.cameras)
        sure = "seem to be swapped"
        if not swap.certain:
            sure = "may be swapped, here or in the other views"
        what = (
            f"{names[0]} and {names[1]} {sure}: {swap.distance:.0f} px from the epipolar curves of "
            f"the other views, {swap.distance_after:.0f} px if swapped"
        )
        where, do = f"{where}, frame {swap.frame}", lambda: self._exchange(swap)
        return Message("warning", what, where, button="Swap them", do=do)


_ADVANCE = "annotate/advance"
_GOES_ON = "annotate/goes_on"
_DEPTH = "annotate/depth"


class ClickController:
    """Brings views, panels and the presenters of clicking together."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self._views = context.docks.views
        self.landmarks = LandmarksPanel(lambda place: self.annotating.choose_place(place))
        self.body = BodyPanel()
        context.docks.add("landmarks", "Landmarks", self.landmarks)
        context.docks.add("body", "Body fit", self.body)
        self.annotating = Annotating(context, self.camera_at_hand, self._cameras)
        self.detections = FrameDetections(context, self.annotating)
        self.proposals = ProposalPresenter(context, self.annotating, self.detections)
        self.facts = AnnotationFacts(context, self.annotating, self._all_cameras, self.proposals)
        self.walk = DoubtfulWalk(context, self.annotating, self.facts, self.go_to)
        self._offers = SwapOffers(self.annotating.swap, context.notifier)
        stored = stored_text(context.settings, _ADVANCE)
        self.annotating.advance = next((name for name in ADVANCES if name == stored), "landmark")
        self.annotating.goes_on = bool(context.settings.value(_GOES_ON, False, type=bool))
        self.facts.use_depth = bool(context.settings.value(_DEPTH, True, type=bool))
        self.body.with_depth.setChecked(self.facts.use_depth)
        self._connect()
        context.tasks.watch(self.facts.settled)

    def _connect(self) -> None:
        context, session, views = self._context, self._session, self._views
        views.clicked.connect(self.annotating.act)
        views.refused.connect(self._say)
        views.at_hand_changed.connect(self._on_view_at_hand)
        watch = session.changes.watch
        watch(Part.PICTURES | Part.PLAYING, self.facts.ask)
        watch(Part.PICTURES, self.annotating.follow)
        watch(Part.WORKSPACE | PROJECT, self._on_workspace)
        watch(Part.INSTANT, self.show)
        # they follow one another in a moment
        watch(
            Part.DOUBTS | Part.HINTS | Part.PROPOSALS | Part.KEYPOINTS,
            partial(context.docks.redraw.soon, self.show),
        )
        watch(Part.CLICKS | Part.CHOICE, self.show)
        watch(Part.EDITS, self.annotating.end_nudging)
        session.changes.hear(Part.MOVED, self.annotating.choose_moved)
        watch(Part.WINDOW_CLOSING, self.facts.close)
        self.body.with_depth.toggled.connect(self._on_depth)

    # ---- state, computed from facts

    @property
    def active(self) -> bool:
        return self._context.docks.workspace == "annotate"

    def camera_at_hand(self) -> str:
        """The camera whose image the view at hand shows; empty where that takes no clicks."""
        return self._context.view_state.cameras().get(self._views.at_hand, "")

    def _cameras(self) -> tuple[str, ...]:
        return tuple(name for name in self._context.view_state.cameras().values() if name)

    def _all_cameras(self) -> tuple[str, ...]:
        state = self._context.view_state
        kinds = state.kinds.items()
        views = [(state.views[name], kind) for name, kind in kinds]
        return tuple(camera_of(view, kind) or view.image.camera for view, kind in views)

    # ---- showing

    def show(self) -> bool:
        """Draw clicks and fill panels; False while the frame's pictures are not there."""
        told, document = self._session.instant.told, self._session.document
        recording = document.recording
        if recording is None or told is None or told.frame_set.index != document.frame:
            return False
        facts, state = self.facts.now(), self._context.view_state
        shown = [recording.cameras[name] for name in self._cameras()]
        self._views.set_marks(marks.marks_of(facts, shown))
        blind = self.annotating.blind()
        state.hide(LEADING if blind or self.active else frozenset(), strictly=blind)
        self._offers.show(self.facts.hints() if self.active else None, self.facts.view_names())
        if self.active:
            cameras, fit = self._all_cameras(), facts.fit
            names = [facts.views.get(name, name) for name in cameras]
            known = facts.landmark_set.names
            chosen = known.index(facts.chosen) if facts.chosen in known else -1
            self.landmarks.show_rows(names, marks.landmark_rows(facts, cameras), chosen)
            words = (*self._left_out(facts.views), *marks.fit_words(facts))
            self.body.show_body(words, (*marks.limb_rows(facts), *marks.length_rows(facts)))
            self.body.cameras.mark(*marks.doubtful_views(facts))
            state.show_fit(FittedBody(fit.question.frame, fit.meshes) if fit is not None else None)
        self._context.actions.refresh_soon()
        return True

    def _left_out(self, views: Mapping[str, str]) -> tuple[str, ...]:
        names = [views.get(camera, camera) for camera in sorted(self.annotating.unused())]
        return (f"Left out: {', '.join(names)}.",) if names else ()

    # ---- what a person does

    def nudge(self, way: tuple[int, int], pixels: float, on_screen: float) -> None:
        """Move the crosshair by pixels of the screen; without one, the click in hand by pixels."""
        if (view := self.walk.aimed()) is not None:
            view.move_crosshair(on_screen * way[0], on_screen * way[1])
            return
        held = self.annotating.held()
        for tile in self._views.tiles.values():
            picture = tile.camera.picture
            if held is not None and picture is not None and picture.camera == held.camera:
                x, y = tile.camera.raw_direction(pixels * way[0], pixels * way[1])
                self.annotating.nudge(x, y)
                return

    def let_go(self) -> None:
        self.walk.end()
        self.annotating.let_go()

    def why_no_annotating(self) -> str:
        why_not = self._session.no_edit()
        if why_not or self.active:
            return why_not
        return "This works in the Annotate workspace. Switch to it with Alt+2."

    def why_no_camera(self) -> str:
        remedy = "Show the reference image (Shift+F2) or the left image (F2)."
        return unless(self.camera_at_hand(), f"This view shows no camera image. {remedy}")

    def predicted(self, *, everywhere: bool) -> tuple[Prediction, ...]:
        """Predictions to be accepted, in the view at hand or all: of what nobody has clicked."""
        facts, clicks = self.facts.predicted(), self.annotating.clicks()
        cameras = self._cameras() if everywhere else [self.camera_at_hand()]
        here = (one for camera in cameras for one in marks.predictions_in(facts, camera))
        return tuple(one for one in here if one.key not in clicks)

    def accept(self, *, everywhere: bool) -> None:
        """Accept what is sure, and go through the rest."""
        doubtful = self.facts.now().asked
        found = self.predicted(everywhere=everywhere)
        self.annotating.accept(tuple(one for one in found if one.key not in doubtful))
        if everywhere:
            self.walk.begin()

    def choose_advance(self, name: Advance) -> None:
        self.annotating.set_advance(name)
        self._context.settings.setValue(_ADVANCE, name)

    def toggle_going_on(self) -> None:
        self.annotating.goes_on = not self.annotating.goes_on
        self._context.settings.setValue(_GOES_ON, self.annotating.goes_on)

    def ask_wanted(self) -> None:
        field = NumberField(minimum=1.0, maximum=500.0, singleStep=1.0, suffix=" mm")
        field.show_stored(self.proposals.wanted_mm())
        use = self.proposals.set_wanted
        text = "Root mean square error of a frame's landmarks up to which clicks are asked for."
        ask_for_number(self._context.docks.dialog_parent, "Wanted accuracy", text, field, use)

    def ask_sigma(self) -> None:
        click = self.annotating.at_hand()
        if click is None:
            return
        field = NumberField(maximum=500.0, singleStep=0.5, suffix=" px")
        field.show_stored(click.sigma or 0.0)
        text = "Standard deviation in pixels; 0: as usual for this landmark"
        parent, use = self._context.docks.dialog_parent, self.annotating.set_sigma
        ask_for_number(parent, "Click uncertainty", text, field, lambda px: use(px or None))

    def ask_accepted_sigma(self) -> None:
        project = self._session.project.project
        if project is None:
            return

        def put(limit: float) -> None:
            set_accepted_sigma(project, limit)
            self.show()

        field = NumberField(minimum=0.5, maximum=500.0, singleStep=0.5, suffix=" px")
        field.show_stored(accepted_sigma(project))
        text = (
            "Largest standard deviation of points that are accepted, in pixels of an image of 480 "
            "lines. Points that are less certain stay open."
        )
        ask_for_number(self._context.docks.dialog_parent, "Limit for accepting", text, field, put)

    def toggle_depth(self) -> None:
        box = self.body.with_depth
        box.setChecked(not box.isChecked())

    def pick_last(self) -> None:
        self.annotating.pick_last()
        held = self.annotating.held()
        for name, camera in self._context.view_state.cameras().items():
            if held is not None and camera == held.camera:
                self._focus(name)

    def go_to(self, frame: int, camera: str, landmark: str) -> None:
        """Show a frame, make the view active in which to click, and choose the landmark."""
        self._session.document.visit(frame)
        recording = self._session.document.recording
        for view in recording.views if recording is not None else ():
            streams: dict[PictureKind, Stream | None] = {"image": view.image, "left": view.left}
            for kind, stream in streams.items():
                if stream is not None and stream.camera == camera:
                    self._context.view_state.choose_kind(kind, view.name)
                    self._focus(view.name)
        self.annotating.choose(landmark)

    def _focus(self, view: str) -> None:
        self._context.view_state.activate(view)
        self._views.tiles[view].camera.setFocus()

    # ---- following

    def _on_workspace(self) -> None:
        why_not = self._session.project.why_no_edit() if self.active else ""
        self._views.set_clicking(self.active, why_not)
        self.body.with_depth.setVisible(self._session.clouds.available)
        self.facts.set_active(self.active)
        self.annotating.follow()
        self.show()

    def _on_view_at_hand(self) -> None:
        if self.active:
            self.annotating.follow()
            self.show()

    def _on_depth(self, wanted: bool) -> None:
        self.facts.use_depth = wanted
        self._context.settings.setValue(_DEPTH, wanted)
        self.facts.ask()

    def _say(self, words: str) -> None:
        notifier, what = self._context.notifier, "Editing is not possible now"
        if words == self._session.project.why_no_edit():
            notifier.show(Message("warning", what, remedy=words))
        else:
            notifier.say(words)
