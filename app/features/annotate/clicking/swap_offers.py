"""Left and right that were mixed up: offered to be exchanged, until a person says no."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from stereotrack_core.annotation.frame_clicks import ClickHints
from stereotrack_core.annotation.swaps import Swap

from ....widgets.forms.message import Message


class SwapOffers:
    """Which offers are shown, and which have been declined.

    Parameters
    ----------
    exchange : callable
        Exchanges what was mixed up.
    """

    def __init__(self, exchange: Callable[[Swap], None]) -> None:
        self._exchange = exchange
        self._shown: dict[tuple[object, ...], Message] = {}
        self._declined: set[tuple[object, ...]] = set()

    def update(
        self, hints: ClickHints | None, views: Mapping[str, str]
    ) -> tuple[tuple[Message, ...], tuple[Message, ...]]:
        """Messages that hold no longer, and new ones."""
        swaps = {_key(swap): swap for swap in hints.swaps} if hints is not None else {}
        gone = [key for key in self._shown if key not in swaps]
        old = tuple(self._shown.pop(key) for key in gone)
        new = []
        for key, swap in swaps.items():
            if key not in self._shown and key not in self._declined:
                self._shown[key] = self._message(swap, views)
                new.append(self._shown[key])
        return old, tuple(new)

    def dismiss(self, message: Message) -> None:
        """Do not offer this again."""
        for key, shown in tuple(self._shown.items()):
            if shown == message:
                self._declined.add(key)

    def _message(self, swap: Swap, views: Mapping[str, str]) -> Message:
        names = [name.replace("_", " ") for name in (swap.first, swap.second)]
        where = " and ".join(views.get(camera, camera) for camera in swap.cameras)
        sure = (
            "seem to be swapped" if swap.certain else "may be swapped, here or in the other views"
        )
        return Message(
            "warning",
            f"{names[0]} and {names[1]} {sure}: {swap.distance:.0f} px from the prediction of the "
            f"other views, {swap.distance_after:.0f} px if swapped",
            f"{where}, frame {swap.frame}",
            button="Swap them",
            do=lambda: self._exchange(swap),
        )


def _key(swap: Swap) -> tuple[object, ...]:
    return (swap.frame, swap.first, swap.second, swap.cameras)
