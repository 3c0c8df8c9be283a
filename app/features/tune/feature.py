"""Tune: trials beside a run, and presets."""

from __future__ import annotations

from functools import partial

from stereotrack_core.tracking.presets import PRESETS

from ...context import Context
from ...services.actions import Command
from ...services.layout import Workspace
from ...session.session import Session
from .controller import TuneController
from .presets import PresetWork

_MENU = "T&une"
_PRESETS = f"{_MENU}/Presets"


def register(context: Context) -> TuneController:
    """Offer the workspace Tune, its panels and its commands."""
    tuning = TuneController(context)
    context.docks.add_workspace(
        Workspace(
            "tune",
            "Tune",
            "Change settings, run trials on a stretch of frames, and compare them.",
            "settings",
            side=(
                ("scene",),
                ("parameters",),
                ("trials", "comparison", "runs", "inside"),
            ),
            bottom=("plot", "timeline"),
            side_share=0.40,
            bottom_shares=(0.20, 0.16),
            side_heights=(2, 4, 3),
            tall_side=True,
            why_not=context.session.not_tracked,
        )
    )
    context.actions.add(_commands(context.session, tuning))
    tuning.offer(context.actions)
    return tuning


def _commands(session: Session, tuning: TuneController) -> list[Command]:
    """Commands of the menu Tune."""
    chosen = tuning.with_selected

    def no_try() -> str:
        return session.not_tried() or session.tracker_works()

    def no_trial() -> str:
        return "" if tuning.trials.entries else "There is no trial. Change a parameter first."

    def unfinished() -> str:
        selected = tuning.selected()
        if selected is not None and selected is tuning.trials.running:
            return "This trial is still running. Wait for it to finish."
        return no_trial()

    return [
        Command(
            "trial_now", _MENU, "Run trial", "Track the selected frames with the present "
            "settings and show the result beside the run.",
            tuning.trials.run, "F9", "iterate", no_try,
        ),
        Command(
            "trial_live", _MENU, "Run trials automatically", "In the Tune workspace, track the "
            "selected frames again shortly after each parameter change.", tuning.toggle_live,
            checked=lambda: tuning.trials.live,
        ),
        Command(
            "trial_use", _MENU, "Use trial settings",
            "Use the settings of the selected trial from now on.",
            partial(chosen, tuning.use_settings_of), "Ctrl+F9", "settings", no_trial,
            section=True,
        ),
        Command(
            "trial_run", _MENU, "Make trial the active run",
            "Make the selected trial the active run, for "
            "the frames it covers.", partial(chosen, tuning.trials.make_run), "Alt+F9", "model",
            unfinished,
        ),
        Command(
            "trial_adopt", _MENU, "Save trial as preset …",
            "Save the settings of the selected trial as a preset of the project.",
            partial(chosen, tuning.presets.adopt), "Ctrl+Shift+F9", "accept",
            lambda: no_trial() or session.no_edit(),
        ),
        Command(
            "trial_dismiss", _MENU, "Discard trial",
            "Discard the selected trial.",
            partial(chosen, tuning.trials.discard), "Alt+Del", "delete", no_trial, section=True,
        ),
        Command(
            "trial_dismiss_all", _MENU, "Discard all trials",
            "Discard all trials.",
            tuning.trials.discard_all, "Alt+Shift+Del", "delete", no_trial,
        ),
        Command(
            "parameter_search", _MENU, "Search parameters", "Search parameters by name or "
            "description.", tuning.search_parameters, "Ctrl+F", "search", session.not_tracked,
            section=True,
        ),
        *_presets(session, tuning.presets),
    ]  # fmt: skip


def _presets(session: Session, presets: PresetWork) -> list[Command]:
    def not_own() -> str:
        name = session.track.preset
        if name in PRESETS:
            return f"{name} is a built-in preset and cannot be deleted."
        known = name in presets.own
        return session.no_edit() if known else f"The project has no preset {name}."

    return [
        Command(
            "preset_save", _PRESETS, "Save as preset …", "Save the present settings as a preset "
            "of the project.", presets.save, "", "save", session.no_edit,
        ),
        Command(
            "preset_load", _PRESETS, "Load preset …", "Load a preset from a file into the "
            "project.", presets.load, "", "open", session.no_edit,
        ),
        Command(
            "preset_export", _PRESETS, "Export preset …", "Save the settings to a file for "
            "stereotrack track --preset.", presets.export, "", "export",
        ),
        Command(
            "preset_delete", _PRESETS, "Delete preset",
            "Delete the selected preset from the project. The present settings are kept.",
            presets.delete, "", "delete", not_own,
        ),
    ]  # fmt: skip
