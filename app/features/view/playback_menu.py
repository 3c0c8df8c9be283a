"""Commands that go from frame to frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.actions import Command
from ...shell.reasons import no_frames, no_judgement

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Go"


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menu Go."""
    return [
        Command(
            "play", _MENU, "Play or pause", "Play at the recording's own speed, or stay here.",
            w.toggle_playing, "Space", "play", lambda: no_frames(w), lambda: w.document.playing,
        ),
        _go(w, "next", "Next frame", "Show the next frame.", 1, "Right", "step-forward"),
        _go(w, "previous", "Previous frame", "Show the frame before.", -1, "Left", "step-back"),
        _go(w, "next_comma", "Next frame, second key", "Show the next frame.", 1, "."),
        _go(w, "previous_comma", "Previous frame, second key", "Show the frame before.", -1, ","),
        _go(w, "ten_on", "Ten frames on", "Go ten frames on.", 10, "Shift+Right", section=True),
        _go(w, "ten_back", "Ten frames back", "Go ten frames back.", -10, "Shift+Left"),
        Command(
            "first", _MENU, "First frame", "Go to the first frame.",
            lambda: w.document.go_to(0), "Home", "first", lambda: no_frames(w),
        ),
        Command(
            "last", _MENU, "Last frame", "Go to the last frame.",
            lambda: w.document.go_to(w.document.frame_count - 1), "End", "last",
            lambda: no_frames(w),
        ),
        Command(
            "go_to", _MENU, "Go to frame …", "Type the number of a frame.",
            w.transport.type_frame, "Ctrl+G", "search", lambda: no_frames(w),
        ),
        Command(
            "next_above", _MENU, "Next above the threshold",
            "Go to the next stretch in which a limb is above the line of the plot.",
            lambda: w.go_above(1), "N", "next-episode", lambda: no_judgement(w), section=True,
        ),
        Command(
            "previous_above", _MENU, "Previous above the threshold",
            "Go to the stretch before in which a limb is above the line of the plot.",
            lambda: w.go_above(-1), "P", "previous-episode", lambda: no_judgement(w),
        ),
    ]  # fmt: skip


def _go(
    w: MainWindow, name: str, text: str, tip: str, by: int, keys: str, icon: str = "",
    *, section: bool = False,
) -> Command:  # fmt: skip
    return Command(
        name, _MENU, text, tip, lambda: w.document.step(by), keys, icon,
        lambda: no_frames(w), section=section,
    )  # fmt: skip
