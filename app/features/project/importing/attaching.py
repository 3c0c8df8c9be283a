"""Give the open recording the cameras of a calibration file in place of its own."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QWidget

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing.choices import Choices, Source, Use
from stereotrack_core.recording.importing.making import cameras_for

from ....context import Context
from ....session.replacing import replace_cameras
from ....widgets.forms.form_dialog import FormDialog, ask_to_open
from .calibration_page import FILES, CalibrationPage


def ask_to_attach(context: Context) -> None:
    """Let the person choose a file; ask on only where it does not tell which camera is which."""
    recording, parent = context.session.document.recording, context.docks.dialog_parent
    if recording is None:
        return

    def attach(cameras: Mapping[str, Camera]) -> None:
        if recording is context.session.document.recording:
            replace_cameras(context.session, cameras, "The calibration is attached")

    def show(path: Path) -> None:
        AttachDialog(recording, path, attach, parent).show_or_attach()

    ask_to_open(parent, "Attach a calibration", recording.folder, FILES, show)


class AttachDialog(FormDialog):
    """Asks what a calibration file leaves open: its cameras, unit and convention."""

    def __init__(
        self,
        recording: Recording,
        path: Path,
        attach: Callable[[Mapping[str, Camera]], None],
        parent: QWidget,
    ) -> None:
        super().__init__("Attach a calibration", "Attach", self._take, parent)
        self._attach, self._choices = attach, _choices_of(recording)
        self.page = CalibrationPage(self._choices, recording.folder)
        self.page.completeChanged.connect(self._on_changed)
        self.lay_out((self.page, 1), size=(640, 480))
        self.open_questions = not self.page.use_file(path)

    def show_or_attach(self) -> None:
        if self.open_questions or not self.page.isComplete():
            self._on_changed()
            self.open()
        else:
            self._take()

    def _on_changed(self) -> None:
        self.accept_button.setEnabled(self.page.isComplete())

    def _take(self) -> None:
        chosen = self.page.chosen(self._choices)
        known = cameras_for(chosen)
        ours = {name: chosen.cameras.get(name, name) for name in chosen.camera_names()}
        cameras = {name: replace(known[theirs], name=name) for name, theirs in ours.items()}
        if self.attempt(lambda: self._attach(cameras)):
            self.accept()


def _choices_of(recording: Recording) -> Choices:
    """The recording as if it were to be made: its cameras, and the sizes of their images."""
    turned = {
        one.camera: view.display_rotation
        for view in recording.views
        for one in view.streams().values()
        if one.camera
    }
    uses = tuple(
        Use(
            Source(name, recording.folder, "video", own.width, own.height, 0, turned=turned[name]),
            view=name,
        )
        for name, own in recording.cameras.items()
        if name in turned
    )
    return Choices(recording.name, uses, recording.fps)
