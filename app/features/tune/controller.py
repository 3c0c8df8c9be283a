"""Tune: trials beside the run, their table, and presets."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import (
    ParameterSet,
    delete_entry,
    load_parameters,
    save_parameters,
)
from stereotrack_core.project.schema import PARAMETER_SET
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.study.store import effects, effects_words
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import (
    PRESETS,
    UserPreset,
    named,
    preset,
    read_preset,
    write_preset,
)
from stereotrack_core.tracking.tuning.stages import acts_without_depth

from ...context import Context
from ...services.actions import Command, Menu
from ...services.docks import Workspace
from ...session.changes import PROJECT, Part
from ...session.judgement import LOST_DEG, Judgement, arms_mean
from ...session.messages import Message
from ...session.runs import RunEntry
from ...session.session import Session, Snapshot, unless
from ...session.tracking import Chosen
from ...widgets.forms.form_dialog import ask_for_text, ask_to_open, ask_to_save
from ...widgets.forms.parameter_panel import ParameterPanel
from ...widgets.style.building import offer
from ...widgets.tables.panels import TRIAL_TIP, TrialsPanel, number_cell
from ...widgets.tables.table import Cell, CellRow

_WITHOUT_DEPTH = (
    "No view of this recording provides depth. Parameters that act on points of a cloud are hidden."
)
_LIVE, _LOOPS = "tune/live", "tune/loops"

_FILES = "Preset (*.toml)"
_FEWEST_TRIALS = 3  # from which something is said about the importance of parameters


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
        self._session.project.apply(delete_entry(PARAMETER_SET, self._session.track.preset))


class TuneController:
    """Shows parameters and trials, and does what a person wants with them."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.trials, self._runs = context.session.trials, context.session.runs
        self.parameters = parameters = ParameterPanel()
        self.panel = TrialsPanel(lambda row: self._runs.bring_to_front(self._entry(row)))
        context.docks.add("parameters", "Parameters", parameters)
        context.docks.add("trials", "Trials", self.panel)
        self.trials.live = bool(context.settings.value(_LIVE, True, type=bool))
        self.trials.loops = bool(context.settings.value(_LOOPS, True, type=bool))
        self.presets = PresetWork(context, parameters)
        self._compared = "preset"
        self._drawn: object = None
        parameters.settings_changed.connect(self._session.track.use)
        parameters.preset_box.textActivated.connect(self.presets.use)
        parameters.against_box.activated.connect(self._on_compared)
        context.docks.dock("parameters").visibilityChanged.connect(parameters.set_seen)
        # at once: keys that follow an undo find the fields ready
        known = Part.SETTINGS | Part.ACTIVE_RUN | Part.RECORDING_OPENED
        context.session.changes.watch(known, self._show_settings)
        tried = Part.TRIALS | Part.RUNS | Part.RUN_FRAMES | Part.JUDGEMENT | Part.WORKSPACE
        context.show(tried | Part.SELECTION | Part.FRAME, self._show_trials, "trials")
        context.session.changes.hear(Part.PARAMETER_WANTED, self._show_parameter)
        self._show_settings()

    # ---- showing

    def _entries(self) -> tuple[RunEntry, ...]:
        """The active run, then the other trials: the rows of the table."""
        run = self._runs.active
        trials = tuple(entry for entry in self.trials.entries if entry is not run)
        return (run, *trials) if run is not None else trials

    def _entry(self, row: int) -> RunEntry | None:
        entries = self._entries()
        return entries[row] if 0 <= row < len(entries) else None

    def _show_trials(self, now: Snapshot) -> None:
        if now.recording is None:
            return
        panel, trials, stretch = self.panel, self.trials, self.trials.stretch()
        how = ". Select others in the timeline with Shift+drag."
        if now.selection:
            how = ", as selected in the timeline."
        frames = f"Frames {stretch.start} to {stretch.stop - 1}{how}" if len(stretch) else ""
        unlike = trials.unlike(now.front)
        limits = [f"Not due to parameters: {' '.join(unlike)}"] if unlike else []
        if matters := effects_in_words(self._runs.active, trials.entries, now.judgements):
            limits.append(f"Importance for the arms: {matters}.")
        panel.show_words(trials.words(), frames, "\n".join(limits))
        running = trials.running
        done = (0, 0) if running is None else (len(running.frames), len(running.wanted))
        panel.show_progress(*done)
        entries = self._entries()
        drawn = [(one, one.name, len(one.frames), now.judgements.get(one)) for one in entries]
        if (drawn, now.front) != self._drawn:
            self._drawn = drawn, now.front
            run, *others = entries or (None,)
            chosen = entries.index(now.front) if now.front in entries else -1
            panel.show_table(*trial_table(run, others, now.judgements), chosen)

    def _show_settings(self) -> None:
        track, panel = self._session.track, self.parameters
        recording = self._session.document.recording
        base, against = track.base, "preset"
        if self._compared == "thesis":
            base, against = preset("thesis"), "thesis"
        elif self._compared == "run":
            run = self.trials.base()
            settings = run.made_with() if run is not None else None
            if settings is not None:
                base, against = settings, "run"
        panel.set_settings(track.settings, base, against)
        panel.set_preset(track.preset)
        # parameters that do nothing in the open recording are left out
        if recording is None or gives_depth(recording):
            panel.set_acting(lambda _name: True, "")
        else:
            panel.set_acting(acts_without_depth, _WITHOUT_DEPTH)

    # ---- what a person does

    def _on_compared(self) -> None:
        word = self._compared = self.parameters.against_box.currentData()
        self._show_settings()
        if self.parameters.against_box.currentData() != word:
            self._context.notifier.say("No run with known settings. Run the tracker first.", 4000)

    def toggle_live(self) -> None:
        self.trials.toggle_live()
        self._context.settings.setValue(_LIVE, self.trials.live)

    def toggle_loops(self) -> None:
        self.trials.toggle_loops()
        self._context.settings.setValue(_LOOPS, self.trials.loops)

    def with_selected(self, do: Callable[[RunEntry], None]) -> None:
        if self._runs.front is not None:
            do(self._runs.front)

    def use_settings_of(self, entry: RunEntry) -> None:
        if entry.settings is not None:
            self._session.track.use(entry.settings, f"use settings of trial {entry.name}")

    def search_parameters(self) -> None:
        self._context.docks.bring_up("parameters")
        self.parameters.focus_search()

    def _show_parameter(self, name: str) -> None:
        self._context.docks.show_named("tune")
        self.search_parameters()
        self.parameters.search.setText(name)


