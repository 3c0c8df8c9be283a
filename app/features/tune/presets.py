"""Presets of the program, and those that a person keeps in the project or in files."""

from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import (
    DeleteEntry,
    ParameterSet,
    load_parameters,
    save_parameters,
)
from stereotrack_core.project.schema import PARAMETER_SET
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
from ...session.changes import PROJECT, Part
from ...session.messages import Message
from ...session.runs import RunEntry
from ...session.tracking import Chosen
from ...widgets.forms.form_dialog import ask_for_text, ask_to_open, ask_to_save
from ...widgets.forms.parameter_panel import ParameterPanel

_FILES = "Preset (*.toml)"


class PresetWork:
    """Presets by name; a person's own are entries of the project, and every change is an edit."""

    def __init__(self, context: Context, parameters: ParameterPanel) -> None:
        self._context, self._session = context, context.session
        self._parameters = parameters
        self.own: tuple[str, ...] = ()
        context.session.changes.watch(PROJECT | Part.EDIT, self._look)

    def _look(self) -> None:
        project = self._session.project.project
        names = project.parameter_sets.names() if project is not None else ()
        if names != self.own:
            self.own = names
            self._parameters.set_presets((*PRESETS, *names))
            self._parameters.set_preset(self._session.track.preset)

    def settings(self, name: str) -> Settings:
        """Values of a preset. Raises InputError if there is none, or a value is not accepted."""
        return preset(name) if name in PRESETS else self._stored(name).settings

    def _stored(self, name: str) -> UserPreset:
        project = self._session.project.project
        if project is None:
            raise InputError(
                "no project is open", remedy="Open or create a project to store the preset."
            )
        stored = load_parameters(project.parameter_sets, name)
        return UserPreset(name, stored.preset, dict(stored.values))

    def _base(self) -> str:
        name = self._session.track.preset
        try:
            return name if name in PRESETS else self._stored(name).base
        except InputError:  # the preset was deleted while its values are still shown
            return PRESETS[0]

    def use(self, name: str) -> None:

        def take() -> None:
            settings = self.settings(name)
            self._session.track.take(Chosen(name, settings, settings), f"use preset {name}")

        self._context.notifier.attempt(take)
        self._parameters.set_preset(self._session.track.preset)

    def save(self) -> None:
        self._ask_name("Save as preset", "Present settings", self._session.track.settings)

    def adopt(self, entry: RunEntry) -> None:
        if entry.settings is not None:
            self._ask_name("Save trial as preset", f"Settings of {entry.name}", entry.settings)

    def _ask_name(self, title: str, what: str, settings: Settings) -> None:
        own, parent = self._session.track.preset, self._context.docks.dialog_parent
        words = (
            f"{what} will be saved as a preset of the project.\nA preset of the same name will be "
            "replaced.\n\nName:"
        )
        proposed = own if own not in PRESETS else ""
        keep = lambda name: self.keep(name.strip(), settings)  # noqa: E731
        ask_for_text(parent, title, words, keep, proposed)

    def keep(self, name: str, settings: Settings) -> None:
        keep = lambda: self._keep_and_use(named(name, settings, self._base()))  # noqa: E731
        if self._context.notifier.attempt(keep):
            self._context.notifier.say(f"Preset {name} saved in the project.", 4000)

    def _keep_and_use(self, own: UserPreset, where: str = "") -> None:
        """Keep a preset in the project and use it. Raises InputError for a name of another."""
        if not own.name or own.name in PRESETS:
            what = f"{own.name} is a built-in preset" if own.name else "the preset has no name"
            raise InputError(what, where=where, remedy="Give another name.")
        values = ParameterSet(own.base, own.values)
        if self._session.project.apply(save_parameters(own.name, values)) is not None:
            self.use(own.name)

    def load(self) -> None:
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Load preset", "", _FILES, self.take_file)

    def take_file(self, path: Path) -> None:
        self._context.notifier.attempt(lambda: self._keep_and_use(read_preset(path), str(path)))

    def export(self) -> None:
        parent = self._context.docks.dialog_parent
        ask_to_save(parent, "Export preset", "preset.toml", _FILES, self.write_file)

    def write_file(self, path: Path) -> None:
        track = self._session.track
        path = path if path.suffix else path.with_suffix(".toml")
        own_name = track.settings == track.base and track.preset not in PRESETS
        name = track.preset if own_name else path.stem
        own = named(name, track.settings, self._base())
        if self._context.notifier.attempt(lambda: write_preset(path, own)):
            remedy = f"stereotrack track … --preset {path}"
            self._context.notifier.show(Message("note", f"Saved to {path.name}", remedy=remedy))

    def delete(self) -> None:
        self._session.project.apply(DeleteEntry(PARAMETER_SET.name, self._session.track.preset))
