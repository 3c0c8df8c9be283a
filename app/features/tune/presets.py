"""Presets of the program, and those that a person keeps in the project or in files."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal, Slot
from PySide6.QtWidgets import QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import DeleteEntry
from stereotrack_core.project.schema import PARAMETER_SET
from stereotrack_core.project.setups import ParameterSet, load_parameters, save_parameters
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import (
    PRESETS,
    UserPreset,
    named,
    preset,
    read_preset,
    write_preset,
)

from ...context import Context
from ...session.project import ProjectPresenter
from ...session.runs import RunEntry
from ...widgets.forms.form_dialog import FormDialog, ask_to_open, ask_to_save, line_edit
from ...widgets.forms.message import Message
from ...widgets.forms.parameter_panel import ParameterPanel
from ...widgets.style.building import hbox, label, label_of


class PresetShelf(QObject):
    """Presets by name; a person's own are entries of the project, and every change is an edit.

    Attributes
    ----------
    own : tuple of str
        Names of the project's presets, the oldest first.
    """

    changed = Signal()
    """There are others than before."""

    def __init__(self, project: ProjectPresenter) -> None:
        super().__init__()
        self._project = project
        self.own: tuple[str, ...] = ()
        for signal in (project.opened, project.closed, project.changed):
            signal.connect(self._look)

    def preset(self, name: str) -> UserPreset:
        """A preset of the project.

        Raises
        ------
        InputError
            Where there is none of that name, or a value is not accepted by this version.
        """
        project = self._project.project
        if project is None:
            raise InputError(
                "no project is open", remedy="Open or create a project to store the preset."
            )
        stored = load_parameters(project.parameter_sets, name)
        made = UserPreset(name, stored.preset, dict(stored.values))
        made.settings  # noqa: B018 - refuses what this version does not know
        return made

    def settings(self, name: str) -> Settings:
        """Values of a preset; see :meth:`preset`."""
        return preset(name) if name in PRESETS else self.preset(name).settings

    def base_of(self, name: str) -> str:
        """The program's preset that one is based on."""
        try:
            return name if name in PRESETS else self.preset(name).base
        except InputError:  # the preset was deleted while its values are still shown
            return PRESETS[0]

    def problem_with(self, name: str) -> str:
        """Why a name cannot be given to a preset; empty where it can."""
        if not name.strip():
            return "The preset needs a name."
        if name.strip() in PRESETS:
            return f"{name.strip()} is a built-in preset. Choose another name."
        return ""

    def keep(self, own: UserPreset) -> None:
        """Keep a preset in the project."""
        self._project.apply(save_parameters(own.name, ParameterSet(own.base, own.values)))

    def delete(self, name: str) -> None:
        """Take a preset away; that can be undone."""
        self._project.apply(DeleteEntry(PARAMETER_SET.name, name))

    @Slot()
    def _look(self, _what: object = None) -> None:
        project = self._project.project
        names = project.parameter_sets.names() if project is not None else ()
        if names != self.own:
            self.own = names
            self.changed.emit()


class NameDialog(FormDialog):
    """Asks for the name of a preset, and says at once what is wrong with it.

    Parameters
    ----------
    title, what : str
        Title, and what is going to be named.
    name : str
        What is proposed.
    shelf : PresetShelf
        Knows which names will not do, and which would be replaced.
    """

    def __init__(
        self, title: str, what: str, name: str, shelf: PresetShelf, parent: QWidget | None = None
    ) -> None:
        super().__init__(title, "Save", lambda: self.accept(), parent)
        self._shelf = shelf
        self.name = line_edit("Name", name)
        self.name.selectAll()
        self.name.textChanged.connect(self._look)
        self.lay_out(label(what), hbox(label_of(self.name, "&Name"), self.name), size=(360, 130))
        self._look()

    @Slot()
    def _look(self) -> None:
        name = self.name.text()
        problem, replaced = self._shelf.problem_with(name), name.strip() in self._shelf.own
        self.say(problem or ("The existing preset with this name will be replaced." * replaced))
        self.accept_button.setEnabled(not problem)


_FILES = "Preset (*.toml)"


class PresetWork(QObject):
    """What the commands about presets do."""

    def __init__(self, context: Context, parameters: ParameterPanel) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._parameters = parameters
        self.shelf = PresetShelf(context.session.project)
        self.shelf.changed.connect(self._on_changed)

    @Slot()
    def _on_changed(self) -> None:
        self._parameters.set_presets((*PRESETS, *self.shelf.own))
        self._parameters.set_preset(self._session.track.preset)

    @Slot(str)
    def use(self, name: str) -> None:
        """Take all values from a preset."""
        try:
            self._session.tracker.use_preset(name, self.shelf.settings(name))
        except InputError as error:
            self._context.notifier.error(error)
        self._parameters.set_preset(self._session.track.preset)

    def save(self) -> None:
        """Keep the settings under a name, in the project."""
        self._ask_name("Save as preset", "Present settings", self._session.track.settings)

    def adopt(self, entry: RunEntry) -> None:
        """Keep the settings of a trial under a name, and go on with them."""
        if entry.settings is not None:
            self._ask_name("Save trial as preset", f"Settings of {entry.name}", entry.settings)

    def _ask_name(self, title: str, what: str, settings: Settings) -> None:
        own = self._session.track.preset
        dialog = NameDialog(
            title,
            f"{what} will be saved as a preset of the project.",
            own if own not in PRESETS else "",
            self.shelf,
            self._context.docks.dialog_parent,
        )
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._keep(dialog.name.text().strip(), settings))
        dialog.open()

    def _keep(self, name: str, settings: Settings) -> None:
        """Save settings as a preset of the project, and use it from now on."""
        base = self.shelf.base_of(self._session.track.preset)
        if self._keep_and_use(named(name, settings, base)):
            self._context.notifier.say(f"Preset {name} saved in the project.", 4000)

    def _keep_and_use(self, own: UserPreset) -> bool:
        self.shelf.keep(own)
        kept = own.name in self.shelf.own
        if kept:
            self.use(own.name)
        return kept

    def load(self) -> None:
        """Take a preset from a file into the project."""
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Load preset", "", _FILES, self.take_file)

    def take_file(self, path: Path) -> None:
        """Take a preset from this file into the project, and use it."""
        try:
            own = read_preset(path)
            if problem := self.shelf.problem_with(own.name):
                raise InputError(problem.rstrip("."), where=str(path), remedy="Give another name.")
            self._keep_and_use(own)
        except InputError as error:
            self._context.notifier.error(error)

    def export(self) -> None:
        """Write the settings to a file that the command line takes as a preset."""
        parent = self._context.docks.dialog_parent
        ask_to_save(parent, "Export preset", "preset.toml", _FILES, self.write_file)

    def write_file(self, path: Path) -> None:
        """Write the settings to this file."""
        track = self._session.track
        path = path if path.suffix else path.with_suffix(".toml")
        name = path.stem if track.differs_from_preset or track.preset in PRESETS else track.preset
        try:
            write_preset(path, named(name, track.settings, self.shelf.base_of(track.preset)))
        except InputError as error:
            self._context.notifier.error(error)
            return
        remedy = f"stereotrack track … --preset {path}"
        self._context.notifier.show(Message("note", f"Saved to {path.name}", remedy=remedy))

    def delete(self) -> None:
        """Take the preset away that is chosen; its values stay as own settings."""
        self.shelf.delete(self._session.track.preset)
