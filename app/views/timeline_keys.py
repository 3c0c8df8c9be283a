"""Keys of the timeline, and its help in words."""

from __future__ import annotations

from types import MappingProxyType

from PySide6.QtCore import Qt

HELP = (
    "Drag to scrub, Shift and drag or drag in the ruler to select frames, wheel to zoom. "
    "Keys: arrows step, Shift and arrows by ten, Page keys by a second, Home and End, "
    "+ - 0 zoom, [ and ] set the selection's ends, Esc clears it. "
    "Ctrl and click on names selects lanes."
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
