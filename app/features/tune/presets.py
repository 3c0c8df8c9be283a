"""Presets of the program, and those that a person keeps in the project or in files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QLineEdit,
    QWidget,
)

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
from ...widgets.forms.message import Message
from ...widgets.forms.parameter_panel import ParameterPanel


class PresetShelf(QObject):
    """Presets by name; a person's own are entries of the project, and every change is an edit.

    Signals
    -------
    changed : ()
        There are others than before.
    """

    changed = Signal()

    def __init__(self, project: ProjectPresenter) -> None:
        super().__init__()
        self._project = project
        self._known: tuple[str, ...] = ()
        project.opened.connect(self._look)
        project.closed.connect(self._look)
        project.changed.connect(self._look)

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the project's presets, the oldest first."""
        project = self._project.project
        return project.parameter_sets.names() if project is not None else ()

    @property
    def names(self) -> tuple[str, ...]:
        """All names, the program's own first."""
        return (*PRESETS, *self.own)

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
        return name if name in PRESETS else self.preset(name).base

    def problem_with(self, name: str) -> str:
        """Why a name cannot be given to a preset; empty where it can."""
        if not name.strip():
            return "The preset needs a name."
        if name.strip() in PRESETS:
            return f"{name.strip()} is a built-in preset. Choose another name."
        return ""

    def save(self, name: str, settings: Settings, base: str) -> bool:
        """Keep settings under a name; whether that was possible."""
        own = named(name.strip(), settings, base)
        return self._keep(own)

    def delete(self, name: str) -> None:
        """Take a preset away; that can be undone."""
        self._project.apply(DeleteEntry(PARAMETER_SET.name, name))

    def take_file(self, path: Path) -> str:
        """Keep the preset of a file in the project; its name, empty where that failed.

        Raises
        ------
        InputError
            Where the file holds no preset, or one of a name that is the program's.
        """
        own = read_preset(path)
        problem = self.problem_with(own.name)
        if problem:
            raise InputError(problem.rstrip("."), where=str(path), remedy="Give another name.")
        return own.name if self._keep(own) else ""

    def write_file(self, path: Path, name: str, settings: Settings, base: str) -> None:
        """Write settings as a file that ``--preset`` accepts; InputError where it cannot be."""
        write_preset(path, named(name, settings, base))

    def _keep(self, own: UserPreset) -> bool:
        edit = save_parameters(own.name, ParameterSet(own.base, own.values))
        return self._project.apply(edit) is not None or own.name in self.own

    @Slot()
    def _look(self, _what: object = None) -> None:
        if self.own != self._known:
            self._known = self.own
            self.changed.emit()


class NameDialog(QDialog):
    """Asks for the name of a preset, and says at once what is wrong with it.

    Parameters
    ----------
    title, what : str
        Title, and what is going to be named.
    name : str
        What is proposed.
    problem_with : callable
        From a name to a sentence that says why it will not do; empty where it will.
    taken : sequence of str
        Names that would be replaced.
    """

    def __init__(
        self,
        title: str,
        what: str,
        name: str,
        problem_with: Callable[[str], str],
        taken: tuple[str, ...],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._problem_with, self._taken = problem_with, taken
        self.name = QLineEdit(name)
        self.name.setAccessibleName("Name")
        self.name.selectAll()
        self.remark = QLabel()
        self.remark.setWordWrap(True)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        words = QLabel(what)
        words.setWordWrap(True)
        words.setMinimumWidth(320)
        layout = QFormLayout(self)
        layout.addRow(words)
        layout.addRow("Name", self.name)
        layout.addRow(self.remark)
        layout.addRow(self.buttons)
        self.name.textChanged.connect(self._look)
        self._look()

    def _look(self) -> None:
        name = self.name.text()
        problem = self._problem_with(name)
        replaced = name.strip() in self._taken
        self.remark.setText(
            problem or ("The existing preset with this name will be replaced." * replaced)
        )
        self.buttons.button(QDialogButtonBox.StandardButton.Save).setEnabled(not problem)


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
        self._ask_name("Save as preset", "Present settings", self._session.track.settings)

    def adopt(self) -> None:
        """Keep the settings of the selected attempt under a name, and go on with them."""
        entry = self._selected()
        if entry is not None and entry.settings is not None:
            self._ask_name("Save trial as preset", f"Settings of {entry.name}", entry.settings)

    def _ask_name(self, title: str, what: str, settings: Settings) -> None:
        own = self._session.track.preset
        proposed = own if own not in PRESETS else ""
        dialog = NameDialog(
            title, f"{what} will be saved as a preset of the project.", proposed,
            self.shelf.problem_with, self.shelf.own, self._context.docks.dialog_parent,
        )  # fmt: skip
        dialog.accepted.connect(lambda: self.keep(dialog.name.text().strip(), settings))
        dialog.open()

    def keep(self, name: str, settings: Settings) -> None:
        """Save settings as a preset of the project, and use it from now on."""
        if self.shelf.save(name, settings, self._base_name()):
            self.use(name)
            self._context.notifier.say(f"Preset {name} saved in the project.", 4000)

    def _base_name(self) -> str:
        name = self._session.track.preset
        try:
            return self.shelf.base_of(name)
        except InputError:  # the preset was deleted while its values are still shown
            return PRESETS[0]

    def load(self) -> None:
        """Take a preset from a file into the project."""
        dialog = QFileDialog(self._context.docks.dialog_parent, "Load preset")
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
        dialog = QFileDialog(self._context.docks.dialog_parent, "Export preset")
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
        said = Message(
            "note", f"Saved to {path.name}", remedy=f"stereotrack track … --preset {path}"
        )
        self._context.notifier.show(said)

    def delete(self) -> None:
        """Take the preset away that is chosen; its values stay as own settings."""
        self.shelf.delete(self._session.track.preset)