_UNKNOWN = "Not known here. Without depth there is no cloud to be explained."
_ERROR = ("arms °", "torso °", "lost %", "unexpl. %", "untracked")
_SIGMA = ("arms ± °", "torso ± °", "unexpl. %", "untracked")


def trial_table(
    run: RunEntry | None, trials: Sequence[RunEntry], judgements: Mapping[RunEntry, Judgement]
) -> tuple[tuple[str, ...], list[CellRow]]:
    """Headings, and cells of the run and of each trial, with differences from the run, if any."""
    entries = [entry for entry in (run, *trials) if entry is not None]
    other = judgements.get(run) if run is not None else None
    truth = all(j.measure == "error" for e in entries if (j := judgements.get(e)) is not None)
    tried = [_frames(judgements.get(entry)) for entry in trials]
    common = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *tried]))
    headings = _ERROR if truth else _SIGMA
    rows: list[CellRow] = []
    ones = (1,) * (len(headings) - 1)
    for entry in entries:
        judgement, is_run = judgements.get(entry), entry is run
        frames = common if is_run else _frames(judgement)
        both = np.intersect1d(frames, _frames(other))
        here = _values(None if is_run else judgement, both, truth)
        there = _values(other, both, truth)
        name = _two_lines(entry, is_run=is_run)
        values = _values(judgement, frames, truth)
        unknown = Cell("–", _UNKNOWN, "muted") if len(frames) else None
        numbers = [
            unknown if unknown and np.isnan(value) else number_cell(value, a - b, digits)
            for value, a, b, digits in zip(values, here, there, (*ones, 0), strict=True)
        ]
        rows.append((Cell(name, f"{entry.name}. {TRIAL_TIP}", bold=is_run), *numbers))
    return headings, rows if trials else []


def effects_in_words(
    run: RunEntry | None, trials: Sequence[RunEntry], judgements: Mapping[RunEntry, Judgement]
) -> str:
    """Importance of each parameter for the arms, over differences of trials from the run."""
    base = judgements.get(run) if run is not None else None
    own = run.made_with() if run is not None else None
    tried = [(e.settings, j) for e in trials if e.settings and (j := judgements.get(e))]
    if own is None or base is None or len(tried) < _FEWEST_TRIALS:
        return ""
    every = [own.values(), *(settings.values() for settings, _ in tried)]
    changes = [0.0]
    for _, judgement in tried:
        both = np.intersect1d(judgement.frame, base.frame)
        changes.append(arms_mean(judgement, both) - arms_mean(base, both))
    names = (name for name, value in own.values().items() if any(v[name] != value for v in every))
    factors = {name: [str(values[name]) for values in every] for name in names}
    return effects_words(effects(factors, np.array(changes)), "°")


def _two_lines(entry: RunEntry, *, is_run: bool) -> str:
    """Changed parameters or name of the run, and the frames below."""
    if is_run:
        return f"{entry.name}\nin these frames"
    done, wanted = len(entry.frames), entry.wanted
    if done < len(wanted):
        return f"{entry.name}\n{done} of {len(wanted)} frames"
    first, _, others = entry.name.partition(", ")
    return f"{first}\n{others or f'frames {wanted.start} – {wanted.stop - 1}'}"


