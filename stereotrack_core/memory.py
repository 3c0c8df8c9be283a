"""Results by key, within a limit of memory; those in use are given up last."""

import dataclasses
import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any

import numpy as np

_MOST_BYTES = 1024**3
_SHARE_OF_MACHINE = 0.2


class Memory:
    """Keeps results until a limit in bytes is reached; may be used by several threads.

    Where there is no room, what was not used for longest goes first, and nothing that is held. If
    everything is held, newcomers are not kept: a stretch that is too long keeps its first frames,
    which is better than losing each one before it is used again. Without a `limit` it is a fifth of
    the machine's memory, and at most 1 GiB.
    """

    def __init__(self, limit: int | None = None) -> None:
        self.limit = usual_limit() if limit is None else limit
        self.bytes = 0
        self._lock = threading.Lock()
        self._kept: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()
        self._held: Callable[[Any], bool] = lambda _key: False

    def __len__(self) -> int:
        return len(self._kept)

    def __contains__(self, key: Hashable) -> bool:
        return key in self._kept

    def items(self) -> tuple[tuple[Any, Any], ...]:
        """All that is kept, by key."""
        with self._lock:
            return tuple((key, value) for key, (value, _) in self._kept.items())

    def hold(self, held: Callable[[Any], bool]) -> None:
        """Say by key which results are in use."""
        with self._lock:
            self._held = held

    def get(self, key: Hashable) -> Any | None:
        """What is kept under a key, None where nothing is."""
        with self._lock:
            kept = self._kept.get(key)
            if kept is None:
                return None
            self._kept.move_to_end(key)
            return kept[0]

    def put(self, key: Hashable, value: Any, size: int) -> None:
        """Keep a result of `size` bytes, if there is room or room can be made."""
        with self._lock:
            before = self._kept.pop(key, None)
            self.bytes -= before[1] if before is not None else 0
            if self._make_room(size):
                self._kept[key] = value, size
                self.bytes += size

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._kept.clear()
            self.bytes = 0

    def _make_room(self, size: int) -> bool:
        if size > self.limit or self.bytes + size <= self.limit:
            return size <= self.limit  # giving up all would not be enough, or nothing need go
        for key in list(self._kept):
            if self.bytes + size <= self.limit:
                break
            if not self._held(key):
                self.bytes -= self._kept.pop(key)[1]
        return self.bytes + size <= self.limit


def usual_limit() -> int:
    """Bytes that may be kept on this machine."""
    there = machine_bytes()
    return _MOST_BYTES // 2 if there is None else min(_MOST_BYTES, int(_SHARE_OF_MACHINE * there))


def machine_bytes() -> int | None:
    """The machine's memory; None where the system does not tell it."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None


def bytes_of(value: object) -> int:
    """Bytes of all arrays in a dataclass, and in what it is made of."""
    if isinstance(value, np.ndarray):
        return int(value.nbytes)
    if isinstance(value, Mapping):
        return sum(bytes_of(part) for part in value.values())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return sum(bytes_of(getattr(value, f.name)) for f in dataclasses.fields(value))
    return 0
