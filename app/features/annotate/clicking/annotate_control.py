"""Clicking in the window: from what a person does in the views to edits, and back to marks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Slot
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QInputDialog

from stereotrack_core.annotation.click import ClickKey, Visibility
from stereotrack_core.annotation.prediction import Prediction

from ....services.failures import Message
from ....services.stored import stored_text
from ....session.camera_doubts import CameraDoubts
from ....widgets.camera.camera_grid import camera_of
from ....widgets.camera.click_marks import Moved, Picked, Placed
from .annotating import Annotating
from .annotation_facts import AnnotationFacts
from .blind_repeats import BlindRepeats
from .choosing import ADVANCES, Advance
from .landmark_rows import fit_words, landmark_rows, length_rows, limb_rows
from .marks import marks_of, predictions_in
from .swap_offers import SwapOffers

if TYPE_CHECKING:
    from ....shell.main_window import MainWindow

_KNOWN_BEFORE = frozenset({"outline", "shading", "wire", "reference", "correspondences"})
"""Overlays that would tell in a blind reading what is known already."""

_ADVANCE = "annotate/advance"
_DEPTH = "annotate/depth"


class AnnotateControl(QObject):
    """Brings views, panels and the presenters of clicking together.

    Attributes
    ----------
    annotating : Annotating
        The choice and the edits.
    facts : AnnotationFacts
        What is known about the clicks of the frame.
    cameras : CameraDoubts
        Whether a camera contradicts the others.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        self.annotating = Annotating(
            window.document, window.project, self._repeats, self.camera_at_hand, self._cameras
        )
        self.cameras = CameraDoubts(window.document, window.project)
        self.facts = AnnotationFacts(
            window.document, window.project, window.clouds, self.annotating, self._all_cameras,
            lambda: self.cameras.now,
        )  # fmt: skip
        self._offers = SwapOffers(self.annotating.swap)
        self._told: Message | None = None
        self._told_cameras: tuple[str, ...] = ()
        stored = stored_text(window.settings, _ADVANCE)
        self.annotating.advance = next((name for name in ADVANCES if name == stored), "landmark")
        self.facts.use_depth = bool(window.settings.value(_DEPTH, True, type=bool))
        window.body_panel.with_depth.setChecked(self.facts.use_depth)
        window.grid.set_keys(self._meaning)
        self._connect()

    def _connect(self) -> None:
        w = self._w
        w.grid.clicked.connect(self._on_clicked)
        w.grid.refused.connect(self._say)
        w.grid.space_tapped.connect(w.toggle_playing)
        w.grid.at_hand_changed.connect(self._on_view_at_hand)
        w.grid.kinds_changed.connect(self.facts.ask)
        w.grid.kinds_changed.connect(self.annotating.follow)
        w.spaces.changed.connect(self._on_workspace)
        w.project.opened.connect(self._on_workspace)
        w.project.closed.connect(self._on_workspace)
        w.instant.ready.connect(self.show)
        w.document.playing_changed.connect(self.facts.ask)
        w.landmarks_panel.chosen.connect(self.annotating.choose)
        w.body_panel.with_depth.toggled.connect(self._on_depth)
        self.annotating.said.connect(self._say)
        self.annotating.clicks_changed.connect(self._on_annotated)
        self.annotating.choice_changed.connect(self._on_annotated)
        self.facts.changed.connect(self.show)
        self.facts.failed.connect(w.show_error)
        self.cameras.changed.connect(self._on_cameras)
        self.cameras.failed.connect(w.show_error)
        w.messages.dismissed.connect(self._offers.dismiss)

    # ---- state, computed from facts

    @property
    def active(self) -> bool:
        """Whether clicks are placed: in the workspace for that."""
        workspace = self._w.workspace
        return workspace is not None and workspace.name == "annotate"

    def camera_at_hand(self) -> str:
        """The camera whose image the view at hand shows; empty where that takes no clicks."""
        return self._w.grid.cameras().get(self._w.grid.at_hand, "")

    def _repeats(self) -> BlindRepeats | None:
        return self._w.annotation.repeats

    def settled(self) -> bool:
        """Whether everything that was asked for is there."""
        return self.facts.settled() and self.cameras.settled()

    def _cameras(self) -> tuple[str, ...]:
        return tuple(name for name in self._w.grid.cameras().values() if name)

    def _all_cameras(self) -> tuple[str, ...]:
        """Cameras of all views, also those that are not shown now or show computed pictures."""
        tiles = self._w.grid.tiles.values()
        return tuple(camera_of(tile.view, tile.kind) or tile.view.image.camera for tile in tiles)

    # ---- showing

    @Slot()
    def show(self, _what: object = None) -> None:
        """Draw the clicks of the frame, when its pictures are there; fill the panels."""
        w = self._w
        told, recording = w.instant.told, w.document.recording
        if recording is None or told is None or told.frame_set.index != w.document.frame:
            return
        facts = self.facts.now()
        shown = [recording.cameras[name] for name in self._cameras()]
        w.grid.set_marks(marks_of(facts, shown))
        w.grid.set_hidden(_KNOWN_BEFORE if self.annotating.repeat() is not None else frozenset())
        self._show_offers()
        if self.active:
            cameras = self._all_cameras()
            w.landmarks_panel.show_rows(
                [(facts.views or {}).get(name, name) for name in cameras],
                landmark_rows(facts, cameras),
            )
            w.body_panel.show_body(fit_words(facts), limb_rows(facts), length_rows(facts))
            w.follower.show_fit(facts.fit)
        w.refresh_soon()

    @Slot()
    def _on_annotated(self) -> None:
        self.show()
        told = self._w.instant.told
        if told is None or told.frame_set.index != self._w.document.frame:
            return  # another frame is on its way
        # keys that follow a click at once find their commands ready
        for menu in ("&Annotate", "&Edit"):
            self._w.actions_book.refresh(menu)

    def _show_offers(self) -> None:
        hints = self.facts.hints() if self.active else None
        gone, new = self._offers.update(hints, self.facts.view_names())
        for message in gone:
            self._w.messages.take_back(message)
        for message in new:
            self._w.messages.show_message(message)

    @Slot()
    def _on_cameras(self) -> None:
        """Say which camera contradicts the others, before its clicks are blamed."""
        w = self._w
        found = self.cameras.findings(self.facts.view_names())
        doubtful = self._doubtful()
        w.follower.show_findings()
        w.rig.show_findings({name: one.what for one in found for name in doubtful})
        if doubtful != self._told_cameras:  # and not again while more is clicked
            self._told_cameras = doubtful
            if self._told is not None:
                w.messages.take_back(self._told)
            self._told = (
                Message("warning", found[0].what, remedy=found[0].remedy) if found else None
            )
            if self._told is not None:
                w.messages.show_message(self._told)
        self.show()

    def _doubtful(self) -> tuple[str, ...]:
        now = self.cameras.now
        if now is None:
            return ()
        return (now.camera,) if now.camera else now.others

    # ---- what a person does

    @Slot(object)
    def _on_clicked(self, what: Placed | Moved | Picked) -> None:
        if isinstance(what, Placed):
            seen = Visibility.GUESSED if what.guessed else Visibility.SEEN
            key = ClickKey(what.frame, what.camera, what.landmark)
            self.annotating.place(key, (what.x, what.y), seen)
        elif isinstance(what, Moved):
            key = ClickKey(what.frame, what.camera, what.landmark)
            self.annotating.move(key, (what.x, what.y))
        else:
            self.annotating.pick(ClickKey(what.frame, what.camera, what.landmark))

    def nudge(self, x: float, y: float) -> None:
        """Move the click in hand in the direction that the person sees; picture pixels."""
        held = self.annotating.held()
        for tile in self._w.grid.tiles.values():
            picture = tile.camera.picture
            if held is not None and picture is not None and picture.camera == held.camera:
                self.annotating.nudge(*tile.camera.raw_direction(x, y))
                return

    def why_no_annotating(self) -> str:
        """Why nothing can be clicked now, as a sentence."""
        why_not = self._w.project.why_no_edit()
        if why_not or self.active:
            return why_not
        return "This is done in the workspace Annotate (Alt+1)."

    def why_no_camera(self) -> str:
        """Why keys act on no image."""
        return "" if self.camera_at_hand() else "This view shows no camera's own image."

    def predictions_here(self) -> tuple[Prediction, ...]:
        """Prediction of the chosen landmark in the view at hand, where nobody has clicked it."""
        return self._predictions([self.camera_at_hand()])

    def predictions_everywhere(self) -> tuple[Prediction, ...]:
        """Predictions of the chosen landmark in all views where nobody has clicked it."""
        return self._predictions(self._cameras())

    def _predictions(self, cameras: Iterable[str]) -> tuple[Prediction, ...]:
        facts = self.facts.now()
        return tuple(
            one
            for camera in cameras
            for one in predictions_in(facts, camera)
            if one.landmark == facts.chosen and one.key not in self.annotating.clicks()
        )

    def accept_here(self) -> None:
        """Accept the prediction of the chosen landmark in the view at hand."""
        self.annotating.accept(self.predictions_here())

    def accept_everywhere(self) -> None:
        """Accept the predictions of the chosen landmark in all views."""
        self.annotating.accept(self.predictions_everywhere())

    def choose_advance(self, name: Advance) -> None:
        """Say what follows when a click was placed, and keep it for next time."""
        self.annotating.set_advance(name)
        self._w.settings.setValue(_ADVANCE, name)

    def advances_to(self, name: Advance) -> bool:
        """Whether this is what follows."""
        return self.annotating.advance == name

    def ask_sigma(self) -> None:
        """Let the person say how sure the click at hand is."""
        click = self.annotating.at_hand()
        if click is None:
            return
        dialog = QInputDialog(self._w)
        dialog.setWindowTitle("How sure is this click?")
        dialog.setLabelText("Standard deviation in pixels; 0: as usual for this landmark")
        dialog.setInputMode(QInputDialog.InputMode.DoubleInput)
        dialog.setDoubleDecimals(1)
        dialog.setDoubleRange(0.0, 500.0)
        dialog.setDoubleStep(0.5)
        dialog.setDoubleValue(click.sigma or 0.0)
        dialog.doubleValueSelected.connect(lambda px: self.annotating.set_sigma(px or None))
        dialog.open()

    def toggle_depth(self) -> None:
        """Fit with or without measured points."""
        box = self._w.body_panel.with_depth
        box.setChecked(not box.isChecked())

    def pick_last(self) -> None:
        """Take the click at hand in hand, and let keys go to its view."""
        self.annotating.pick_last()
        held = self.annotating.held()
        for name, camera in self._w.grid.cameras().items():
            if held is not None and camera == held.camera:
                self._w.grid.set_active(name)
                self._w.grid.tiles[name].camera.setFocus()

    def close(self) -> None:
        """End what works in the background."""
        self.facts.close()
        self.cameras.close()

    # ---- following

    @Slot()
    def _on_workspace(self) -> None:
        why_not = self._w.project.why_no_edit() if self.active else ""
        self._w.grid.set_clicking(self.active, why_not)
        self._w.body_panel.with_depth.setEnabled(self._w.clouds.available)
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
        self._w.settings.setValue(_DEPTH, wanted)
        self.facts.ask()

    def _meaning(self, keys: QKeySequence) -> Callable[[], None] | None:
        command = self._w.actions_book.local_of(keys)
        return self._w.actions_book.action(command.id).trigger if command is not None else None

    @Slot(str)
    def _say(self, words: str) -> None:
        if words == self._w.project.why_no_edit():
            self._w.messages.show_message(
                Message("warning", "This cannot be changed", remedy=words)
            )
        else:
            self._w.statusBar().showMessage(words, 6000)
