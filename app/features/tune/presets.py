"""Presets of the program, and those that a person keeps in the project or in files."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.interop.preset_file import read_preset, write_preset
from stereotrack_core.project.entries import DeleteEntry
from stereotrack_core.project.schema import PARAMETER_SET
from stereotrack_core.project.setups import ParameterSet, load_parameters, save_parameters
from stereotrack_core.tracking.presets import PRESETS, UserPreset, named, preset
from stereotrack_core.tracking.settings import Settings

from ...session.project_file import ProjectPresenter


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
            raise InputError("no project is open", remedy="Open one that holds the preset.")
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
            return f"{name.strip()} is a preset of the program."
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
