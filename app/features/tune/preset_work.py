"""Presets that a person names, keeps with the project, and exchanges as files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Slot
from PySide6.QtWidgets import QFileDialog

from stereotrack_core.errors import InputError
from stereotrack_core.tracking.presets import PRESETS
from stereotrack_core.tracking.settings import Settings

from ...context import Context
from ...session.runs import RunEntry
from ...widgets.forms.message import Message
from ...widgets.forms.parameter_panel import ParameterPanel
from .dialogs import NameDialog
from .presets import PresetShelf

_FILES = "Preset (*.toml)"


class PresetWork(QObject):
    """What the commands about presets do.

    Parameters
    ----------
    context : Context
    parameters : ParameterPanel
    selected : callable
        The attempt whose settings may be adopted.
    """

    def __init__(
        self,
        context: Context,
        parameters: ParameterPanel,
        selected: Callable[[], RunEntry | None],
    ) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._parameters, self._selected = parameters, selected
        self.shelf = PresetShelf(context.session.project)
        self.shelf.changed.connect(self._on_changed)

    @Slot()
    def _on_changed(self) -> None:
        self._parameters.set_presets(self.shelf.names)
        self._parameters.set_preset(self._session.track.preset)

    @Slot(str)
    def use(self, name: str) -> None:
        """Take all values from a preset."""
        try:
            self._session.track.choose(name, self.shelf.settings(name))
        except InputError as error:
            self._context.notifier.error(error)
        self._parameters.set_preset(self._session.track.preset)

    def save(self) -> None:
        """Keep the settings under a name, in the project."""
        self._ask_name(
            "Save as preset", "The settings as they are now", self._session.track.settings
        )

    def adopt(self) -> None:
        """Keep the settings of the selected attempt under a name, and go on with them."""
        entry = self._selected()
        if entry is not None and entry.settings is not None:
            self._ask_name("Adopt as preset", f"The settings of {entry.name}", entry.settings)

    def _ask_name(self, title: str, what: str, settings: Settings) -> None:
        own = self._session.track.preset
        proposed = own if own not in PRESETS else ""
        dialog = NameDialog(
            title, f"{what} become a preset of the project.", proposed,
            self.shelf.problem_with, self.shelf.own, self._context.docks.dialog_parent,
        )  # fmt: skip
        dialog.accepted.connect(lambda: self.keep(dialog.name.text().strip(), settings))
        dialog.open()

    def keep(self, name: str, settings: Settings) -> None:
        """Save settings as a preset of the project, and use it from now on."""
        if self.shelf.save(name, settings, self._base_name()):
            self.use(name)
            self._context.notifier.say(f"The preset {name} is in the project.", 4000)

    def _base_name(self) -> str:
        name = self._session.track.preset
        try:
            return self.shelf.base_of(name)
        except InputError:  # the preset was deleted while its values are still shown
            return PRESETS[0]

    def load(self) -> None:
        """Take a preset from a file into the project."""
        dialog = QFileDialog(self._context.docks.dialog_parent, "Load a preset")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setNameFilter(_FILES)
        dialog.fileSelected.connect(lambda path: self.take_file(Path(path)))
        dialog.open()

    def take_file(self, path: Path) -> None:
        """Take a preset from this file into the project, and use it."""
        try:
            name = self.shelf.take_file(path)
        except InputError as error:
            self._context.notifier.error(error)
            return
        if name:
            self.use(name)

    def export(self) -> None:
        """Write the settings to a file that the command line takes as a preset."""
        dialog = QFileDialog(self._context.docks.dialog_parent, "Save the settings as a file")
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(_FILES)
        dialog.setDefaultSuffix("toml")
        dialog.fileSelected.connect(lambda path: self.write_file(Path(path)))
        dialog.open()

    def write_file(self, path: Path) -> None:
        """Write the settings to this file."""
        track = self._session.track
        name = path.stem if track.differs_from_preset or track.preset in PRESETS else track.preset
        try:
            self.shelf.write_file(path, name, track.settings, self._base_name())
        except InputError as error:
            self._context.notifier.error(error)
            return
        said = Message("note", f"Saved {path.name}", remedy=f"stereotrack track … --preset {path}")
        self._context.notifier.show(said)

    def delete(self) -> None:
        """Take the preset away that is chosen; its values stay as own settings."""
        self.shelf.delete(self._session.track.preset)
