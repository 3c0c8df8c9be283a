"""Tune: trials beside the run, their table, and presets."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.tuning.stages import acts_without_depth
from stereotrack_core.tracking.tuning.trial import Trial

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.changes import Part
from ...session.judgement import LOST_DEG, Judgement
from ...session.runs import RunEntry
from ...session.session import Session, unless
from ...widgets.forms.parameter_panel import ParameterPanel
from ...widgets.tables.panels import TRIAL_TIP, TrialsPanel, number_cell
from ...widgets.tables.table import Cell, CellRow
from .presets import PresetWork
from .trials import TrialPresenter, TrialRunner

_SECONDS = 2.0
"""Length of the stretch around the frame where neither a selection nor the zoom says another."""

_LONGEST_SECONDS = 10.0
_WITHOUT_DEPTH = (
    "No view of this recording provides depth. Parameters that act on points of a cloud are hidden."
)
_TOUCHED = "tune/parameter"


class TuneController:
    """Connects what is tried with the panels, the views and the project."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        session = context.session
        self.parameters = ParameterPanel()
        self.panel = TrialsPanel(
            self._on_trial_chosen, lambda row: self.trials.discard(self._entry(row))
        )
        context.docks.add("parameters", "Parameters", self.parameters)
        context.docks.add("trials", "Trials", self.panel)
        self.runner = TrialRunner(session, context.tasks, self._to_prepare)
        self.trials = TrialPresenter(session, self.runner, self.stretch, self.show)
        self.trials.live = bool(context.settings.value("tune/live", True, type=bool))
        self.presets = PresetWork(context, self.parameters)
        self.parameters.last_touched = str(context.settings.value(_TOUCHED, ""))
        self._compared = "preset"
        self._connect()
        self.show_settings()

    def _connect(self) -> None:
        parameters = self.parameters
        parameters.settings_changed.connect(self._session.track.use)
        keep = self._context.settings.setValue
        parameters.settings_changed.connect(lambda _: keep(_TOUCHED, parameters.last_touched))
        parameters.preset_box.textActivated.connect(self.presets.use)
        parameters.against_box.activated.connect(self._on_compared)
        context, session = self._context, self._session
        docks, watch = context.docks, session.changes.watch
        docks.dock("trials").visibilityChanged.connect(self.show)
        docks.dock("parameters").visibilityChanged.connect(self.parameters.set_seen)
        watch(Part.ACTIVE_RUN | Part.SELECTION | Part.WORKSPACE, self.runner.make_clouds_soon)
        progress = Part.RUN_FRAMES | Part.SELECTION | Part.FRAME
        watch(progress, lambda: docks.redraw.soon(self.show_progress))
        watch(Part.SETTINGS, self._on_settings)
        watch(Part.JUDGEMENT, lambda: docks.redraw.soon(self.show))
        watch(Part.ACTIVE_RUN, self.show_settings)
        watch(Part.WORKSPACE, self._on_workspace)
        watch(Part.LEAVING, self.stop)
        watch(Part.RECORDING_OPENED, self._show_acting)
        context.tasks.watch(self.trials.settled)

    # ---- facts

    @property
    def active(self) -> bool:
        return self._context.docks.workspace == "tune"

    def stretch(self) -> range:
        """Frames to try on: the selection, else what is visible, else two seconds here."""
        context = self._context
        recording, count = context.session.document.recording, context.session.document.frame_count
        if recording is None or not count:
            return range(0)
        if context.view_state.selection:
            return context.view_state.selection
        scale = context.docks.timeline.scale
        seen = range(max(int(scale.first), 0), min(round(scale.last), count))
        if not scale.is_whole and len(seen) and len(seen) <= _LONGEST_SECONDS * recording.fps:
            return seen
        length = min(max(round(_SECONDS * recording.fps), 2), count)
        first = min(max(context.session.document.frame - length // 2, 0), count - length)
        return range(first, first + length)

    def _mark(self) -> None:
        """Select the stretch on which something is going to be tried, so that it stays."""
        stretch = self.stretch()
        if not self._context.view_state.selection and len(stretch):
            self._context.view_state.select(stretch)

    def selected(self) -> RunEntry | None:
        trials, chosen = self.trials.entries, self._entry(self.panel.row)
        return chosen if chosen in trials else (trials[-1] if trials else None)

    def with_selected(self, do: Callable[[RunEntry], None]) -> None:
        entry = self.selected()
        if entry is not None:
            do(entry)

    def _entries(self) -> tuple[RunEntry, ...]:
        run = self._session.runs.active
        trials = tuple(entry for entry in self.trials.entries if entry is not run)
        return (run, *trials) if run is not None else trials

    def _entry(self, row: int) -> RunEntry | None:
        entries = self._entries()
        return entries[row] if 0 <= row < len(entries) else None

    def _to_prepare(self) -> Trial | None:
        idle = self.active and self.trials.settled() and not self._session.track.running
        return self.trials.wanted() if idle and self.trials.base() is not None else None

    # ---- showing

    def show(self) -> None:
        self.show_progress()
        if not self.panel.isVisible() or self._session.document.recording is None:
            return
        run, *others = self._entries() or (None,)
        known = self._session.judging.all()
        self.panel.show_table(*trial_table(run, others, known))

    def show_progress(self) -> None:
        context, panel = self._context, self.panel
        if not context.docks.is_seen("trials") or context.session.document.recording is None:
            return
        running, stretch = self.trials.running, self.stretch()
        how = ". Select others in the timeline with Shift+drag."
        if context.view_state.selection:
            how = ", as selected in the timeline."
        frames = f"Frames {stretch.start} to {stretch.stop - 1}{how}" if len(stretch) else ""
        unlike = self.trials.unlike(self.selected())
        limits = f"Not due to parameters: {' '.join(unlike)}" if unlike else ""
        panel.show_words(self.trials.words(), frames, limits)
        done = (0, 0) if running is None else (len(running.frames), len(running.wanted))
        panel.show_progress(*done)

    def show_settings(self) -> None:
        track, panel = self._session.track, self.parameters
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
        self._show_acting()

    def _show_acting(self) -> None:
        """Leave out parameters that do nothing in the open recording."""
        recording = self._session.document.recording
        if recording is None or gives_depth(recording):
            self.parameters.set_acting(lambda _name: True, "")
        else:
            self.parameters.set_acting(acts_without_depth, _WITHOUT_DEPTH)

    def _on_compared(self) -> None:
        word = self._compared = self.parameters.against_box.currentData()
        self.show_settings()
        if self.parameters.against_box.currentData() != word:
            self._context.notifier.say("No run with known settings. Run the tracker first.", 4000)

    # ---- what a person does

    def _on_trial_chosen(self, row: int) -> None:
        self._session.runs.bring_to_front(self._entry(row))
        self._context.actions.refresh_soon()

    def _on_settings(self) -> None:
        if self.parameters.settings is not self._session.track.settings:
            self.show_settings()
        self._context.actions.refresh_soon()
        if self.active:
            if self.trials.live:
                self._mark()
            self.trials.on_settings()
        elif self.trials.running is not None:
            self.trials.cancel()

    def _on_workspace(self) -> None:
        if not self.active:
            self.trials.cancel()
        self.show()

    def toggle_live(self) -> None:
        self.trials.live = not self.trials.live
        self._context.settings.setValue("tune/live", self.trials.live)
        self.show()

    def use_settings_of(self, entry: RunEntry) -> None:
        if entry.settings is not None:
            self._session.track.use(entry.settings, f"use settings of trial {entry.name}")

    # ---- coming and going

    def search_parameters(self) -> None:
        self._context.docks.bring_up("parameters")
        self.parameters.focus_search()

    def stop(self) -> None:
        self.runner.cancel()
        self.trials.stop()


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
    arms = np.array([v[inside] for limb, v in judgement.limbs.items() if "arm" in limb])
    known = arms[np.isfinite(arms)]
    lost = 100.0 * _mean((known > LOST_DEG).astype(np.float64))
    return (
        _mean(known),
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
        "settings", side=(("scene",), ("parameters",), ("trials", "comparison", "runs", "inside")),
        bottom=("plot", "timeline"), side_share=0.40, bottom_shares=(0.20, 0.16),
        side_heights=(2, 4, 3), tall_side=True, why_not=context.session.not_tracked,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context.session, tuning))
    action = context.actions.action
    names = ("use", "run", "adopt", "dismiss")
    tuning.panel.set_actions([action(f"trial_{name}") for name in names])
    names = ("save", "load", "export", "delete")
    tuning.parameters.set_menu([action(f"preset_{name}") for name in names])
    return tuning


def _commands(session: Session, tuning: TuneController) -> list[Command]:
    chosen = tuning.with_selected

    def no_trial() -> str:
        return unless(tuning.trials.entries, "There is no trial. Change a parameter first.")

    def unfinished() -> str:
        selected = tuning.selected()
        if selected is not None and selected is tuning.trials.running:
            return "This trial is still running. Wait for it to finish."
        return no_trial()

    command = Menu("T&une", no_trial).command
    trials = tuning.trials
    return [
        command("trial_now", "Run trial", "Track the selected frames with the present settings "
                "and show the result beside the run.", trials.run, "F9", "iterate",
                why_not=lambda: session.not_tried() or session.tracker_works()),
        command("trial_live", "Run trials automatically", "In the Tune workspace, track the "
                "selected frames again shortly after each parameter change.", tuning.toggle_live,
                why_not=lambda: "", checked=lambda: trials.live),
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
