"""Keys of the timeline, and its help in words."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

from PySide6.QtCore import Qt

HELP = (
    "Drag to scrub, Shift+drag or drag in the ruler to select frames, scroll to zoom. Keys: "
    "arrows step, Shift+arrows step by ten, Page Up and Page Down by a second, Home and End, + - "
    "0 zoom, [ and ] set the ends of the selection, Esc clears it. Ctrl+click on names, or up and "
    "down, to select lanes; Shift adds."
)
ZOOMS = MappingProxyType({Qt.Key.Key_Plus: 1.5, Qt.Key.Key_Equal: 1.5, Qt.Key.Key_Minus: 1 / 1.5})


def steps(fps: float, frames: int, *, shift: bool) -> dict[Qt.Key, int]:
    """How many frames each key goes on.

    Parameters
    ----------
    fps : float
        The Page keys go by a second.
    frames : int
        Of the recording; Home and End go by all of them.
    shift : bool
        Whether arrows go by ten.
    """
    second = max(1, round(fps))
    one = 10 if shift else 1
    return {
        Qt.Key.Key_Left: -one,
        Qt.Key.Key_Right: one,
        Qt.Key.Key_PageUp: -second,
        Qt.Key.Key_PageDown: second,
        Qt.Key.Key_Home: -frames,
        Qt.Key.Key_End: frames,
    }


def selection_to_here(old: range | None, here: int, frames: int, *, to_end: bool) -> range:
    """The selection when one of its ends is set to the frame that is shown.

    Parameters
    ----------
    old : range or None
    here : int
    frames : int
        Of the recording.
    to_end : bool
        Whether it ends here; else it begins here.
    """
    if to_end:
        return range(min(old.start, here) if old else 0, here + 1)
    return range(here, max(old.stop, here + 1) if old else frames)


def next_lane(names: Sequence[str], selected: frozenset[str], *, down: bool) -> int:
    """Place of the lane after the last (before the first) of those that are selected."""
    places = [place for place, name in enumerate(names) if name in selected]
    if not places:
        return 0 if down else len(names) - 1
    return min(places[-1] + 1, len(names) - 1) if down else max(places[0] - 1, 0)
