"""Commands about the stretches in which a run fails."""

from __future__ import annotations

from ....services.actions import Command
from .controller import EpisodeController

_GO, _TRACK = "&Go", "&Track/&Failures"


def commands(e: EpisodeController) -> list[Command]:
    """Commands of the menus Go and Track, Episodes."""
    return [
        Command(
            "next_episode", _GO, "Next failure",
            "Go to the worst frame of the next listed failure of the active run.",
            lambda: e.go(1), "Shift+N", "next-episode", e.none_listed, section=True,
        ),
        Command(
            "previous_episode", _GO, "Previous failure",
            "Go to the worst frame of the previous listed failure.",
            lambda: e.go(-1), "Shift+P", "previous-episode", e.none_listed,
        ),
        Command(
            "loop_episode", _GO, "Loop failure",
            "Play the selected failure in a loop, with a few frames before and after it.",
            e.toggle_loop, "Shift+Space", "iterate", e.none_listed, e.looping,
        ),
        Command(
            "export_strips", _TRACK, "Export image strips …",
            "Save the frames of each failure side by side, with the model drawn in the lower row, "
            "as PNG.",
            lambda: e.export(video=False), "", "picture", e.none_listed,
        ),
        Command(
            "export_film", _TRACK, "Video …",
            "Save a video of the failures: all views with the model outline and the errors.",
            lambda: e.export(video=True), "", "export", e.none_listed,
        ),
    ]  # fmt: skip
