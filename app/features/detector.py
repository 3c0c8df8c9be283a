"""Installing the pretrained pose detector, in the background."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox

from stereotrack_core.pose_model.installation import (
    DOWNLOAD_BYTES,
    LICENCE,
    MODEL_FILES,
    SOURCE,
    Installation,
    install,
    installation,
)

from ..context import Context
from ..services.actions import Menu
from ..session.jobs import Job, NewestJob, Task
from ..session.messages import Message
from ..widgets.forms.form_dialog import ask_to_open

_ABOUT = (
    "The pose detector sees a person's shoulders, elbows, wrists, hips and head in single images, "
    "and tells front from back and left from right. It runs on this computer; no image leaves it."
)
_FILES = "Wheel of MediaPipe, archive, or one of the files (*.whl *.tgz *.tflite)"


class DetectorController:
    """Installs the detector."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self.job = NewestJob(context.tasks)

    def show(self) -> None:
        kept = sum(one.size for one in MODEL_FILES)
        facts = (
            f"Source: {SOURCE}",
            f"Licence: {LICENCE}",
            f"Size: {kept / 1e6:.0f} MB kept, {DOWNLOAD_BYTES / 1e6:.0f} MB downloaded",
        )
        state = installation()
        box = QMessageBox(self._context.docks.dialog_parent)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle("Pose detector")
        box.setText(_ABOUT)
        box.setInformativeText("\n".join((*facts, "", _how_it_is(state))))
        action = QMessageBox.ButtonRole.ActionRole
        again = box.addButton("Install again" if state.complete else "Install", action)
        again.clicked.connect(lambda: self.install())
        box.addButton("From file …", action).clicked.connect(self._ask)
        box.addButton(QMessageBox.StandardButton.Close)
        box.open()

    def _ask(self) -> None:
        def take(path: Path) -> None:
            self.install(path.parent if path.suffix == ".tflite" else path)

        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Install pose detector", Path.home(), _FILES, take)

    def install(self, source: Path | None = None) -> None:
        if self.job.busy:
            return

        def work(task: Task) -> Installation:
            return install(
                source, say=lambda text: task.report(0.0, text), cancelled=task.token.cancelled
            )

        self.job.run(Job("Installing the pose detector", work, self._on_installed))

    def _on_installed(self, state: Installation) -> None:
        wrong = bool(state.problem()[0])
        self._context.notifier.show(Message("warning" if wrong else "note", _how_it_is(state)))


def _how_it_is(state: Installation) -> str:
    what, remedy = state.problem()
    if "missing" in state.files.values():
        return "The pose detector is not installed."
    if what:
        return f"{what[0].upper()}{what[1:]}. {remedy}"
    return f"The pose detector is installed in {state.folder}."


def register(context: Context) -> DetectorController:
    """Offer the installation."""
    detector = DetectorController(context)
    command = Menu("&Track").command(
        "install_detector", "Install pose detector …", "Say what the pretrained pose detector is "
        "and whether it is installed, and install it.", detector.show, icon="prediction",
        why_not=lambda: "The pose detector is being installed." if detector.job.busy else "",
        section=True,
    )  # fmt: skip
    context.actions.add([command])
    return detector
