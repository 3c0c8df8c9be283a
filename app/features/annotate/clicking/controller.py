"""Clicking in the window: from what a person does in the views to edits, and back to marks."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject, Slot

from stereotrack_core.annotation.click import Prediction, Visibility
from stereotrack_core.annotation.doubts import Swap
from stereotrack_core.annotation.frame_clicks import ClickHints
from stereotrack_core.project.blind_repeats import BlindRepeats
from stereotrack_core.project.prefilling import accepted_sigma, set_accepted_sigma

from ....context import Context
from ....services.layout import stored_text
from ....session.edits import Moved
from ....session.pictures import FittedBody
from ....widgets.camera.click_marks import ClickAct
from ....widgets.camera.overlays import LEADING
from ....widgets.camera.picture import camera_of
from ....widgets.forms.form_dialog import ask_for_number
from ....widgets.forms.message import Message
from ....widgets.forms.numbers import NumberField
from ....widgets.tables.landmarks_panel import LandmarksPanel
from ....widgets.tables.panels import BodyPanel
from .annotating import Annotating
from .choosing import ADVANCES, Advance
from .facts import AnnotationFacts
from .landmark_rows import camera_rows, fit_words, landmark_rows, length_rows, limb_rows
from .marks import marks_of, predictions_in
from .proposing import ProposalPresenter


class SwapOffers:
    """Which offers are shown, and which have been declined."""

    def __init__(self, exchange: Callable[[Swap], None]) -> None:
        self._exchange = exchange
        self._shown: dict[tuple[object, ...], tuple[Swap, Message]] = {}
        self._declined: set[tuple[object, ...]] = set()

    def update(
        self, hints: ClickHints | None, views: Mapping[str, str]
    ) -> tuple[tuple[Message, ...], tuple[Message, ...]]:
        """Messages that hold no longer, and new ones."""
        swaps = {_key(swap): swap for swap in hints.swaps} if hints is not None else {}
        gone = [key for key in self._shown if key not in swaps]
        old = tuple(self._shown.pop(key)[1] for key in gone)
        new = []
        for key, swap in swaps.items():
            if key not in self._shown and key not in self._declined:
                new.append(self._message(swap, views))
                self._shown[key] = swap, new[-1]
        return old, tuple(new)

    def swap_of(self, message: Message) -> Swap | None:
        """The swap that a message offers; None where it is about something else."""
        return next((swap for swap, shown in self._shown.values() if shown == message), None)

    def decline(self, swap: Swap) -> None:
        """Do not offer this again."""
        self._declined.add(_key(swap))
        self._shown.pop(_key(swap), None)

    def _message(self, swap: Swap, views: Mapping[str, str]) -> Message:
        names = [name.replace("_", " ") for name in (swap.first, swap.second)]
        where = " and ".join(views.get(camera, camera) for camera in swap.cameras)
        sure = (
            "seem to be swapped" if swap.certain else "may be swapped, here or in the other views"
        )
        return Message(
            "warning",
            f"{names[0]} and {names[1]} {sure}: {swap.distance:.0f} px from the prediction of the "
            f"other views, {swap.distance_after:.0f} px if swapped",
            f"{where}, frame {swap.frame}",
            button="Swap them",
            do=lambda: self._exchange(swap),
        )


def _key(swap: Swap) -> tuple[object, ...]:
    return (swap.frame, swap.first, swap.second, swap.cameras)


_ADVANCE = "annotate/advance"
_GOES_ON = "annotate/goes_on"
_ASKS = "annotate/asks"
_DEPTH = "annotate/depth"


class ClickController(QObject):
    """Brings views, panels and the presenters of clicking together."""

    def __init__(self, context: Context, repeats: Callable[[], BlindRepeats | None]) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._views = context.docks.views
        session = context.session
        self.landmarks, self.body = LandmarksPanel(), BodyPanel()
        context.docks.add("landmarks", "Landmarks", self.landmarks)
        context.docks.add("body", "Body fit", self.body)
        self.annotating = Annotating(
            session.document, session.project, repeats, self.camera_at_hand, self._cameras
        )
        """The choice and the edits."""
        self.proposals = ProposalPresenter(
            session.document, session.project, self.annotating, self._cameras
        )
        """What is proposed for the frame and the one after it."""
        self.facts = AnnotationFacts(
            session.document, session.project, session.clouds, self.annotating, self._all_cameras,
            session.cameras, self.proposals,
        )  # fmt: skip
        """What is known about the clicks of the frame."""
        self._offers = SwapOffers(self.annotating.swap)
        stored = stored_text(context.settings, _ADVANCE)
        self.annotating.advance = next((name for name in ADVANCES if name == stored), "landmark")
        self.annotating.goes_on = bool(context.settings.value(_GOES_ON, False, type=bool))
        self.proposals.set_asks(bool(context.settings.value(_ASKS, False, type=bool)))
        self.facts.use_depth = bool(context.settings.value(_DEPTH, True, type=bool))
        self.body.with_depth.setChecked(self.facts.use_depth)
        self._connect()
        context.tasks.watch(self.facts.settled)

    def _connect(self) -> None:
        context, session, views = self._context, self._session, self._views
        views.clicked.connect(self._on_clicked)
        views.refused.connect(self._say)
        views.space_tapped.connect(session.document.toggle_playing)
        views.at_hand_changed.connect(self._on_view_at_hand)
        context.view_state.wanted_changed.connect(self.facts.ask)
        context.view_state.wanted_changed.connect(self.annotating.follow)
        context.docks.workspace_changed.connect(self._on_workspace)
        session.project.opened.connect(self._on_workspace)
        session.project.closed.connect(self._on_workspace)
        session.instant.ready.connect(self.show)
        session.document.playing_changed.connect(self.facts.ask)
        session.cameras.changed.connect(self.show)
        session.cameras.measured.connect(self.show)
        session.closing.connect(self.facts.close)
        self.landmarks.chosen.connect(self.annotating.choose)
        self.body.with_depth.toggled.connect(self._on_depth)
        session.edits.changed.connect(self.annotating.end_nudging)
        session.edits.moved.connect(self._on_moved)
        self.annotating.said.connect(self._say)
        self.annotating.clicks_changed.connect(self._on_annotated)
        self.annotating.choice_changed.connect(self._on_annotated)
        self.facts.changed.connect(self.show)
        self.facts.failed.connect(context.notifier.error)
        context.notifier.dismissed.connect(self._on_dismissed)

    # ---- state, computed from facts

    @property
    def active(self) -> bool:
        """Whether clicks are placed: in the workspace for that."""
        return self._context.docks.workspace == "annotate"

    def camera_at_hand(self) -> str:
        """The camera whose image the view at hand shows; empty where that takes no clicks."""
        return self._context.view_state.cameras().get(self._views.at_hand, "")

    def _cameras(self) -> tuple[str, ...]:
        return tuple(name for name in self._context.view_state.cameras().values() if name)

    def _all_cameras(self) -> tuple[str, ...]:
        """Cameras of all views, also those that are not shown now or show computed pictures."""
        state = self._context.view_state
        kinds = state.kinds.items()
        views = [(state.views[name], kind) for name, kind in kinds]
        return tuple(camera_of(view, kind) or view.image.camera for view, kind in views)

    # ---- showing

    @Slot()
    def show(self, _what: object = None) -> None:
        """Draw the clicks of the frame, when its pictures are there; fill the panels."""
        told, document = self._session.instant.told, self._session.document
        recording = document.recording
        if recording is None or told is None or told.frame_set.index != document.frame:
            return
        facts, state = self.facts.now(), self._context.view_state
        shown = [recording.cameras[name] for name in self._cameras()]
        self._views.set_marks(marks_of(facts, shown))
        blind = self.annotating.blind()
        state.hide(LEADING if blind or self.active else frozenset(), strictly=blind)
        self._show_offers()
        if self.active:
            cameras, fit = self._all_cameras(), facts.fit
            names = [facts.views.get(name, name) for name in cameras]
            self.landmarks.show_rows(names, landmark_rows(facts, cameras))
            rows = (*limb_rows(facts), *camera_rows(facts), *length_rows(facts))
            self.body.show_body(fit_words(facts), rows)
            state.show_fit(FittedBody(fit.question.frame, fit.meshes) if fit is not None else None)
        self._context.actions.refresh_soon()

    @Slot()
    def _on_annotated(self) -> None:
        self.show()
        told = self._session.instant.told
        if told is None or told.frame_set.index != self._session.document.frame:
            return  # another frame is on its way
        # keys that follow a click at once find their commands ready
        self._context.actions.refresh("&Annotate")

    @Slot(object)
    def _on_dismissed(self, message: Message) -> None:
        """Do not offer a swap again that a person has dismissed."""
        swap = self._offers.swap_of(message)
        if swap is not None:
            self._offers.decline(swap)
            self._show_offers()

    def _show_offers(self) -> None:
        hints = self.facts.hints() if self.active else None
        gone, new = self._offers.update(hints, self.facts.view_names())
        for message in gone:
            self._context.notifier.take_back(message)
        for message in new:
            self._context.notifier.show(message)

    # ---- what a person does

    @Slot(object)
    def _on_clicked(self, act: ClickAct) -> None:
        match act.what:
            case "move":
                self.annotating.move(act.key, act.pixel)
            case "pick":
                self.annotating.pick(act.key)
            case _:
                seen = Visibility.GUESSED if act.what == "guess" else Visibility.SEEN
                self.annotating.place(act.key, act.pixel, seen)

    def nudge(self, x: float, y: float) -> None:
        """Move the click in hand in the direction that the person sees; picture pixels."""
        held = self.annotating.held()
        for tile in self._views.tiles.values():
            picture = tile.camera.picture
            if held is not None and picture is not None and picture.camera == held.camera:
                self.annotating.nudge(*tile.camera.raw_direction(x, y))
                return

    def why_no_annotating(self) -> str:
        """Why nothing can be clicked now, as a sentence."""
        why_not = self._session.no_edit()
        if why_not or self.active:
            return why_not
        return "This works in the Annotate workspace. Switch to it with Alt+2."

    def why_no_camera(self) -> str:
        """Why keys act on no image."""
        return (
            ""
            if self.camera_at_hand()
            else "This view shows no camera image. Show the reference image (Shift+F2) or the left "
            "image (F2)."
        )

    def predictions(self, *, everywhere: bool) -> tuple[Prediction, ...]:
        """Predictions of the chosen landmark where nobody has clicked it: at hand, or anywhere."""
        facts, clicks = self.facts.now(), self.annotating.clicks()
        return tuple(
            one
            for camera in (self._cameras() if everywhere else [self.camera_at_hand()])
            for one in predictions_in(facts, camera)
            if one.landmark == facts.chosen and one.key not in clicks
        )

    def accept(self, *, everywhere: bool) -> None:
        """Accept the prediction of the chosen landmark in the view at hand, or in all views."""
        self.annotating.accept(self.predictions(everywhere=everywhere))

    def accept_proposals(self, *, everywhere: bool) -> None:
        """Accept what is proposed in the view at hand, or in all views; one edit."""
        self.annotating.accept(self.proposed(everywhere=everywhere))

    def proposed(self, *, everywhere: bool) -> tuple[Prediction, ...]:
        """Proposals of what nobody has clicked: in the view at hand, or in all of them."""
        here = self.camera_at_hand()
        return tuple(one for one in self.proposals.now() if everywhere or one.camera == here)

    def choose_advance(self, name: Advance) -> None:
        """Say what follows when a click was placed, and keep it for next time."""
        self.annotating.set_advance(name)
        self._context.settings.setValue(_ADVANCE, name)

    def toggle_going_on(self) -> None:
        """Go on to another frame when one is clicked, or stay; and keep that for next time."""
        self.annotating.goes_on = not self.annotating.goes_on
        self._context.settings.setValue(_GOES_ON, self.annotating.goes_on)

    def toggle_asking(self) -> None:
        """Let proposals leave out what should be clicked, or not; and keep that for next time."""
        self.proposals.set_asks(not self.proposals.asks)
        self._context.settings.setValue(_ASKS, self.proposals.asks)

    def ask_sigma(self) -> None:
        """Let the person say how sure the click at hand is."""
        click = self.annotating.at_hand()
        if click is None:
            return
        field = NumberField(maximum=500.0, singleStep=0.5, suffix=" px")
        field.show_stored(click.sigma or 0.0)
        ask_for_number(
            self._context.docks.dialog_parent,
            "Click uncertainty",
            "Standard deviation in pixels; 0: as usual for this landmark",
            field,
            lambda px: self.annotating.set_sigma(px or None),
        )

    def ask_accepted_sigma(self) -> None:
        """Let the person set up to which standard deviation predictions are accepted."""
        project = self._session.project.project
        if project is None:
            return

        def put(limit: float) -> None:
            set_accepted_sigma(project, limit)
            self.show()

        field = NumberField(minimum=0.5, maximum=500.0, singleStep=0.5, suffix=" px")
        field.show_stored(accepted_sigma(project))
        ask_for_number(
            self._context.docks.dialog_parent,
            "Limit for accepting",
            "Largest standard deviation of points that are accepted, in pixels of an image of 480 "
            "lines. Points that are less certain stay open.",
            field,
            put,
        )

    def toggle_depth(self) -> None:
        """Fit with or without measured points."""
        box = self.body.with_depth
        box.setChecked(not box.isChecked())

    def pick_last(self) -> None:
        """Take the click at hand in hand, and let keys go to its view."""
        self.annotating.pick_last()
        held = self.annotating.held()
        for name, camera in self._context.view_state.cameras().items():
            if held is not None and camera == held.camera:
                self._context.view_state.activate(name)
                self._views.tiles[name].camera.setFocus()

    # ---- following

    @Slot()
    def _on_workspace(self) -> None:
        why_not = self._session.project.why_no_edit() if self.active else ""
        self._views.set_clicking(self.active, why_not)
        self.body.with_depth.setVisible(self._session.clouds.available)
        self.facts.set_active(self.active)
        self.annotating.follow()
        self.show()

    @Slot(str)
    def _on_view_at_hand(self, _name: str) -> None:
        if self.active:
            self.annotating.follow()
            self.show()

    @Slot(bool)
    def _on_depth(self, wanted: bool) -> None:
        self.facts.use_depth = wanted
        self._context.settings.setValue(_DEPTH, wanted)
        self.facts.ask()

    @Slot(object)
    def _on_moved(self, moved: Moved) -> None:
        if moved.changed is not None:
            self.annotating.choose_changed(moved.changed)

    @Slot(str)
    def _say(self, words: str) -> None:
        if words == self._session.project.why_no_edit():
            self._context.notifier.show(
                Message("warning", "Editing is not possible now", remedy=words)
            )
        else:
            self._context.notifier.say(words, 6000)
