"""Installing the pretrained pose detector, in the background."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QDialogButtonBox, QFormLayout, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.installation import (
    DOWNLOAD_BYTES,
    LICENCE,
    MODEL_FILES,
    SOURCE,
    Installation,
    install,
    installation,
)

from ...context import Context
from ...services.actions import Menu
from ...services.tasks.task import Task
from ...widgets.forms.form_dialog import FormDialog, ask_to_open, push_button
from ...widgets.forms.message import Message
from ...widgets.style.building import label

_ABOUT = (
    "The pose detector sees a person's shoulders, elbows, wrists, hips and head in single images, "
    "and tells front from back and left from right. It runs on this computer; no image leaves it."
)
_FILES = "Wheel of MediaPipe, or one of the files (*.whl *.tflite)"


class DetectorController(QObject):
    """Installs the detector.

    Signals
    -------
    changed : ()
        An installation has begun or ended.
    """

    changed = Signal()

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context = context
        self._task: Task | None = None
        self.failure = ""
        """Why the latest installation failed, as sentences."""

    @property
    def working(self) -> bool:
        """Whether the detector is being installed."""
        return self._task is not None

    def show(self) -> None:
        """Show what the detector is, whether it is installed, and let the person install it."""
        DetectorDialog(self, self._context.docks.dialog_parent).open()

    def install(self, source: Path | None = None) -> None:
        """Install it in the background, from a wheel or folder, or from the network."""
        if self._task is not None:
            return
        self.failure = ""

        def work(task: Task) -> Installation:
            return install(
                source, say=lambda text: task.report(0.0, text), cancelled=task.token.cancelled
            )

        self._task = self._context.tasks.begin(
            "Installing the pose detector", work, self._on_installed, self._on_failed
        )
        self._task.ended.connect(self._on_ended)
        self.changed.emit()

    def stop(self) -> None:
        """Stop the download."""
        if self._task is not None:
            self._task.cancel()

    def _on_installed(self, state: Installation) -> None:
        what, remedy = state.problem()
        message = f"{what[0].upper()}{what[1:]}" if what else "The pose detector is installed"
        self._context.notifier.show(Message("warning" if what else "note", message, remedy=remedy))

    def _on_failed(self, error: Exception) -> None:
        self.failure = str(error)
        if isinstance(error, InputError):
            self._context.notifier.error(error)
        else:
            self._context.tasks.failed.emit(error)

    def _on_ended(self) -> None:
        self._task = None
        self.changed.emit()
        self._context.actions.refresh()


class DetectorDialog(FormDialog):
    """Dialog that describes the detector and installs it."""

    def __init__(self, controller: DetectorController, parent: QWidget | None = None) -> None:
        super().__init__("Pose detector", "Install", self._install, parent, close=True)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._controller = controller
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.from_file = push_button("From file …", self._ask)
        self.from_file.setToolTip("Install from a wheel or files that you have, without a network")
        self.accept_button.setToolTip("Download the wheel with pip, check it, and keep the files")
        self.stop_button = push_button("Stop", controller.stop)
        self.buttons.addButton(self.from_file, role)
        self.buttons.addButton(self.stop_button, role)
        kept = sum(one.size for one in MODEL_FILES)
        facts = QFormLayout()
        for name, text in (
            ("Source", SOURCE),
            ("Licence", LICENCE),
            ("Size", f"{kept / 1e6:.0f} MB kept, {DOWNLOAD_BYTES / 1e6:.0f} MB downloaded"),
        ):
            facts.addRow(name, label(text))
        self.lay_out(label(_ABOUT), facts, size=(560, 270))
        controller.changed.connect(self._show_state)
        self._show_state()

    def _install(self) -> None:
        self._controller.install()

    def _ask(self) -> None:
        def take(path: Path) -> None:
            self._controller.install(path.parent if path.suffix == ".tflite" else path)

        ask_to_open(self, "Install pose detector", Path.home(), _FILES, take)

    def _show_state(self) -> None:
        """Say whether it is installed, and offer what can be done now."""
        working, state = self._controller.working, installation()
        for button in (self.accept_button, self.from_file):
            button.setEnabled(not working)
        self.stop_button.setVisible(working)
        self.accept_button.setText("Install again" if state.complete else "Install")
        what, remedy = state.problem()
        if working:
            self.say("Installing … You can close this and go on working.")
        elif self._controller.failure:
            self.say(self._controller.failure, error=True)
        elif "missing" in state.files.values():
            self.say("It is not installed.")
        elif what:
            self.say(f"{what[0].upper()}{what[1:]}. {remedy}", error=True)
        else:
            self.say(f"It is installed in {state.folder}.")


def register(context: Context) -> DetectorController:
    """Offer the installation."""
    detector = DetectorController(context)
    command = Menu("&Track").command(
        "install_detector",
        "Install pose detector …",
        "Show what the pretrained pose detector is and whether it is installed, and install it.",
        detector.show,
        icon="prediction",
        section=True,
    )
    context.actions.add([command])
    return detector
