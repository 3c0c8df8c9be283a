"""Commands about the stretches in which a run fails."""

from __future__ import annotations

from ....services.actions import Command
from .controller import EpisodeController

_GO, _TRACK = "&Go", "&Track/&Episodes"


def commands(e: EpisodeController) -> list[Command]:
    """Commands of the menus Go and Track, Episodes."""
    return [
        Command(
            "next_episode", _GO, "Next episode",
            "Go to the worst frame of the next listed episode of the active run.",
            lambda: e.go(1), "Shift+N", "next-episode", e.none_listed, section=True,
        ),
        Command(
            "previous_episode", _GO, "Previous episode",
            "Go to the worst frame of the listed episode before this one.",
            lambda: e.go(-1), "Shift+P", "previous-episode", e.none_listed,
        ),
        Command(
            "loop_episode", _GO, "Play the episode in a loop",
            "Play the chosen episode again and again, with what is just before and after it.",
            e.toggle_loop, "Shift+Space", "iterate", e.none_listed, e.looping,
        ),
        Command(
            "export_strips", _TRACK, "Picture strips …",
            "Write pictures of episodes beside each other, the model drawn below, as PNG.",
            lambda: e.export(video=False), "", "picture", e.none_listed,
        ),
        Command(
            "export_film", _TRACK, "Video …",
            "Write a video of episodes: all views with the model's outline and the errors.",
            lambda: e.export(video=True), "", "export", e.none_listed,
        ),
    ]  # fmt: skip
