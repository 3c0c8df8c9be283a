"""Tune: trials beside a run, and presets."""

from functools import partial

from stereotrack_core.tracking.presets import PRESETS

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.session import Session, unless
from .controller import TuneController
from .presets import PresetWork


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
