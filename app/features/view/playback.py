"""Commands that go from frame to frame."""

from __future__ import annotations

from functools import partial

from ...services.actions import Command
from ...session.session import Session
from ...widgets.timeline.transport import Transport

_MENU = "&Go"


def commands(session: Session, transport: Transport) -> list[Command]:
    """Commands of the menu Go."""
    document = session.document

    def go(
        name: str, text: str, tip: str, by: int, keys: str, icon: str = "", *, section: bool = False
    ) -> Command:
        step = partial(document.step, by)
        return Command(name, _MENU, text, tip, step, keys, icon, session.no_frames, section=section)

    return [
        Command(
            "play", _MENU, "Play / pause", "Play at the recording's frame rate, or pause.",
            document.toggle_playing, "Space", "play", session.no_frames, lambda: document.playing,
        ),
        go("next", "Next frame", "Show the next frame.", 1, "Right", "step-forward"),
        go("previous", "Previous frame", "Show the frame before.", -1, "Left", "step-back"),
        go("next_comma", "Next frame (second key)", "Show the next frame.", 1, "."),
        go("previous_comma", "Previous frame (second key)", "Show the frame before.", -1, ","),
        go("ten_on", "Forward 10 frames",
        "Go forward by 10 frames.", 10, "Shift+Right", section=True),
        go("ten_back", "Back 10 frames", "Go back by 10 frames.", -10, "Shift+Left"),
        Command(
            "first", _MENU, "First frame", "Go to the first frame.",
            lambda: document.go_to(0), "Home", "first", session.no_frames,
        ),
        Command(
            "last", _MENU, "Last frame", "Go to the last frame.",
            lambda: document.go_to(document.frame_count - 1), "End", "last",
            session.no_frames,
        ),
        Command(
            "go_to", _MENU, "Go to frame …", "Enter a frame number.",
            transport.type_frame, "Ctrl+G", "search", session.no_frames,
        ),
    ]  # fmt: skip