def _values(judgement: Judgement | None, frames: IntArray, truth: bool) -> tuple[float, ...]:
    """Means over some frames in the order of the headings, of which less is better.

    Degrees of arms and torso, the share of the arms' segments that are lost (with a reference), the
    share of the cloud that is not explained, and frames without a pose; NaN where nothing is known.
    """
    if judgement is None or not len(frames):
        return (float("nan"),) * len(_ERROR if truth else _SIGMA)
    inside = np.isin(judgement.frame, frames)
    arms = judgement.arms[:, inside]
    lost = 100.0 * _mean(np.where(np.isfinite(arms), arms > LOST_DEG, np.nan))
    return (
        arms_mean(judgement, frames),
        _mean(judgement.limbs["torso"][inside]),
        *([lost] if truth else []),
        100.0 * _mean(judgement.unexplained_fraction[inside]),
        float(np.count_nonzero(~judgement.tracked[inside])),
    )


def _frames(judgement: Judgement | None) -> IntArray:
    return judgement.frame if judgement is not None else np.empty(0, dtype=np.int64)


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def register(context: Context) -> TuneController:
    """Offer the workspace Tune, its panels and its commands."""
    tuning = TuneController(context)
    space = Workspace(
        "tune", "Tune", "Change settings, run trials on a stretch of frames, and compare them.",
        "settings", side=(("parameters",), ("trials", "comparison", "runs", "inside", "scene")),
        bottom=("plot", "timeline"), side_share=0.40, bottom_shares=(0.20, 0.16),
        side_heights=(5, 4), tall_side=True, why_not=context.session.not_tracked,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context.session, tuning))
    action = context.actions.action
    names = ("use", "run", "adopt", "dismiss")
    offer(tuning.panel.buttons, [action(f"trial_{name}") for name in names])
    names = ("save", "load", "export", "delete")
    tuning.parameters.set_menu([action(f"preset_{name}") for name in names])
    return tuning


def _commands(session: Session, tuning: TuneController) -> list[Command]:
    chosen, trials = tuning.with_selected, tuning.trials

    def no_trial() -> str:
        return unless(trials.entries, "There is no trial. Change a parameter first.")

    def unfinished() -> str:
        if trials.running is not None and session.runs.front is trials.running:
            return "This trial is still running. Wait for it to finish."
        return no_trial()

    command = Menu("T&une", no_trial).command
    return [
        command("trial_now", "Run trial", "Track the selected frames with the present settings "
                "and show the result beside the run.", trials.run, "F9", "iterate",
                why_not=lambda: session.not_tried() or session.tracker_works()),
        command("trial_live", "Run trials automatically", "In the Tune workspace, track the "
                "selected frames again shortly after each parameter change.", tuning.toggle_live,
                why_not=lambda: "", checked=lambda: trials.live),
        command("trial_loops", "Loop worst frame of trial", "After each trial, play the frames "
                "around the one with the largest error of an arm in a loop.", tuning.toggle_loops,
                why_not=lambda: "", checked=lambda: trials.loops),
        command("trial_use", "Use trial settings", "Use the settings of the selected trial from "
                "now on.", partial(chosen, tuning.use_settings_of), "Ctrl+F9", "settings",
                section=True),
        command("trial_run", "Make trial the active run", "Make the selected trial the active "
                "run, for the frames it covers.", partial(chosen, trials.make_run), "Alt+F9",
                "model", why_not=unfinished),
        command("trial_adopt", "Save trial as preset …", "Save the settings of the selected trial "
                "as a preset of the project.", partial(chosen, tuning.presets.adopt),
                "Ctrl+Shift+F9", "accept", why_not=lambda: no_trial() or session.no_edit()),
        command("trial_dismiss", "Discard trial", "Discard the selected trial.",
                partial(chosen, trials.discard), "Alt+Del", "delete", section=True),
        command("trial_dismiss_all", "Discard all trials", "Discard all trials.",
                lambda: trials.discard(*trials.entries), "Alt+Shift+Del", "delete"),
        command("parameter_search", "Search parameters", "Search parameters by name or "
                "description.", tuning.search_parameters, "Ctrl+F", "search",
                why_not=session.not_tracked, section=True),
        *_presets(session, tuning.presets),
    ]  # fmt: skip


def _presets(session: Session, presets: PresetWork) -> list[Command]:
    def not_own() -> str:
        name = session.track.preset
        if name in PRESETS:
            return f"{name} is a built-in preset and cannot be deleted."
        none = f"The project has no preset {name}."
        return unless(name in presets.own, none) or session.no_edit()

    command = Menu("T&une/Presets", session.no_edit).command
    return [
        command("preset_save", "Save as preset …", "Save the present settings as a preset of the "
                "project.", presets.save, "", "save"),
        command("preset_load", "Load preset …", "Load a preset from a file into the project.",
                presets.load, "", "open"),
        command("preset_export", "Export preset …", "Save the settings to a file for stereotrack "
                "track --preset.", presets.export, "", "export", why_not=lambda: ""),
        command("preset_delete", "Delete preset", "Delete the selected preset from the project. "
                "The present settings are kept.", presets.delete, "", "delete", why_not=not_own),
    ]  # fmt: skip
