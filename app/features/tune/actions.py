"""Commands about attempts and presets."""

from __future__ import annotations

from stereotrack_core.tracking.presets import PRESETS

from ...services.actions import Command
from ...session.session import Session
from .controller import TuneController
from .presets import PresetWork

_MENU = "T&une"
_PRESETS = f"{_MENU}/Presets"


def commands(session: Session, tuning: TuneController) -> list[Command]:
    """Commands of the menu Tune."""

    def no_try() -> str:
        return session.no_depth() or session.tracker_works()

    def no_attempt() -> str:
        return "" if tuning.attempts.entries else "There is no attempt: change a parameter first."

    def unfinished() -> str:
        selected = tuning.selected()
        if selected is not None and selected is tuning.attempts.running:
            return "This attempt is still in progress."
        return no_attempt()

    return [
        Command(
            "attempt_now", _MENU, "Try the settings", "Track the selected frames with the settings "
            "as they are, beside the run.", tuning.attempts.try_now, "F9", "iterate", no_try,
        ),
        Command(
            "attempt_live", _MENU, "Try changes at once", "Track the selected frames again a "
            "moment after a parameter was changed, in the workspace Tune.", tuning.toggle_live,
            checked=lambda: tuning.attempts.live,
        ),
        Command(
            "attempt_use", _MENU, "Take its settings", "Go on with the settings of the selected "
            "attempt.", tuning.take_settings_of_selected, "Ctrl+F9", "settings", no_attempt,
            section=True,
        ),
        Command(
            "attempt_run", _MENU, "Make it the run", "Make the selected attempt the active run, "
            "over the frames that it has.", tuning.make_selected_the_run, "Alt+F9", "model",
            unfinished,
        ),
        Command(
            "attempt_compare", _MENU, "Compare with it", "State the differences of all attempts "
            "from the selected one.", tuning.compare_with_selected, "Shift+F9", "compare",
            unfinished,
        ),
        Command(
            "attempt_adopt", _MENU, "Adopt as preset …", "Keep the settings of the selected "
            "attempt as a preset of the project.", tuning.presets.adopt, "Ctrl+Shift+F9", "accept",
            lambda: no_attempt() or session.no_edit(),
        ),
        Command(
            "attempt_dismiss", _MENU, "Dismiss", "Take the selected attempt away.",
            tuning.dismiss_selected, "Alt+Del", "delete", no_attempt, section=True,
        ),
        Command(
            "attempt_dismiss_all", _MENU, "Dismiss all", "Take all attempts away.",
            tuning.attempts.dismiss_all, "Alt+Shift+Del", "delete", no_attempt,
        ),
        Command(
            "parameter_search", _MENU, "Search parameters", "Look for a parameter by its name or "
            "explanation.", tuning.search_parameters, "Ctrl+F", "search", session.no_depth,
            section=True,
        ),
        *_presets(session, tuning.presets),
    ]  # fmt: skip


def _presets(session: Session, presets: PresetWork) -> list[Command]:
    def not_own() -> str:
        name = session.track.preset
        if name in PRESETS:
            return f"{name} is a preset of the program."
        known = name in presets.shelf.own
        return session.no_edit() if known else f"The project has no preset {name}."

    return [
        Command(
            "preset_save", _PRESETS, "Save as preset …", "Keep the settings under a name, in the "
            "project.", presets.save, "", "save", session.no_edit,
        ),
        Command(
            "preset_load", _PRESETS, "Load from a file …", "Take a preset from a file into the "
            "project.", presets.load, "", "open", session.no_edit,
        ),
        Command(
            "preset_export", _PRESETS, "Save to a file …", "Write the settings to a file that "
            "stereotrack track takes with --preset.", presets.export, "", "export",
        ),
        Command(
            "preset_delete", _PRESETS, "Delete this preset", "Take the chosen preset out of the "
            "project; its values stay.", presets.delete, "", "delete", not_own,
        ),
    ]  # fmt: skip
